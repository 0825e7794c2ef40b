"""What the source of the method published, computed anew: numbers, tables, figures.

`published_values`   numbers printed in Swanbom 2007, as facts -> `PublishedValue`
`reproduced`         each of them beside ours, with a `Verdict` -> `Reproduction`; `MEANINGS` of the verdicts
`PICTURES`           its tables and figures, as functions -> `Picture` of `Chart`s and `Map`s, with `Claim`s of its text
"""

from calibore.published._collection import PICTURES
from calibore.published._pictures import Chart, Claim, Curve, Level, Map, Panel, Picture, Region
from calibore.published._reproduction import MEANINGS, Reproduction, Verdict, reproduced
from calibore.published._values import PublishedValue, published_values

__all__ = [
    "MEANINGS",
    "PICTURES",
    "Chart",
    "Claim",
    "Curve",
    "Level",
    "Map",
    "Panel",
    "Picture",
    "PublishedValue",
    "Region",
    "Reproduction",
    "Verdict",
    "published_values",
    "reproduced",
]

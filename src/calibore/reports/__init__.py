"""The report of a profile: one page that needs nothing but itself.

`finisher`         for `profiling.profile_scan`: pictures, report and exports beside the arrays
`illustrate`       the pictures and the report alone
`write_report`     folder, summary, rings and pictures in; OUT/report.html out
`expanded_text`    `(304.62 ± 0.13) mm`: a value with its expanded uncertainty, rounded to what it can carry
"""

from calibore.reports._finisher import finisher, illustrate
from calibore.reports._numbers import expanded_text
from calibore.reports._report import write_report

__all__ = ["expanded_text", "finisher", "illustrate", "write_report"]

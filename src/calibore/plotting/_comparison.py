"""The pictures of two profiles compared, in the order in which their page shows them."""

from collections.abc import Iterator

from calibore.comparison import Compared
from calibore.plotting._comparison_charts import histogram_chart, radius_chart, rings_chart
from calibore.plotting._comparison_maps import difference_map, significance_map
from calibore.plotting._comparison_rings import registration_chart
from calibore.plotting._design import DesignPicture


def comparison_pictures(found: Compared, *, unit: str = "mm") -> Iterator[DesignPicture]:
    """Every picture of this comparison, one after the other."""
    epochs = found.changes is not None
    what = "change" if epochs else "error"
    drawn = (
        ("difference", f"Map of {what}", difference_map(found, unit=unit),
         "Red: the radius is larger than before (or than the reference), blue: smaller. Grey: not measured in one of "
         "the two."),
        ("significance", "How far beyond chance", significance_map(found, unit=unit),
         "Outlined and numbered: what is more than chance; numbers as in the table." if epochs
         else "Colours are full at twice the 95 % interval."),
        ("registration", "Registration", registration_chart(found, unit=unit),
         "The worst ring, a typical one, and the best."),
        ("histogram", "Distribution", histogram_chart(found, unit=unit),
         "Wider than the curve: the uncertainty is understated; narrower: a common error happened to be small, or "
         "uncertainty is stated for edges that most points are far from."),
        ("radius", f"{what.capitalize()} against radius", radius_chart(found, unit=unit),
         "An error of calibration shows as a curve that leaves zero as a whole."),
        ("rings", "Ring by ring", rings_chart(found, unit=unit),
         "A single bad ring is a bad picture or a bump of the rig."),
    )  # fmt: skip
    for name, title, figure, caption in drawn:
        if figure is not None:
            yield DesignPicture(name, title, caption, figure)

"""The pictures of calibrations, of differences and of plans, in the order in which their pages show them."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from calibore.calibration import Calibration, Difference, Plan
from calibore.plotting._calibration_difference import changes_chart, direction_difference_chart, wall_difference_chart
from calibore.plotting._calibration_models import correlation_chart, model_chart
from calibore.plotting._calibration_parts import camera_of, known_rig, nominal_radius_of
from calibore.plotting._calibration_plan import plan_chart, ranking_chart
from calibore.plotting._calibration_residuals import residual_chart, residual_map
from calibore.plotting._calibration_uncertainty import projection_chart, wall_chart, wall_map_chart
from calibore.plotting._design import DesignPicture

TITLES = {
    "wall": "Uncertainty on the wall",
    "wall_map": "Uncertainty on the wall, over the image",
    "projection": "Uncertainty over the image",
    "residual_map": "Residuals over the image",
    "residuals": "Distribution of the residuals",
    "correlations": "Correlations",
    "models": "Models compared",
    "directions": "Difference over the image",
    "wall_difference": "Difference on the wall",
    "changes": "What changed",
    "plan": "What to photograph next",
    "ranking": "Single pictures compared",
}
CAPTIONS = {
    "wall": "What the calibration leaves unknown of a radius; all points of a scan share it, so no averaging takes it "
    "away. The dashed line is what one gets who keeps the standard uncertainties and forgets the correlations.",
    "wall_map": "Every pixel of the line tells a radius; this is how well the calibration knows it.",
    "projection": "Where pictures of the target were, directions are known; towards the corners they are extrapolated.",
    "residual_map": "A good model leaves noise. Rings, spokes or a drift are what it could not describe.",
    "residuals": "Left: a curve like the drawn one is wanted; heavy tails are outliers. Right: a mean that leaves 0 is "
    "an error of the lens law there.",
    "correlations": "Parameters of a calibration are never used without them.",
    "models": "More parameters always fit better; whether they pay shows on data left out.",
    "directions": "What is left when the second camera is turned so that it agrees best with the first.",
    "wall_difference": "Outside the band the rigs differ by more than both calibrations admit.",
    "changes": "Correlated parameters hide behind each other: a change of one often shows as a change of several.",
    "plan": "Predicted from the geometry alone, before any picture is taken.",
    "ranking": "What each of them would bring if it were the only one.",
}


def calibration_pictures(
    calibration: Calibration, *, nominal_radius: float | None = None, unit: str = "mm"
) -> Iterator[DesignPicture]:
    """Every picture that this calibration has, one after the other; on walls round `nominal_radius` [m], by default the
    middle of the radii it is valid for.
    """
    yield from _drawn(_of_calibration(calibration, nominal_radius_of(calibration, nominal_radius), unit))


def difference_pictures(difference: Difference, *, unit: str = "mm") -> Iterator[DesignPicture]:
    """Of two calibrations compared."""
    charts = (
        ("directions", direction_difference_chart(difference)),
        ("wall_difference", wall_difference_chart(difference, unit=unit)),
        ("changes", changes_chart(difference)),
    )
    yield from _drawn(iter(charts))


def plan_pictures(plan: Plan, *, unit: str = "mm") -> Iterator[DesignPicture]:
    """Of what to photograph next."""
    yield from _drawn(iter((("plan", plan_chart(plan, unit=unit)), ("ranking", ranking_chart(plan, unit=unit)))))


def _of_calibration(
    calibration: Calibration, nominal_radius: float | None, unit: str
) -> Iterator[tuple[str, Figure | None]]:
    rig, camera, valid = known_rig(calibration), camera_of(calibration), calibration.valid
    if rig is not None and nominal_radius is not None:
        yield "wall", wall_chart(rig, valid, nominal_radius=nominal_radius, unit=unit)
        yield "wall_map", wall_map_chart(rig, valid, nominal_radius=nominal_radius, unit=unit)
    if camera is not None:
        yield "projection", projection_chart(camera, calibration.covariance, valid)
    yield "residual_map", residual_map(calibration, unit=unit)
    yield "residuals", residual_chart(calibration, unit=unit)
    yield "correlations", correlation_chart(calibration.covariance)
    yield "models", model_chart(calibration)


def _drawn(charts: Iterator[tuple[str, Figure | None]]) -> Iterator[DesignPicture]:
    for name, figure in charts:
        if figure is not None:
            yield DesignPicture(name, TITLES[name], CAPTIONS[name], figure)

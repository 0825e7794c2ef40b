"""What comes after the measuring: pictures, report and exports, put beside the arrays before they get their name."""

from collections.abc import Sequence
from pathlib import Path

from calibore.plotting import DETECTED_LINE_TITLE, STANDARD_PICTURES, detected_line, length_unit, save_picture
from calibore.profiling import Finisher, Sealed
from calibore.reports._report import write_report
from calibore.scans import ScanSpec, check_format, default_export_name, export, open_profile, read_rings


def finisher(*, unit: str = "mm", pictures: bool = True, exports: Sequence[str] = ()) -> Finisher:
    """For `profile_scan`: draws the pictures and the report in `unit` and writes `exports`.

    Raises InputError at once for a unit or format that is not known.
    """
    length_unit(unit)
    for format in exports:
        check_format(format)

    def finish(sealed: Sealed) -> None:
        if pictures:
            illustrate(sealed, unit=unit)
        for format in exports:
            export(sealed.folder, format, sealed.folder / default_export_name(format))

    return finish


def illustrate(sealed: Sealed, *, unit: str) -> None:
    """The standard pictures as PNG files in `sealed.folder`, and report.html with all of them inside."""
    rings, nominal = read_rings(sealed.folder), sealed.spec.nominal_radius
    drawn: dict[str, Path] = {}
    with open_profile(sealed.folder) as dataset:
        for picture in STANDARD_PICTURES:
            figure = picture(
                dataset, rings, nominal_radius=nominal, unit=unit, **_limits(sealed.spec).get(picture.name, {})
            )
            drawn[picture.title] = save_picture(figure, sealed.folder / f"{picture.name}.png")
    if sealed.example is not None:
        image, stripe = sealed.example
        figure = detected_line(image, stripe.u, stripe.v, stripe.status)
        drawn[DETECTED_LINE_TITLE] = save_picture(figure, sealed.folder / "detected_line.png")
    write_report(sealed.folder, summary=sealed.summary, rings=rings, pictures=drawn, unit=unit)


def _limits(spec: ScanSpec) -> dict[str, dict[str, float]]:
    """The limit lines that the scan file asks for, by picture."""
    found: dict[str, dict[str, float]] = {}
    if spec.limit_ovality_percent is not None:
        found["ovality_along"] = {"limit": spec.limit_ovality_percent}
    if spec.limit_deflection_percent is not None:
        found["diameter_along"] = {"limit": 2 * spec.nominal_radius * (1 - spec.limit_deflection_percent / 100)}
    return found

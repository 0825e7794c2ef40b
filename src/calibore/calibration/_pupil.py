"""Kind "two-pin": at which reading of the slide the entrance pupil stands over the pivot (Swanbom 2007, 7.2).

A camera that turns about its pupil sees two pins at different distances move alike; about any other point, the nearer
one moves more (pupil ahead of the pivot) or less (behind it).
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from calibore.calibration._calibration import Calibration, Observations
from calibore.calibration._pupil_fit import PupilFit, fit_pupil
from calibore.calibration._pupil_model import PUPIL, SLIDE, TURN
from calibore.calibration._pupil_target import TwoPinPictures, read_two_pin, said_length
from calibore.optics import LENS_LAWS
from calibore.uncertainty import Covariance

FAR_OFF = 0.5
"""Extrapolation by more than this fraction of the slide's span asks for another picture."""
SURE = 0.999
STRANGE = 4.0
"""Readings that would have to be wrong by so many of their standard uncertainties are named."""


def calibrate_pupil(path: Path | str, *, progress: Callable[[int, int], None] | None = None) -> Calibration:
    """The pupil from the pictures that `path`, a target.toml or its folder, names; `progress(done, total)` pictures.

    Raises InputError saying which evidence is missing: one turntable angle or slide only, pins not found, pins at one
    distance, near and far interchanged.
    """
    pictures = read_two_pin(Path(path), progress=progress)
    target = pictures.target
    found = fit_pupil(
        pictures.seen,
        slides=pictures.slides,
        size=(pictures.width, pictures.height),
        laws=(target.lens,) if target.lens else tuple(LENS_LAWS),
        u_slide=target.u_slide,
        u_turntable=target.u_turntable,
    )
    fit, pupil = found.fit, found.pupil
    settings = {"slide": f"{pupil.value!r} m", "first_slide": f"{pictures.slides.min()!r} m"}
    settings["last_slide"] = f"{pictures.slides.max()!r} m"
    return Calibration(
        kind=target.kind,
        rig=None,
        camera=None,
        values={PUPIL: pupil.value},
        covariance=Covariance([PUPIL], [[pupil.u**2]], degrees_of_freedom=[pupil.degrees_of_freedom]),
        degrees_of_freedom=pupil.degrees_of_freedom,
        noise=fit.noise,
        group_sigma=fit.group_sigma,
        files=pictures.files,
        observations=_observations(found),
        models=found.comparisons,
        settings={"pupil": settings},
        findings=tuple(_findings(found, pictures)),
        warnings=tuple(_warnings(found, pictures)),
    )


def _observations(found: PupilFit) -> Observations:
    fit, seen = found.fit, found.seen
    return Observations(
        file=seen.picture,
        u=seen.u,
        v=seen.v,
        residual=fit.residuals,
        sigma=fit.sigma,
        weight=fit.weights,
        group=2 * seen.picture + seen.near,
        jacobian=fit.jacobian,
        names=fit.names,
    )


def _findings(found: PupilFit, pictures: TwoPinPictures) -> Iterator[str]:
    pupil, slides, unit = found.pupil, pictures.slides, pictures.unit
    low, high = (said_length(end, unit) for end in pupil.interval())
    yield (
        f"The entrance pupil stands over the pivot at a slide reading of {said_length(pupil.value, unit)} "
        f"(u = {said_length(pupil.u, unit, digits=5)}, 95 %: {low} to {high}); set the slide there."
    )
    beyond = max(pupil.value - slides.max(), slides.min() - pupil.value)
    if beyond > 0:
        yield (
            f"That is {said_length(beyond, unit)} beyond the readings photographed ({said_length(slides.min(), unit)} to "
            f"{said_length(slides.max(), unit)}): an extrapolation, which the stated uncertainty contains."
        )
    used = np.unique(found.seen.slide)
    for slide in slides[used[np.argsort(slides[used], kind="stable")]]:
        yield _side(float(slide), found, unit)
    if len(found.comparisons) > 1:
        best = found.comparisons[0]
        yield (
            f"The pictures fit a lens of the law {best.model} best (rmse {best.rmse:.3f} px; next "
            f"{found.comparisons[1].model}, {found.comparisons[1].rmse:.3f} px); over the laws tried the pupil lies between "
            f"{' and '.join(said_length(end, unit) for end in _span(found))}."
        )


def _span(found: PupilFit) -> tuple[float, float]:
    values = [one.estimates[PUPIL].value for one in found.comparisons]
    return min(values), max(values)


def _side(slide: float, found: PupilFit, unit: str) -> str:
    """Which side of the pivot the pupil lies on at a slide reading."""
    from scipy.special import stdtr

    ahead = found.model.forwards * (found.pupil.value - slide)
    freedom = min(found.pupil.degrees_of_freedom, 1e9)
    sure = float(stdtr(freedom, abs(ahead) / found.pupil.u))
    where = "ahead of" if ahead > 0 else "behind"
    said = f"more than {100 * SURE:g}" if sure > SURE else f"{100 * sure:.1f}"
    return (
        f"At {said_length(slide, unit)} the pupil lies {said_length(abs(ahead), unit)} {where} the pivot ({said} % sure): "
        f"the near pin moves {'more' if ahead > 0 else 'less'} than the far one."
    )


def _warnings(found: PupilFit, pictures: TwoPinPictures) -> Iterator[str]:
    slides, fit, target = pictures.slides, found.fit, pictures.target
    refused = [file for file in pictures.files if file.refused]
    if refused:
        yield f"{len(refused)} of {len(pictures.files)} pictures were left out; the first: {refused[0].name}: {refused[0].refused}."
    beyond = max(found.pupil.value - slides.max(), slides.min() - found.pupil.value)
    if beyond > FAR_OFF * np.ptp(slides):
        yield (
            "The pupil was found far beyond the slide readings photographed; photograph the pins at a reading on the other "
            "side of it as well."
        )
    if found.model.forwards < 0:
        yield "A greater slide reading moves the camera forwards here, not back."
    for prefix, u, what in ((SLIDE, target.u_slide, "slide reading"), (TURN, target.u_turntable, "turntable reading of picture")):
        yield from _strange(fit.names, fit.values, prefix, u, what, slides)


def _strange(names: tuple[str, ...], values, prefix: str, u: float, what: str, slides) -> Iterator[str]:
    for name, value in zip(names, values, strict=True):
        if name.startswith(prefix):
            number = int(name.removeprefix(prefix))
            off = value - slides[number] if prefix == SLIDE else value
            if abs(off) > STRANGE * u:
                yield (
                    f"The {what} {number} would have to be wrong by {abs(off) / u:.0f} standard uncertainties; read it again, "
                    "or state how well it is read (u_slide, u_turntable)."
                )

"""Kind "two-pin": at which reading of the slide the entrance pupil stands over the pivot (Swanbom 2007, 7.2).

A camera that turns about its pupil sees two pins at different distances move alike; about any other point, the nearer
one moves more (pupil ahead of the pivot) or less (behind it).
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Calibration, Observations
from calibore.calibration._evidence import of_fit
from calibore.calibration._in_words import Unit
from calibore.calibration._pupil._fit import PupilFit, fit_pupil
from calibore.calibration._pupil._model import PUPIL, SLIDE, TURN
from calibore.calibration._pupil._target import TwoPinPictures, read_two_pin
from calibore.optics import LENS_LAWS
from calibore.uncertainty import Covariance

Array = NDArray[np.float64]

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
    ends = {"slide": pupil.value, "first_slide": pictures.slides.min(), "last_slide": pictures.slides.max()}
    settings = {name: f"{float(place)!r} m" for name, place in ends.items()}
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
        whitened=_with_doubt(found) if found.pupil.u > fit.u[fit.names.index(PUPIL)] else None,
        **of_fit(fit),
    )


def _with_doubt(found: PupilFit) -> Array:
    """Root of the information that is left when the doubt about the law is counted: residuals cannot tell it."""
    total = found.fit.covariance.copy()
    index = found.fit.names.index(PUPIL)
    total[index, index] = found.pupil.u**2
    u = np.sqrt(np.diag(total))
    return np.linalg.inv(np.linalg.cholesky(total / np.outer(u, u))) / u


def _findings(found: PupilFit, pictures: TwoPinPictures) -> Iterator[str]:
    pupil, slides, unit = found.pupil, pictures.slides, pictures.unit
    low, high = (unit.said(end, pupil.u) for end in pupil.interval())
    yield (
        f"The entrance pupil stands over the pivot at a slide reading of {unit.said(pupil.value, pupil.u)} "
        f"(u = {unit.said(pupil.u, pupil.u)}, 95 %: {low} to {high}); set the slide there."
    )
    beyond = _beyond(found, slides)
    if beyond > 0:
        yield (
            f"That is {unit.said(beyond, pupil.u)} beyond the readings photographed "
            f"({unit.said(slides.min(), pupil.u)} to {unit.said(slides.max(), pupil.u)}): an extrapolation, which the "
            "stated uncertainty contains."
        )
    used = np.unique(found.seen.slide)
    for slide in slides[used[np.argsort(slides[used], kind="stable")]]:
        yield _side(float(slide), found, unit)
    if len(found.comparisons) > 1:
        best, second, *_ = found.comparisons
        span = [one.estimates[PUPIL].value for one in found.comparisons]
        yield (
            f"The pictures fit a lens of the law {best.model} best (rmse {best.rmse:.3f} px; next {second.model}, "
            f"{second.rmse:.3f} px); over all laws tried the pupil lies between {unit.said(min(span), pupil.u)} and "
            f"{unit.said(max(span), pupil.u)}."
        )


def _beyond(found: PupilFit, slides: Array) -> float:
    """How far [m] the pupil lies beyond the readings photographed; negative between them."""
    return float(max(found.pupil.value - slides.max(), slides.min() - found.pupil.value))


def _side(slide: float, found: PupilFit, unit: Unit) -> str:
    """Which side of the pivot the pupil lies on at a slide reading."""
    from scipy.special import stdtr

    pupil = found.pupil
    ahead = found.model.forwards * (pupil.value - slide)
    sure = float(stdtr(min(pupil.degrees_of_freedom, 1e9), abs(ahead) / pupil.u))
    said = f"more than {100 * SURE:g}" if sure > SURE else f"{100 * sure:.1f}"
    return (
        f"At {unit.said(slide, pupil.u)} the pupil lies {unit.said(abs(ahead), pupil.u)} "
        f"{'ahead of' if ahead > 0 else 'behind'} the pivot ({said} % sure): the near pin moves "
        f"{'more' if ahead > 0 else 'less'} than the far one."
    )


def _warnings(found: PupilFit, pictures: TwoPinPictures) -> Iterator[str]:
    slides, target = pictures.slides, pictures.target
    refused = [file for file in pictures.files if file.refused]
    if refused:
        yield (
            f"{len(refused)} of {len(pictures.files)} pictures were left out; the first, {refused[0].name}: "
            f"{refused[0].refused}."
        )
    if _beyond(found, slides) > FAR_OFF * np.ptp(slides):
        yield (
            "The pupil was found far beyond the slide readings photographed; photograph the pins at a reading on the "
            "other side of it as well."
        )
    if found.model.forwards < 0:
        yield "A greater slide reading moves the camera forwards here, not back; that is taken into account."
    yield from _strange(found, SLIDE, target.u_slide, "The slide reading", slides)
    yield from _strange(found, TURN, target.u_turntable, "The turntable's angle", np.zeros(len(pictures.files)))


def _strange(found: PupilFit, prefix: str, u: float, what: str, read: Array) -> Iterator[str]:
    """Readings that the pictures contradict; those of the turntable belong to a picture."""
    for name, value in zip(found.fit.names, found.fit.values.tolist(), strict=True):
        if name.startswith(prefix):
            number = int(name.removeprefix(prefix))
            off = abs(value - read[number]) / u
            if off > STRANGE:
                yield (
                    f"{what} number {number + 1} would have to be wrong by {off:.0f} standard uncertainties; check it, "
                    "or state in target.toml how well it is read (u_slide, u_turntable)."
                )

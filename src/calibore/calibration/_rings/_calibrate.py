"""Kind "concentric-rings": lens law, k, D, centre and small misalignment from photographs (Swanbom 2007, 6.2).

All marks on all rings and spokes of all photographs are fitted together: the camera, and the target's place in each.
"""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._calibration import Calibration
from calibore.calibration._input_files import input_file
from calibore.calibration._lens_models import lens_models
from calibore.calibration._rings._choice import BASELINE, Trial, recommended, tried
from calibore.calibration._rings._fit import RingFit, final_fit, fit_all, fit_lens
from calibore.calibration._rings._model import PLANE, Printed, target_names
from calibore.calibration._rings._pictures import RingPictures, read_ring_pictures
from calibore.calibration._rings._result import Outcome, comparisons, observations_of, outcome_of, valid_region
from calibore.calibration._rings._sight import Sight
from calibore.calibration._rings._start import ring_radii
from calibore.calibration._rings._words import check, findings, warnings
from calibore.errors import InputError
from calibore.fitting import information_criteria

Array = NDArray[np.float64]

EVIDENT = 4.0
"""Of Akaike's criterion: by so much errors of the print must explain the marks better than errors of the picture."""


def calibrate_rings(path: Path | str, *, progress: Callable[[int, int], None] | None = None) -> Calibration:
    """Camera and plane of light from the photographs that `path`, a target.toml or its folder, names.

    The light is taken to stand where the target stood in the first one, straight across. `progress(done, total)`
    counts photographs and lens models.

    Raises InputError saying which evidence is missing: target not found, too few rings, a view too narrow to tell k
    from D, a perspective lens.
    """
    count = _Count(progress)
    pictures = read_ring_pictures(path, progress=count.of_photographs)
    sight = sight_of(pictures)
    outcome = evaluated(sight, pictures.target.lens, done=count.another)
    check(outcome, pictures)
    fit, rig = outcome.ring_fit.fit, outcome.across
    assert rig.covariance is not None
    observations = observations_of(outcome, pictures.used)
    place = _place(outcome) | {"ink_width": sight.printed.ink_width}
    return Calibration(
        kind=pictures.target.kind,
        rig=rig,
        camera=rig.camera,
        values={name: fit.value(name) for name in rig.covariance.names},
        covariance=rig.covariance,
        degrees_of_freedom=fit.degrees_of_freedom,
        noise=fit.noise,
        group_sigma=fit.group_sigma * observations.typical_load,
        files=(*pictures.files, input_file(pictures.toml)),
        observations=observations,
        valid=valid_region(outcome),
        models=comparisons(outcome, lens_models(pictures.target.lens)),
        settings={"target": place},
        findings=tuple(findings(outcome, pictures)),
        warnings=tuple(warnings(outcome, pictures)),
    )


def sight_of(pictures: RingPictures) -> Sight:
    """All marks, and what target.toml says."""
    target = pictures.target
    ink = _ink_width(pictures) if target.ink_width is None else target.ink_width
    return Sight(
        printed=Printed(pictures.radii, target.spokes, ink),
        marks=pictures.marks,
        size=pictures.size,
        nominal_baseline=target.nominal_baseline,
        u_ring=target.u_ring,
        principal_point=target.principal_point,
        u_baseline=target.u_baseline,
        square=target.square_pixels,
    )


def evaluated(sight: Sight, law: str | None = None, *, done: Callable[[int], None] = lambda total: None) -> Outcome:
    """All lenses, or those of one `law`, fitted and compared, and what follows from the recommended one."""
    lenses = lens_models(law)
    short, fits = fit_all(sight, lenses, done=lambda: done(len(lenses)))
    trials = [tried(ring_fit, short) for ring_fit in fits.values()]
    chosen = recommended(trials)
    return outcome_of(_resistant(short, chosen), chosen, trials, short)


def _resistant(sight: Sight, chosen: Trial) -> RingFit:
    """The same lens once more, without the stretches that disagree. Where nothing is stated of the printed radii, the
    marks tell whether rings err as printed [m] or as pictured [px].
    """
    lens, start, of_print = chosen.lens, chosen.ring_fit.fit.values, False
    with suppress(InputError):
        if sight.u_ring is None:
            printed = fit_lens(sight, lens, start=start, of_print=True)
            of_print = information_criteria(printed.fit).aicc < chosen.aicc - EVIDENT
        return final_fit(sight, chosen.ring_fit, of_print=of_print)
    return chosen.ring_fit


def _ink_width(pictures: RingPictures) -> float:
    """Of the lines [m], as wide as they look beside the distance from ring to ring; 0 where their width is unknown."""
    found = []
    for marks in pictures.marks:
        printed, image = ring_radii(marks, pictures.radii)
        per_metre = np.gradient(image, printed)
        for radius, scale in zip(printed, per_metre, strict=True):
            on_ring = np.isclose(pictures.radii[np.maximum(marks.ring, 1) - 1], radius) & (marks.ring > 0)
            if marks.width is not None:
                found.append(float(np.median(marks.width[on_ring])) / scale)
    return float(np.median(found)) if found else 0.0


def _place(outcome: Outcome) -> dict[str, float]:
    """Where the target's centre was in the first photograph and how it was held, SI; u of its slopes."""
    names = [name for name in target_names(0) if name != BASELINE]
    place = {name.split(".")[1]: outcome.ring_fit.fit.value(name) for name in names}
    return place | {f"u_{name.split('.')[1]}": outcome.value(name).u for name in PLANE[1:]}


class _Count:
    """Photographs, then lens models, told as one count."""

    def __init__(self, progress: Callable[[int, int], None] | None) -> None:
        self._progress, self._photographs, self._models = progress, 0, 0

    def of_photographs(self, done: int, total: int) -> None:
        self._photographs = total
        if self._progress is not None:
            self._progress(done, total + len(lens_models()))

    def another(self, total: int) -> None:
        self._models += 1
        if self._progress is not None:
            self._progress(self._photographs + self._models, self._photographs + total)

"""The marks of all pictures of a ring target and where they should be: the model that is fitted."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibore.calibration._lens_models import ASPECT, CENTRE, LensModel
from calibore.calibration._rings._prediction import Aims, predict
from calibore.calibration._rings._target import RingTarget
from calibore.errors import InputError
from calibore.optics import Camera
from calibore.rigs import Laser, Rig
from calibore.targets import RingMarks

Array = NDArray[np.float64]
Whole = NDArray[np.intp]

PLANE = ("laser.baseline", "laser.tilt_x", "laser.tilt_y")
FINDER = ("finder.right", "finder.down", "finder.outwards")


class Printed(NamedTuple):
    """What is printed: `radii` [m] of the rings, innermost first, how many `spokes`, `ink_width` [m] of the lines."""

    radii: Array
    spokes: int
    ink_width: float = 0.0


@dataclass(frozen=True, eq=False)
class RingModel:
    """Predicts where the marks of several pictures of one target lie; a model for `fitting.least_squares`.

    Parameters `names`: those of the `lens`, the pixels' aspect unless `square`, the principal point, the `RingTarget`
    of each picture; `FINDER`: how far [px] all marks are found too far right, down, and those of rings outwards; with
    `printed_errors` the error [m] of each ring's printed radius.
    """

    lens: LensModel
    printed: Printed
    marks: tuple[RingMarks, ...]
    size: tuple[int, int]
    square: bool = False
    printed_errors: bool = False
    names: tuple[str, ...] = field(init=False)

    def __post_init__(self) -> None:
        names = [*self.lens.parameters, *(() if self.square else (ASPECT,)), *CENTRE]
        names += [name for number in range(len(self.marks)) for name in target_names(number)]
        names += FINDER
        if self.printed_errors:
            names += [f"target.ring_{ring}" for ring in range(1, self.printed.radii.size + 1)]
        object.__setattr__(self, "names", tuple(names))

    def __call__(self, values: Array) -> tuple[Array, Array]:
        """Residuals (n,) [px] along each mark's direction, measured minus predicted, and the Jacobian (n, p) of the
        predictions; NaN for marks that the lens does not image.
        """
        try:
            camera, targets = self.camera(values), [self.target(values, i) for i in range(len(self.marks))]
            rigs = [Rig("perpendicular-plane", camera, (Laser(target.plane),)) for target in targets]
        except InputError:  # no such camera: a step that went too far
            n = sum(marks.u.size for marks in self.marks)
            return np.full(n, np.nan), np.full((n, len(self.names)), np.nan)
        parts = [self._one_picture(values, rig, targets[i], i) for i, rig in enumerate(rigs)]
        residuals, jacobians = zip(*parts, strict=True)
        return np.concatenate(residuals), np.concatenate(jacobians)

    def pixels_per_metre(self, values: Array) -> Array:
        """(n,) how far [px] each mark moves along its direction if its line is printed 1 m farther out or aside."""
        scales = []
        for number, marks in enumerate(self.marks):
            scale, rig, target = np.zeros(marks.u.size), self.rig(values, number), self.target(values, number)
            for rows in _rings_and_spokes(marks):
                scale[rows] = 1 / predict(rig, target, self._aims(values, marks, rows)).slope
            scales.append(scale)
        return np.concatenate(scales)

    def camera(self, values: Array) -> Camera:
        return self.lens.camera(dict(zip(self.names, values, strict=True)), width=self.size[0], height=self.size[1])

    def target(self, values: Array, number: int) -> RingTarget:
        """Where the target was in picture `number`."""
        place = dict(zip(self.names, values, strict=True))
        return RingTarget(*(float(place[name]) for name in target_names(number)))

    def rig(self, values: Array, number: int) -> Rig:
        """The camera, and a plane of light where the target was in picture `number`."""
        laser = Laser(self.target(values, number).plane)
        return Rig("perpendicular-plane", self.camera(values), (laser,))

    def _one_picture(self, values: Array, rig: Rig, target: RingTarget, number: int) -> tuple[Array, Array]:
        marks, known = self.marks[number], [name for name in rig.parameter_names if name not in PLANE]
        residuals, jacobian = np.zeros(marks.u.size), np.zeros((marks.u.size, len(self.names)))
        columns = [self.names.index(name) for name in target_names(number)]
        fitted = [i for i, name in enumerate(known) if name in self.names]
        cameras = [self.names.index(known[i]) for i in fitted]
        finder = [self.names.index(name) for name in FINDER]
        for rows in _rings_and_spokes(marks):
            line = predict(rig, target, self._aims(values, marks, rows))
            shared = np.column_stack([marks.direction[rows], np.sign(line.slope) * (marks.ring[rows] > 0)])
            residuals[rows] = -line.shift - shared @ values[finder]
            jacobian[rows[:, None], finder] = shared
            jacobian[rows[:, None], columns] = -line.by_target / line.slope[:, None]
            jacobian[rows[:, None], cameras] = -line.by_camera[:, fitted] / line.slope[:, None]
            if self.printed_errors and marks.ring[rows[0]]:
                jacobian[rows, len(self.names) - self.printed.radii.size + marks.ring[rows] - 1] = 1 / line.slope
        return residuals, jacobian

    def _aims(self, values: Array, marks: RingMarks, rows: Whole) -> Aims:
        radii = self.printed.radii
        if self.printed_errors:
            radii = radii + values[-radii.size :]
        radius = radii[marks.ring[rows] - 1] if marks.ring[rows[0]] else None
        angle = np.asarray(marks.spoke[rows] * (2 * np.pi / self.printed.spokes), dtype=float)
        return Aims(marks.u[rows], marks.v[rows], marks.direction[rows], radius, angle, self.printed.ink_width)


def _rings_and_spokes(marks: RingMarks) -> list[Whole]:
    rows = np.flatnonzero(marks.ring > 0), np.flatnonzero(marks.ring == 0)
    return [some for some in rows if some.size]


def target_names(number: int) -> tuple[str, ...]:
    """Names of the place of the target in picture `number`; in the first it is where the rig's light shall be."""
    if number == 0:
        return (*PLANE, "target.centre_x", "target.centre_y", "target.roll")
    return tuple(f"target.{number}.{name}" for name in RingTarget.parameter_names)

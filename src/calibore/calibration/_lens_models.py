"""The lens models that calibrations choose from, and the camera that a parameter vector makes of one."""

from collections.abc import Mapping
from dataclasses import dataclass

from calibore.errors import InputError
from calibore.optics import LENS_LAWS, LENS_NAMES, Camera, Lens

CENTRE = ("camera.principal_point_u", "camera.principal_point_v")
ASPECT = "camera.aspect"
RESIDUAL = ("c1", "c2")


@dataclass(frozen=True)
class LensModel:
    """`law` by name and the `extras` that are fitted beside k: c1, c2, or polynomial_3, polynomial_5, ..."""

    law: str
    extras: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        if self.law == "polynomial":
            return f"polynomial to power {self.extras[-1].removeprefix('polynomial_')}"
        return f"{self.law} + {', '.join(self.extras)}" if self.extras else self.law

    @property
    def parameters(self) -> tuple[str, ...]:
        """Dotted paths of the lens's parameters."""
        return ("camera.k", *(f"camera.{extra}" for extra in self.extras))

    def camera(self, values: Mapping[str, float], *, width: int, height: int) -> Camera:
        """The camera with `values` by dotted path; without one: square pixels, principal point in the image's middle,
        an ideal lens.
        """
        extras = tuple(values.get(f"camera.{extra}", 0.0) for extra in self.extras)
        c1, c2 = extras if self.extras == RESIDUAL else (0.0, 0.0)
        polynomial = extras if self.law == "polynomial" else ()
        lens = Lens(self.law, values["camera.k"], height / 2, c1, c2, polynomial)
        middle = middle_of(width, height)
        point = values.get(CENTRE[0], middle[0]), values.get(CENTRE[1], middle[1])
        return Camera(width, height, lens, point, values.get(ASPECT, 1.0))


def middle_of(width: int, height: int) -> tuple[float, float]:
    """The middle of an image [px], pixel (0, 0) being the centre of the first."""
    return (width - 1) / 2, (height - 1) / 2


LENS_MODELS: tuple[LensModel, ...] = (
    *(LensModel(law) for law in LENS_LAWS),
    *(LensModel(law, RESIDUAL) for law in LENS_LAWS),
    *(LensModel("polynomial", tuple(f"polynomial_{power}" for power in range(3, last + 1, 2))) for last in (3, 5, 7)),
)
"""Five laws of one parameter, each with its radial residual, and the general odd polynomial."""


def lens_models(law: str | None = None) -> tuple[LensModel, ...]:
    """All models, or those of one `law`; raises InputError where there is none of that name."""
    if law is not None and law not in LENS_NAMES:
        raise InputError(f'Lens law "{law}" is not known; allowed: {", ".join(LENS_NAMES)}.')
    return tuple(model for model in LENS_MODELS if law in (None, model.law))

"""Light that no laser sent: lamps that shine in a wet wall, text that the robot writes into its pictures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibore.documents import filled
from calibore.errors import InputError
from calibore.rigs import Rig
from calibore.simulation._light import Stray, area_per_point, inside_image
from calibore.simulation._parts import require_positive, smooth_step

ACROSS = 6.0  # px, standard deviation beyond which no crescent grows in the picture
SPACING = 0.5  # px between its points


@dataclass(frozen=True)
class Lamp:
    """A white crescent where the wall, `distance` [m] ahead of the rig, reflects a lamp: about rig `clock` and `width`
    [rad] wide, `length` [m] (standard deviation) along the pipe, `brightness` its peak of full scale.
    """

    distance: float
    clock: float = 0.0
    width: float = np.pi / 2
    length: float = 0.02
    brightness: float = 1.0

    def __post_init__(self) -> None:
        require_positive(distance_of_a_lamp=self.distance, width_of_a_lamp=self.width, length_of_a_lamp=self.length)
        if not 0 <= self.brightness <= 100:
            raise InputError(f"The brightness of a lamp must be between 0 and 100, got {self.brightness:g}.")

    def shine(self, rig: Rig, nominal_radius: float, *, psf_sigma: float) -> Stray:
        """Its light in the picture of `rig` in a pipe of `nominal_radius` [m]."""
        u, v = self._project(rig, nominal_radius, np.linspace(-1.0, 1.0, 401))
        length = float(np.nansum(np.hypot(np.diff(u), np.diff(v))))
        place = np.linspace(-1.0, 1.0, max(int(length / SPACING), 3))
        u, v = self._project(rig, nominal_radius, place)
        taper = smooth_step(1.5 * (1 - np.abs(place)))
        further = np.stack(self._project(rig, nominal_radius, place, further=self.length), axis=1)
        spread = np.nan_to_num(further - np.stack([u, v], axis=1)) * taper[:, None]
        spread *= np.minimum(1.0, ACROSS / np.maximum(np.linalg.norm(spread, axis=1), 1e-9))[:, None]
        energy = self.brightness * taper * area_per_point(u, v, spread, psf_sigma)
        return Stray(u, v, spread, np.where(inside_image(u, v, rig), energy, 0.0))

    def _project(
        self, rig: Rig, nominal_radius: float, place: NDArray[np.float64], *, further: float = 0.0
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        clock = self.clock + self.width / 2 * place
        x, y = nominal_radius * np.sin(clock), -nominal_radius * np.cos(clock)
        return rig.project(np.column_stack([x, y, np.full(place.shape, self.distance + further)]))


@dataclass(frozen=True)
class Overlay:
    """`text` in the picture, its upper left corner at (`u`, `v`) [px], letters of `height` [px], `brightness` of full
    scale; {station} and {axial} [m] in it are filled in.
    """

    text: str
    u: float = 20.0
    v: float = 20.0
    height: float = 24.0
    brightness: float = 1.0

    def __post_init__(self) -> None:
        require_positive(height_of_an_overlay=self.height)
        if not 0 <= self.brightness <= 1:
            raise InputError(f"The brightness of an overlay must be between 0 and 1, got {self.brightness:g}.")
        try:
            filled(self.text, station=0, axial=0.0)
        except (LookupError, ValueError, AttributeError, TypeError) as error:
            raise InputError(f'The overlay "{self.text}" may hold {{station}} and {{axial}} only.') from error

    def write_on(self, image: NDArray[np.uint8 | np.uint16], *, station: int, axial: float) -> None:
        """Write it over the pixels of `image` (h, w, 3)."""
        from PIL import Image, ImageDraw, ImageFont

        mask = Image.new("L", (image.shape[1], image.shape[0]))
        text = self.text.format(station=station, axial=axial)
        ImageDraw.Draw(mask).text((self.u, self.v), text, fill=255, font=ImageFont.load_default(self.height))
        cover = (np.asarray(mask, dtype=np.float32) / 255)[..., None]
        white = self.brightness * np.iinfo(image.dtype).max
        image[...] = np.rint(image * (1 - cover) + white * cover).astype(image.dtype)

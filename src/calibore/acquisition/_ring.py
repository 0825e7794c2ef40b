"""What is kept of a measured station: all that the result folder and its summary are made of."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from calibore.acquisition._journal import Arrays
from calibore.metrics import RingQuantities
from calibore.profiling import RefusedImage, StationResult, row_quantities
from calibore.scans import RingPoints, RingProfile

COUNTS = ("images", "scale", "take_correlation")


@dataclass(frozen=True)
class KeptRing:
    """As `StationResult`, without pictures; `takes` of the station, `timed` where its picture has a time."""

    profile: RingProfile
    points: RingPoints
    row: Mapping[str, Any]
    quantities: RingQuantities
    images: int
    unlit: tuple[int, ...]
    refused: tuple[RefusedImage, ...]
    scale: float
    take_correlation: float
    takes: tuple[int, ...]
    timed: bool

    @classmethod
    def of(cls, result: StationResult, takes: tuple[int, ...], *, timed: bool) -> "KeptRing":
        names = ("profile", "points", "row", "quantities", "unlit", "refused", *COUNTS)
        return cls(**{name: getattr(result, name) for name in names}, takes=takes, timed=timed)

    def record(self) -> tuple[dict[str, Any], Arrays]:
        """For the journal."""
        header: dict[str, Any] = {"kind": "ring", "row": dict(self.row), "unlit": self.unlit, "takes": self.takes}
        header |= {name: getattr(self, name) for name in (*COUNTS, "timed")}
        header["refused"] = [[image.name, image.reason] for image in self.refused]
        arrays = {f"points.{one.name}": getattr(self.points, one.name) for one in fields(RingPoints)}
        header["profile"] = {}
        for one in fields(RingProfile):
            value = getattr(self.profile, one.name)
            if isinstance(value, np.ndarray):
                arrays[f"profile.{one.name}"] = value
            else:
                header["profile"][one.name] = value
        return header, arrays

    @classmethod
    def from_record(cls, header: Mapping[str, Any], arrays: Arrays) -> "KeptRing":
        def part(name: str) -> dict[str, Any]:
            return {key.partition(".")[2]: value for key, value in arrays.items() if key.startswith(f"{name}.")}

        return cls(
            RingProfile(**header["profile"], **part("profile")),
            RingPoints(**part("points")),
            header["row"],
            row_quantities(header["row"]),
            header["images"],
            tuple(header["unlit"]),
            tuple(RefusedImage(*image) for image in header["refused"]),
            header["scale"],
            header["take_correlation"],
            tuple(header["takes"]),
            header["timed"],
        )

"""Walls seen twice, and their result folders: for tests of comparisons, their pictures, pages and command."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import xarray
from registration_walls import random_motion, random_wall, seen

from calibore.comparison import compared

STATIONS = np.arange(0, 0.1, 0.01)
DENT = np.array([0.05, 2.0, 0.004, 0.02, 0.2])
"""Axial [m], clock [rad], height inwards [m], widths [m], [rad]."""


@cache
def pair(seed=3, *, dented=False):
    """(later or measured, earlier or reference) profiles of one random wall from places apart."""
    rng = np.random.default_rng([70, seed])
    wall = random_wall(rng, length=0.1)
    later = replace(wall, bumps=np.concatenate([wall.bumps, [DENT]])) if dented else wall
    before = seen(wall, STATIONS, rng, positions=200, modes=(3e-4,))
    motion = random_motion(rng, station=0.01, stations=0.5)
    return seen(later, STATIONS, rng, positions=200, motion=motion, modes=(3e-4,)), before


@cache
def found(*, epochs):
    """A comparison of each question; with a dent and two years between epochs."""
    after, before = pair(dented=epochs)
    return compared(after, before, epochs=epochs, names=("later", "earlier"), years=2.0 if epochs else None)


def only_where(profile, kept):
    """The profile with values only where `kept` (n, m) or (n, 1) says so; no rings without any, as in files."""
    gone = {name: np.where(kept, getattr(profile, name), np.nan) for name in ("radius", "axial_position")}
    left = replace(profile, **gone, status=np.where(kept, profile.status, 3).astype(np.uint8))
    return left.rings(np.flatnonzero(np.isfinite(left.radius).any(axis=1)))


def scaled(profile, factor):
    grown = {name: factor * getattr(profile, name) for name in ("radius", "u_independent", "common_mode")}
    return replace(profile, **grown)


def misread(profile, factor, *, ahead=0.0):
    """The profile of an odometer whose positions are `factor` times too long, of a rig that looks `ahead` [m]."""
    stations = profile.axial - ahead
    return replace(
        profile,
        axial=factor * stations,
        axial_position=profile.axial_position + (factor * stations - profile.axial)[:, None] + ahead,
    )


def write_result(folder, profile, *, tactile=False):
    """A result folder with this profile, as far as comparing reads it."""
    ring = ("station", "clock")
    grids = {name: (ring, getattr(profile, name)) for name in ("radius", "axial_position", "u_independent", "status")}
    variables = {
        **grids,
        "common_mode": (("mode", *ring), profile.common_mode),
        "noise_correlation": (("station", "lag"), profile.correlation),
    }
    places = {"axial": ("station", profile.axial), "clock": ("clock", profile.clock)}
    attributes = {"format": "calibore-profile/1", "title": folder.name, "nominal_radius": profile.nominal_radius}
    attributes |= {"scan_date": profile.date.isoformat()} if profile.date else {}
    folder.mkdir(parents=True)
    xarray.Dataset(variables, coords=places, attrs=attributes).to_zarr(folder / "profile.zarr", zarr_format=3)
    counts = {"readings": 1} if tactile else {"images": 1}
    (folder / "summary.json").write_text(json.dumps({"counts": counts}), encoding="utf-8")
    return folder

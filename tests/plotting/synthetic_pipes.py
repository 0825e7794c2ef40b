"""Profiles of imagined 12 in pipes in the form of `calibore.scans`, for pictures and reports that need one."""

from typing import Any

import numpy as np

RADIUS = 0.1524
U_COMMON, U_INDEPENDENT = 0.00018, 0.00006


def bump(clock: Any, axial: Any, *, at: float, along: float, width: float, length: float) -> Any:
    """A smooth bump 0..1 about clock `at` [rad] and axial `along` [m]."""
    turn = np.angle(np.exp(1j * (clock - at)))
    return np.exp(-0.5 * (turn / width) ** 2 - 0.5 * ((axial - along) / length) ** 2)


def synthetic_radius(clock: Any, axial: Any, *, seed: int = 0) -> Any:
    """Radius (station, clock) [m] about the pipe axis: growing ovality, two dents, an opening, a rail at the invert."""
    length = max(float(np.max(axial)), 0.25)
    grid_axial, grid_clock = axial[:, None], clock[None, :]
    radius = RADIUS + 0.0004 * (1 + 2 * grid_axial / length) * np.cos(2 * (grid_clock - 0.3))
    radius = radius - 0.006 * bump(grid_clock, grid_axial, at=4.4, along=0.3 * length, width=0.18, length=0.08 * length)
    radius = radius - 0.003 * bump(grid_clock, grid_axial, at=0.8, along=0.7 * length, width=0.10, length=0.03 * length)
    opening = bump(grid_clock, grid_axial, at=1.6, along=0.5 * length, width=0.12, length=0.05 * length)
    radius = np.where(opening > 0.6, radius + 0.015, radius)
    radius = np.where(np.abs(np.angle(np.exp(1j * (grid_clock - np.pi)))) < 0.09, radius - 0.02, radius)
    return radius + np.random.default_rng(seed).normal(0, 0.5 * U_INDEPENDENT, radius.shape)


def synthetic_profile(
    axial: Any,
    *,
    missing: float = 0.03,
    clock_count: int = 400,
    centre: tuple[float, float] = (0.0, 0.0),
    seed: int = 0,
) -> Any:
    """An xarray.Dataset as `open_profile` gives it; the rig axis lies at minus `centre` [m] from the pipe's."""
    import xarray

    generator = np.random.default_rng(seed)
    axial = np.asarray(axial, float)
    clock = np.arange(clock_count) * 2 * np.pi / clock_count
    own = synthetic_radius(clock, axial, seed=seed)
    offset = np.hypot(*centre) * np.cos(clock - np.arctan2(centre[0], -centre[1]))
    radius = offset + np.sqrt(own**2 - np.hypot(*centre) ** 2 + offset**2)
    status = np.zeros(radius.shape, np.uint8)
    starts = generator.integers(0, clock_count, len(axial))
    for row, start in enumerate(starts):
        status[row, (start + np.arange(int(missing * clock_count))) % clock_count] = 3
    radius[status == 3] = np.nan
    dims = ("station", "clock")
    u = np.full(radius.shape, U_INDEPENDENT) * (1 + 0.6 * np.cos(clock) ** 2)
    return xarray.Dataset(
        {
            "radius": (dims, radius),
            "axial_position": (dims, np.broadcast_to(axial[:, None], radius.shape)),
            "u_independent": (dims, np.where(status == 3, np.nan, u)),
            "u_common": (dims, np.full(radius.shape, U_COMMON)),
            "common_mode": (("mode", *dims), np.full((1, *radius.shape), U_COMMON)),
            "status": (dims, status),
            "centre_x": ("station", np.full(len(axial), centre[0])),
            "centre_y": ("station", np.full(len(axial), centre[1])),
        },
        coords={"station": np.arange(len(axial)) * 11, "axial": ("station", axial), "clock": clock},
    )


def synthetic_rings(dataset: Any) -> dict[str, np.ndarray]:
    """Columns of rings.csv computed plainly from the points (no bias correction: these are pictures, not results)."""
    clock = dataset["clock"].values
    x, y = dataset["radius"].values * np.sin(clock), -dataset["radius"].values * np.cos(clock)
    own = np.hypot(x - dataset["centre_x"].values[:, None], y - dataset["centre_y"].values[:, None])
    diameters = own + np.roll(own, len(clock) // 2, axis=1)
    empty = ~np.isfinite(diameters).any(axis=1)
    diameters[empty] = 0.0
    mean, low, high = (f(diameters, axis=1) for f in (np.nanmean, np.nanmin, np.nanmax))
    deviation = np.where(np.isfinite(diameters), np.abs(diameters - 2 * RADIUS), -1)
    measured = np.isfinite(own)
    wave = np.where(measured, own - RADIUS, 0) @ np.exp(-2j * clock) / np.maximum(measured.sum(axis=1), 1)
    columns = {
        "axial_m": dataset["axial"].values,
        "points": measured.sum(axis=1).astype(float),
        "fraction": measured.mean(axis=1),
        "centre_x_m": dataset["centre_x"].values,
        "centre_y_m": dataset["centre_y"].values,
        "diameter_mean_m": mean,
        "diameter_min_m": low,
        "diameter_max_m": high,
        "ovality_f1216_max_percent": 100 * (high - mean) / np.maximum(mean, 1e-9),
        "ovality_f1216_min_percent": 100 * (mean - low) / np.maximum(mean, 1e-9),
        "ovality_range_percent": 100 * (high - low) / np.maximum(mean, 1e-9),
        "ovality_harmonic_percent": 200 * np.abs(wave) / RADIUS,
        "deflection_percent": 100 * (2 * RADIUS - low) / (2 * RADIUS),
        "deflection_clock_rad": clock[np.argmax(deviation, axis=1)],
    }
    columns |= {f"u_{name}": np.full(len(mean), 2 * U_COMMON) for name in columns if name.startswith("diameter")}
    columns |= {f"u_{name}": np.full(len(mean), 0.08) for name in columns if name.endswith("percent")}
    rings = {
        name: np.where(empty & (name not in ("axial_m", "points", "fraction")), np.nan, v)
        for name, v in columns.items()
    }
    return {"station": dataset["station"].values, **rings, "flags": np.where(empty, "no-ring", "")}

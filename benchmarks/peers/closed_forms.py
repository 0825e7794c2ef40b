"""Peers: radius, axial position and their uncertainty from the closed forms, in plain NumPy and with `uncertainties`.

Swanbom 2007, eqs. 3-26 to 3-37 and 4-9 to 4-12, corrected (one nappe, both roots, the right discriminant), for an
equidistant lens; partial derivatives by implicit differentiation of the quadratic.
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Inputs:
    """`geometry`: baseline, aim, half angle of a cone; baseline and two slopes of a plane. `k` [px/rad]; `factor`
    (4, 4) of the covariance of geometry and k; `centre` (u, v) and `u_pixel` [px]; `radius` near which the wall is.
    """

    geometry: tuple[float, float, float]
    k: float
    factor: np.ndarray
    centre: tuple[float, float]
    u_pixel: float
    radius: float


def cone(u, v, given):
    """(7, n): radius, axial, clock, independent and common u of radius, the same of axial."""
    (baseline, aim, half_angle), k = given.geometry, given.k
    x, y = u - given.centre[0], v - given.centre[1]
    r = np.sqrt(x * x + y * y)
    cos_azimuth, sin_azimuth, zenith = x / r, -y / r, r / k
    sine, cosine = np.sin(zenith), np.cos(zenith)
    sin_aim, cos_aim, sin_half, cos_half = np.sin(aim), np.cos(aim), np.sin(half_angle), np.cos(half_angle)
    twist, rest = sin_half**2 - cos_aim**2, sin_aim**2 - cos_half**2
    across = sin_azimuth * sine
    steep = cos_aim * cosine - sin_aim * across
    square = steep * steep - cos_half**2
    linear = across * twist - cosine * (sin_aim * cos_aim)
    root = cos_half * np.sqrt(sin_half**2 * (1 - across * across) - (cos_aim * cos_azimuth * sine) ** 2)
    sum_ = linear - root
    near, far = baseline * rest / sum_, baseline * sum_ / square
    away = [np.where(t > 0, np.abs(np.log(np.where(t > 0, t, 1) * sine / given.radius)), np.inf) for t in (near, far)]
    t = np.where(away[1] < away[0], far, near)
    slope = 2 * (square * t - baseline * linear)
    turned = -(sin_aim * (sin_azimuth * cosine) + cos_aim * sine)
    lifted = (twist * sin_azimuth) * cosine + (sin_aim * cos_aim) * sine
    by_zenith = -2 * t * (steep * turned * t - baseline * lifted) / slope
    along = sine * cos_azimuth
    by_azimuth = 2 * t * along * (steep * sin_aim * t + baseline * twist) / slope
    by_aim = (
        -2 * t * (steep * -(sin_aim * cosine + cos_aim * across) * t)
        + 2 * baseline * t * (across * (2 * sin_aim * cos_aim) - cosine * (cos_aim**2 - sin_aim**2))
        - baseline**2 * (2 * sin_aim * cos_aim)
    ) / slope
    by_half = -2 * (sin_half * cos_half) * (t * t - 2 * baseline * t * across + baseline**2) / slope
    geometry = (t / baseline, by_aim, by_half)
    return _assembled(given, t, (by_zenith, by_azimuth), geometry, (sine, cosine, zenith, r, x, y))


def plane(u, v, given):
    """The same for a plane z = baseline + x slope_x + y slope_y."""
    (baseline, slope_x, slope_y), k = given.geometry, given.k
    x, y = u - given.centre[0], v - given.centre[1]
    r = np.sqrt(x * x + y * y)
    cos_azimuth, sin_azimuth, zenith = x / r, y / r, r / k
    sine, cosine = np.sin(zenith), np.cos(zenith)
    tilt = slope_x * cos_azimuth + slope_y * sin_azimuth
    slope = cosine - sine * tilt
    t = baseline / slope
    by_slope = t / slope
    by_zenith = by_slope * (sine + cosine * tilt)
    by_azimuth = by_slope * sine * (slope_y * cos_azimuth - slope_x * sin_azimuth)
    geometry = (1 / slope, by_slope * sine * cos_azimuth, by_slope * sine * sin_azimuth)
    return _assembled(given, t, (by_zenith, by_azimuth), geometry, (sine, cosine, zenith, r, x, y))


def _assembled(given, t, by_ray, geometry, ray):
    """From the distance along the ray and its derivatives to radius and axial with uncertainty."""
    sine, cosine, zenith, r, x, y = ray
    result = np.empty((7, t.size))
    result[0], result[1] = t * sine, t * cosine
    result[2] = np.arctan2(x, -y) % (2 * np.pi)
    gradient = np.empty((4, t.size))
    by_zeniths = by_ray[0] * sine + result[1], by_ray[0] * cosine - result[0]
    for i, (part, by_zenith) in enumerate(zip((sine, cosine), by_zeniths, strict=True)):
        radial, azimuthal = by_zenith / given.k, by_ray[1] * part / r
        result[3 + 2 * i] = given.u_pixel * np.sqrt(radial * radial + azimuthal * azimuthal)
        for row, by_parameter in zip(gradient, geometry, strict=False):
            np.multiply(by_parameter, part, out=row)
        np.multiply(radial, -zenith, out=gradient[3])
        modes = given.factor.T @ gradient
        result[4 + 2 * i] = np.sqrt(np.einsum("mn,mn->n", modes, modes))
    return result


def in_blocks(form, u, v, given, *, block=8192):
    """The same, block by block, so that NumPy's temporaries stay in the cache."""
    result = np.empty((7, u.size))
    for start in range(0, u.size, block):
        part = slice(start, start + block)
        result[:, part] = form(u[part], v[part], given)
    return result


def by_uncertainties(kind, u, v, given):
    """Point by point with the package `uncertainties`: radius and axial as correlated numbers."""
    from uncertainties import correlated_values, ufloat
    from uncertainties.umath import cos, sin, sqrt

    *geometry, k = correlated_values((*given.geometry, given.k), given.factor @ given.factor.T)
    results = np.empty((4, u.size))
    for i in range(u.size):
        x, y = ufloat(u[i], given.u_pixel) - given.centre[0], ufloat(v[i], given.u_pixel) - given.centre[1]
        r = sqrt(x * x + y * y)
        sine, cosine, c, s = sin(r / k), cos(r / k), x / r, y / r
        if kind == "plane":
            t = geometry[0] / (cosine - sine * (geometry[1] * c + geometry[2] * s))
        else:
            t = _cone_distance(sine, cosine, c, -s, geometry, given.radius, (sin, cos, sqrt))
        radius, axial = t * sine, t * cosine
        results[:, i] = radius.n, axial.n, radius.s, axial.s
    return results


def _cone_distance(sine, cosine, cos_azimuth, sin_azimuth, geometry, wall, functions):
    (baseline, aim, half_angle), (sin, cos, sqrt) = geometry, functions
    sin_aim, cos_aim, sin_half, cos_half = sin(aim), cos(aim), sin(half_angle), cos(half_angle)
    across = sin_azimuth * sine
    linear = across * (sin_half**2 - cos_aim**2) - cosine * (sin_aim * cos_aim)
    disc = sin_half**2 * (1 - across * across) - (cos_aim * cos_azimuth * sine) ** 2
    if disc.n < 0:
        return disc * np.nan
    sum_ = linear - cos_half * sqrt(disc)
    near = baseline * (sin_aim**2 - cos_half**2) / sum_
    far = baseline * sum_ / ((cos_aim * cosine - sin_aim * across) ** 2 - cos_half**2)
    return min(
        (t for t in (near, far) if t.n > 0), key=lambda t: abs(np.log(t.n * sine.n / wall)), default=near * np.nan
    )

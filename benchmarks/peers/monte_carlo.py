"""Peer: Monte Carlo of the closed forms in vectorised NumPy, one pixel after the other, all draws at once."""

import numpy as np


def cone(pixels, given, draws, rng):
    """(n, 4): mean and standard deviation of radius and axial, lost draws left out. `pixels` (u, v, far): where they
    are, and which root counts; `given` as in `closed_forms`.
    """
    baseline, aim, half_angle, k = _inputs(given, draws, rng)
    sin_aim, cos_aim, sin_half, cos_half = np.sin(aim), np.cos(aim), np.sin(half_angle), np.cos(half_angle)
    square_sine, square_cosine = sin_half**2, cos_half**2
    twist, rest, product = square_sine - cos_aim**2, sin_aim**2 - square_cosine, sin_aim * cos_aim

    def distance(sine, cosine, cos_azimuth, sin_azimuth, far):
        across = -sin_azimuth * sine
        disc = square_sine * (1 - across * across) - (cos_aim * cos_azimuth * sine) ** 2
        total = across * twist - cosine * product - cos_half * np.sqrt(disc)
        if not far:
            return baseline * rest / total
        steep = cos_aim * cosine - sin_aim * across
        return baseline * total / (steep * steep - square_cosine)

    return np.array([_moments(pixel, given, k, rng, distance) for pixel in zip(*pixels, strict=True)])


def plane(pixels, given, draws, rng):
    """The same for a plane, which has one root."""
    baseline, slope_x, slope_y, k = _inputs(given, draws, rng)

    def distance(sine, cosine, cos_azimuth, sin_azimuth, far):
        return baseline / (cosine - sine * (slope_x * cos_azimuth + slope_y * sin_azimuth))

    return np.array([_moments(pixel, given, k, rng, distance) for pixel in zip(*pixels, strict=True)])


def _inputs(given, draws, rng):
    return np.array((*given.geometry, given.k))[:, None] + given.factor @ rng.standard_normal((4, draws))


def _moments(pixel, given, k, rng, distance):
    u, v, far = pixel
    noise = rng.standard_normal((2, k.size)) * given.u_pixel
    x, y = noise[0] + (u - given.centre[0]), noise[1] + (v - given.centre[1])
    r = np.sqrt(x * x + y * y)
    zenith = r / k
    sine, cosine = np.sin(zenith), np.cos(zenith)
    t = distance(sine, cosine, x / r, y / r, far)
    t[~(t > 0)] = np.nan
    radius, axial = t * sine, t * cosine
    return np.nanmean(radius), np.nanstd(radius, ddof=1), np.nanmean(axial), np.nanstd(axial, ddof=1)

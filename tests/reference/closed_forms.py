"""Closed forms of Swanbom 2007 as witnesses; corrected where the equation book (equations.md) says that print is wrong.

Lengths in nominal radii, angles in radians; `theta`: zenith, `phi`: azimuth from the right, y up. Calibore is not used.
"""

import numpy as np
from numpy import arctan, cos, sin, sqrt, tan


def ray(theta, phi):
    """(n, 3) of the forward-looking camera, in the frame of formats.md (y down)."""
    return np.stack([cos(phi) * sin(theta), -sin(phi) * sin(theta), cos(theta)], axis=-1)


def side_ray(theta, phi, alpha):
    """(n, 3), eq. 5-3 to 5-5 turned into the head frame."""
    across, ahead = sin(phi) * sin(theta), cos(theta)
    return np.stack(
        [across * cos(alpha) - ahead * sin(alpha), ahead * cos(alpha) + across * sin(alpha), cos(phi) * sin(theta)], -1
    )


def radicand(theta, phi, alpha, psi):
    """Eq. 3-32, corrected: the factor sin^2(psi) belongs to both terms."""
    both = sin(psi) ** 2 * (cos(phi) ** 2 + sin(phi) ** 2 * cos(theta) ** 2)
    return both - cos(alpha) ** 2 * cos(phi) ** 2 * sin(theta) ** 2


def radicand_as_printed(theta, phi, alpha, psi):
    """Eq. 3-32."""
    first = sin(psi) ** 2 * cos(phi) ** 2 + sin(phi) ** 2 * cos(theta) ** 2
    return first - cos(alpha) ** 2 * cos(phi) ** 2 * sin(theta) ** 2


def denominator(theta, phi, alpha, psi):
    """Eq. 3-31 as printed: (axis . ray)^2 - cos^2(psi)."""
    square = sin(theta) ** 2 * sin(phi) ** 2 - sin(2 * alpha) * sin(2 * theta) * sin(phi) / 2 - cos(psi) ** 2
    return square + cos(alpha) ** 2 * (cos(2 * theta) + cos(phi) ** 2 * sin(theta) ** 2)


def b_star(theta, phi, alpha, psi):
    """Eq. 3-33 as printed."""
    return sin(phi) * sin(theta) * (sin(psi) ** 2 - cos(alpha) ** 2) - cos(theta) * sin(2 * alpha) / 2


def cone_radius(theta, phi, d, *, alpha, psi, sign, negated=True, under_root=radicand):
    """Eq. 3-37; `negated`: B* and denominator both with the other sign, as 3-41 to 3-45 presuppose."""
    turn = -1 if negated else 1
    root = cos(psi) * sqrt(under_root(theta, phi, alpha, psi))
    numerator = turn * b_star(theta, phi, alpha, psi) + sign * root
    return d * sin(theta) * numerator / (turn * denominator(theta, phi, alpha, psi))


def zenith_labelled_3_35(phi, alpha, psi):
    """Printed as the zero of the denominator; it is that of the discriminant, and needs |cos(phi)|."""
    ca, sa, s, c = cos(alpha) ** 2, sin(alpha) ** 2, sin(psi) ** 2, cos(psi) ** 2
    above = 1 - c * sin(phi) ** 2 - cos(phi) ** 2 * sa
    below = ca**2 * cos(phi) ** 2 - ca * s * cos(2 * phi) - sin(phi) ** 2 * s**2
    return arctan(sin(psi) / np.abs(cos(phi)) * sqrt(above / below))


def zenith_of_tangent(phi, alpha, psi):
    """Eq. 3-35 simplified: two planes through pupil and apex, straight lines in a perspective image."""
    return arctan(sin(psi) / sqrt(cos(alpha) ** 2 - sin(psi) ** 2) / np.abs(cos(phi)))


def zenith_labelled_3_36(phi, alpha, psi):
    """Printed as the zero of the discriminant; it is that of the denominator."""
    root = cos(psi) * sqrt(sin(psi) ** 2 - cos(phi) ** 2 * sin(alpha) ** 2)
    return arctan((cos(alpha) ** 2 - cos(psi) ** 2) / (root + sin(phi) * sin(2 * alpha) / 2))


def plane_radius(theta, phi, d, *, alpha, beta):
    """Eq. 4-12 and 4-15; its height is d times the same factor. Valid while the factor is positive."""
    factor = 1 / (1 - tan(alpha) * tan(theta) * cos(phi - beta))
    return d * tan(theta) * factor, d * factor


def plane_slopes(theta, phi, d, *, alpha, beta):
    """Eq. 4-18, 4-19 corrected, 4-20, 4-21, 4-22: dR by theta, phi, d, alpha, beta."""
    t, factor = tan(theta), 1 / (1 - tan(alpha) * tan(theta) * cos(phi - beta))
    turning = d * t**2 * tan(alpha) * sin(phi - beta) * factor**2
    leaning = d * t**2 * cos(phi - beta) / cos(alpha) ** 2 * factor**2
    return d / cos(theta) ** 2 * factor**2, -turning, t * factor, leaning, turning


def turning_as_printed(theta, phi, d, *, alpha, beta):
    """Eq. 4-19."""
    factor = 1 / (1 - tan(alpha) * tan(theta) * cos(phi - beta))
    return d * sin(theta) ** 2 * tan(alpha) * sin(phi - beta) * factor**2


def side_radius(theta, phi, d, *, alpha):
    """Eq. 5-17 and 5-18: radius and height in the sheet."""
    q = tan(alpha) - sin(phi) * tan(theta)
    return d * (1 + sin(phi) * tan(theta) * tan(alpha)) / q, d * cos(phi) * tan(theta) / cos(alpha) / q


def side_slopes(theta, phi, d, *, alpha):
    """Eq. 5-26, 5-28, 5-30, 5-32 (dR) and 5-27, 5-29, 5-31, 5-33 (dH) by theta, phi, d, alpha: (2, 4, n)."""
    t, ta, s, c, ca = tan(theta), tan(alpha), sin(phi), cos(phi), cos(alpha)
    q = ta - s * t
    common = d / cos(theta) ** 2 / ca**2 / q**2
    of_radius = [common * s, d * c * t / ca**2 / q**2, (1 + s * t * ta) / q, -d / ca**2 * (s**2 * t**2 + 1) / q**2]
    turning, opening = d * t / ca * (t - ta * s) / q**2, -d * t * c / ca * (s * t * ta + 1) / q**2
    return np.array([of_radius, [common * c * sin(alpha), turning, t * c / ca / q, opening]])


def coaxial_point(r, f, *, a, w):
    """Eq. 2-1 and 2-2: (R, Z); true if Z and the apex `a` are both measured from the image plane, the lens at f."""
    return r * tan(w) * (f - a) / (r - f * tan(w)), f * (r - a * tan(w)) / (r - f * tan(w))


def reversed_image_radius(radius, f, *, m, alpha):
    """Eq. 2-8: of a cone that opens towards the camera, its apex at m."""
    return f * radius / (m - radius / tan(alpha))


def beside_points(x, y, f, *, b, w, square):
    """Eq. 2-3 to 2-5: (2, 3, n) X, Y, Z of both roots; `square`: f^2 in the denominators, printed without."""
    t = tan(w)
    root = sqrt(t**2 * f**2 * (y**2 + (x + b) ** 2) - y**2 * b**2)
    below = x**2 + y**2 - square * t**2
    points = []
    for signed in (root, -root):
        scale = (x * b + t**2 * f**2 + signed) / below
        points.append([x * scale - b / 2, y * scale, f * (x**2 + x * b + y**2 + signed) / below])
    return np.array(points)


def beside_line(x, f, *, b, w, arm):
    """Eq. 2-6 and 2-7: (X, Z) on the row through the lens; `arm`: x + b, printed x - b."""
    return b / 2 + f * tan(w) * arm / (x - f * tan(w)), f * (x + b) / (x - f * tan(w))

"""What chapters 6 to 8 of Swanbom 2007 print of the experiment: facts, in the units of the print."""

from typing import NamedTuple

INCH = 0.0254
NOMINAL_RADIUS = 6 * INCH
PLANES = (3, 6, 12, 30)
"""in; the nominal baselines of the perpendicular plane."""
INSTRUMENTS = (*(f"plane-{baseline}in" for baseline in PLANES), "cone-3in", "side-2.4in")
"""The lasers of the experiment; the cone is of chapter 3, not of the dissertation's experiment."""


class Fitted(NamedTuple):
    """A lens law fitted to one target (Table 6.1): baseline [in], k [px], rmse [in]."""

    baseline: float
    k: float
    rmse: float


TABLE_6_1: dict[str, dict[int, Fitted]] = {
    "perspective": {
        3: Fitted(4.035, 259.0, 0.887),
        6: Fitted(7.519, 304.2, 1.298),
        12: Fitted(11.6, 413.6, 0.607),
        30: Fitted(18.48, 608.2, 0.127),
    },
    "stereographic": {
        3: Fitted(1.871, 465.2, 0.109),
        6: Fitted(3.746, 529.6, 0.136),
        12: Fitted(8.397, 742.3, 0.106),
        30: Fitted(24.1, 1646.0, 0.051),
    },
    "equidistant": {
        3: Fitted(2.394, 287.5, 0.097),
        6: Fitted(4.724, 325.3, 0.115),
        12: Fitted(10.06, 442.3, 0.104),
        30: Fitted(28.02, 956.6, 0.051),
    },
    "sine-law": {
        3: Fitted(3.574, 399.3, 0.088),
        6: Fitted(6.85, 446.3, 0.084),
        12: Fitted(13.1, 571.0, 0.101),
        30: Fitted(34.36, 1173.0, 0.051),
    },
    "equisolid-angle": {
        3: Fitted(2.658, 628.0, 0.092),
        6: Fitted(5.207, 708.5, 0.106),
        12: Fitted(10.83, 950.3, 0.103),
        30: Fitted(29.8, 2035.0, 0.051),
    },
}


class Head(NamedTuple):
    """A side-facing head: baseline [in], aim [deg], f [deg per px]."""

    baseline: float
    aim: float
    per_pixel: float


DESIGNED, EXTRINSIC, INTRINSIC = Head(2.4, 20.5, 0.018), Head(2.355, 19.9, 0.0175), Head(2.359, 19.8, 0.018)
"""Tables 7.1 and 8.1."""
HEAD_CHANGE = Head(0.15, -0.68, 2.58)
"""per cent, Table 8.1: from the calibration on the bench to the one in the pipe; the parameters above are rounded."""


class Conditioning(NamedTuple):
    """How a profile had to be moved onto the tactile one (Table 8.2): roll [deg], shifts [in], scale."""

    roll: float
    shift_x: float
    shift_y: float
    scale: float | None


TABLE_8_2 = {
    "plane-3in": Conditioning(0.964, 0.0374, 0.0061, 0.997),
    "plane-6in": Conditioning(0.818, 0.0232, -0.0102, 1.005),
    "plane-12in": Conditioning(0.563, 0.0111, -0.0102, 1.006),
    "plane-30in": Conditioning(1.036, 0.0131, 0.0163, 0.997),
    "side-2.4in": Conditioning(0.964, -0.0192, 0.0306, None),
}


class Judged(NamedTuple):
    """Predicted uncertainty and "approximate worst case", rms plus standard deviation of absolute errors [in]."""

    predicted: float
    worst_case: float


TABLE_8_3 = {
    "plane-3in": Judged(0.0532, 0.0554),
    "plane-6in": Judged(0.0351, 0.0404),
    "plane-12in": Judged(0.0308, 0.0352),
    "plane-30in": Judged(0.0309, 0.0203),
    "side-2.4in": Judged(0.019, 0.0327),
}
"""And section 8.4.3 for the side-facing head."""
OUTLIER = 0.15 * INCH
"""m; errors beyond do not count (8.4.1)."""
PROBE = (5.2405, 4.5706)
"""in; slope and intercept of the tactile probe (8.2)."""
SPREAD = 0.6
"""Standard deviation of the absolute errors over their rms: "about 60 %" (8.4.2.1)."""

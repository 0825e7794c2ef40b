"""Every standard picture, for pipes of every kind."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from io import BytesIO

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from synthetic_pipes import RADIUS, synthetic_profile, synthetic_rings

from calibore.errors import InputError
from calibore.plotting import STANDARD_PICTURES, deviation_map, save_picture

UNEQUAL = [0, 0.0254, 0.0508, 0.15, 0.4, 0.45]


def _pipe(axial, **options):
    return synthetic_profile(axial, **{"clock_count": 120} | options)


def _nothing_measured():
    profile = _pipe([0.0, 0.01, 0.02])
    profile["radius"][:] = np.nan
    return profile


PIPES = {
    "one station": lambda: synthetic_profile([0.3]),
    "six stations, unequal steps": lambda: synthetic_profile(UNEQUAL),
    "two hundred stations": lambda: _pipe(np.arange(200) * 0.00254, centre=(0.004, -0.006)),
    "half missing": lambda: _pipe(np.arange(40) * 0.02, missing=0.45),
    "nothing measured": _nothing_measured,
    "backwards, no centre": lambda: _pipe(UNEQUAL[::-1]).drop_vars(["centre_x", "centre_y"]),
    "unknown positions": lambda: _pipe(UNEQUAL).assign_coords(axial=("station", [0, 1, np.nan, 2, 3, 4])),
    "a kilometre, sixteen clock positions": lambda: _pipe(np.arange(12) * 80.0, clock_count=16),
}


def _rings(profile):
    if "centre_x" in profile:
        return synthetic_rings(profile)
    zero = ("station", np.zeros(profile.sizes["station"]))
    rings = synthetic_rings(profile.assign(centre_x=zero, centre_y=zero))
    return {name: values for name, values in rings.items() if not name.startswith("centre")}


def _draw(picture, profile, **options) -> Figure:
    return picture(profile, _rings(profile), nominal_radius=RADIUS, **options)


def _touches_the_edge(picture: np.ndarray) -> bool:
    """Something other than white in the outermost two pixels: words or axes that are cut off."""
    frame = np.ones(picture.shape[:2], bool)
    frame[2:-2, 2:-2] = False
    return bool((picture[frame][:, :3] < 1).any())


@pytest.mark.parametrize("kind", PIPES)
def test_every_picture_of_every_pipe_is_1200_pixels_wide_with_nothing_cut_off(kind, tmp_path):
    profile = PIPES[kind]()
    for number, picture in enumerate(STANDARD_PICTURES):
        figure = _draw(picture, profile, unit=("mm", "in")[number % 2])
        path = save_picture(figure, tmp_path / f"{picture.name}.png")
        drawn = imread(path)
        assert drawn.shape[1] == 1200
        assert not _touches_the_edge(drawn), picture.name


@pytest.mark.parametrize("unit", ["mm", "in"])
def test_axes_say_what_they_show_and_in_which_unit(unit):
    profile = synthetic_profile(UNEQUAL)
    expected = {
        "deviation_map": (f"axial position along the pipe [{unit}]", "clock position [h], looking along travel"),
        "uncertainty_map": (f"axial position along the pipe [{unit}]", "clock position [h], looking along travel"),
        "ovality_along": (f"axial position along the pipe [{unit}]", "ovality [% of mean diameter]"),
        "diameter_along": (f"axial position along the pipe [{unit}]", f"diameter [{unit}]"),
    }
    for picture in STANDARD_PICTURES:
        axes = _draw(picture, profile, unit=unit).axes
        if picture.name in expected:
            assert (axes[0].get_xlabel(), axes[0].get_ylabel()) == expected[picture.name]
        if picture.name.endswith("_map") or picture.name == "shaded_view":
            assert f"[{unit}]" in axes[-1].get_ylabel()


def test_a_long_pipe_reads_in_metres_or_feet():
    profile = _pipe(np.arange(12) * 80.0)
    for unit, long_unit in (("mm", "m"), ("in", "ft")):
        axes = deviation_map(profile, _rings(profile), nominal_radius=RADIUS, unit=unit).axes[0]
        assert f"[{long_unit}]" in axes.get_xlabel()


def test_pictures_drawn_in_threads_equal_those_drawn_one_by_one():
    profile = _pipe(UNEQUAL)

    def png(picture) -> bytes:
        buffer = BytesIO()
        _draw(picture, profile).savefig(buffer, format="png", metadata={"Software": None})
        return buffer.getvalue()

    some = STANDARD_PICTURES[:3]
    alone = [png(picture) for picture in some]
    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(png, some)) == alone


def test_drawing_does_not_touch_pyplot():
    code = "import sys, calibore.plotting; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_wrong_unit_or_radius_is_refused_in_words():
    profile = synthetic_profile([0.0])
    for picture in STANDARD_PICTURES:
        with pytest.raises(InputError, match='"mm" or "in"'):
            _draw(picture, profile, unit="furlong")
        with pytest.raises(InputError, match="nominal radius must be positive"):
            picture(profile, _rings(profile), nominal_radius=-0.15)

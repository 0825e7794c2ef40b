"""What fuzzing has found in target and rig files and in BigTIFF, reduced: names and numbers that nothing can be."""

import struct
from pathlib import Path

import numpy as np
import pytest
from calibore._native import decode_image, image_size

from calibore.calibration._boards._pictures import read_board_pictures
from calibore.calibration._in_situ._file import read_profile_target, read_table
from calibore.calibration._probe._tables import read_probe_tables
from calibore.calibration._pupil._target import read_two_pin
from calibore.calibration._rig._gauges_file import read_gauges_target
from calibore.calibration._rig._range_file import read_range_target
from calibore.calibration._rings._pictures import read_ring_pictures
from calibore.errors import InputError
from calibore.rigs import read_rig
from calibore.targets import Board
from calibore.uncertainty import Covariance
from calibore.units import parse_quantity

UNKNOWN = 19789
"""No type of TIFF values."""


def big_tiff(*, unknown: bytes = b"", counts: int = 1) -> bytes:
    """A BigTIFF of 1 x 1 grey pixels with the entry `unknown`, whose strips have `counts` lengths."""
    before = [(256, 4, 1, 1), (257, 4, 1, 1), (258, 3, 1, 8)]
    after = [(262, 3, 1, 1), (273, 4, 1, 16), (279, 4, counts, 1)]
    first, second = (b"".join(struct.pack("<HHQQ", *entry) for entry in part) for part in (before, after))
    entries = len(before) + len(after) + bool(unknown)
    return struct.pack("<2sHHHQQ", b"II", 43, 8, 0, 16, entries) + first + unknown + second + bytes(8)


def peak_memory() -> int:
    """Bytes of address space: what is set aside and never touched is not resident."""
    with open("/proc/self/status", encoding="ascii") as file:
        return 1024 * next(int(line.split()[1]) for line in file if line.startswith("VmPeak"))


def test_a_big_tiff_with_an_entry_of_an_unknown_type_is_refused_before_its_values_get_memory():
    """A decoder skips 8 of the 16 bytes behind such a type: what follows is read from the middle of an entry."""
    assert image_size(big_tiff()) == (1, 1)
    data = big_tiff(unknown=struct.pack("<HHQ", 259, UNKNOWN, 1), counts=7_900_000)
    before = peak_memory()
    for read in (lambda data: decode_image(data, limit=1 << 22), image_size):
        with pytest.raises(ValueError, match="type 19789, which TIFF does not know"):
            read(data)
    assert peak_memory() - before < 50_000_000  # it was 250 MB


def test_a_tiff_with_an_entry_of_an_unknown_type_is_read():
    entries = [(256, 4, 1, 1), (257, 4, 1, 1), (258, 3, 1, 8), (262, 3, 1, 1), (273, 4, 1, 8), (279, 4, 1, 1)]
    packed = b"".join(struct.pack("<HHII", *entry) for entry in [*entries, (65000, UNKNOWN, 4_000_000, 0)])
    data = struct.pack("<2sHI", b"II", 42, 8 + 4) + b"\x4d\0\0\0" + struct.pack("<H", 7) + packed + bytes(4)
    assert decode_image(data).tolist() == [[77]]


BOARD = 'kind = "chessboard"\nimages = NAME\ncorners = [9, 6]\nsquare = "10 mm"\n'
RINGS = 'kind = "concentric-rings"\nimages = NAME\nring_spacing = "10 mm"\nrings = 12\nspokes = 4\n'
GAUGES = 'kind = "ring-gauge"\nrig = RIG\n[[look]]\ngauge = "12 in"\nimages = NAME\nu = "0.01 mm"\n'
PINS = (
    'kind = "two-pin"\nimages = NAME\nslides = ["1 mm"]\nturntable = ["1 deg"]\nnear_pin = "upper"\nfar_pin = "lower"\n'
)
FILES = {
    "board": (read_board_pictures, BOARD),
    "boards": (read_board_pictures, BOARD.replace("NAME", '["*.png", NAME]')),
    "rings": (read_ring_pictures, RINGS + 'nominal_baseline = "6 in"\n'),
    "gauges": (read_gauges_target, GAUGES.replace("RIG", '"rig.toml"')),
    "gauges' rig": (read_gauges_target, GAUGES.replace("NAME", '"a.png"').replace("RIG", "NAME")),
    "range": (read_range_target, 'kind = "range"\nimages = NAME\nrange_step = "1 mm"\n'),
    "pins": (read_two_pin, PINS),
    "profile": (read_profile_target, 'kind = "profile"\nrig = NAME\nprofile = "result"\ngauge = "12 in"\n'),
    "probe": (read_probe_tables, 'kind = "probe"\nprobe_calibration = NAME\ndiameters = "pairs.csv"\n'),
}


@pytest.mark.parametrize("name", ["x" * 300, "ä" * 200, "a/" * 700, "a\\u0000b"], ids=["long", "wide", "deep", "nul"])
@pytest.mark.parametrize("which", FILES)
def test_a_name_that_no_system_takes_is_refused_with_its_key(tmp_path: Path, which: str, name: str) -> None:
    read, text = FILES[which]
    (tmp_path / "rig.toml").write_text(rig(), encoding="utf-8")
    quoted = text.replace("NAME", f'"{name}"')
    (tmp_path / "target.toml").write_text(f'format = "calibore-target/1"\n{quoted}', encoding="utf-8")
    with pytest.raises(
        InputError, match=r"target\.toml: key [a-z_.0-9\[\]]+ = .* is wrong: a name of a file"
    ) as caught:
        read(tmp_path)
    assert len(str(caught.value)) < 400


def rig(uncertainty: str = 'baseline = "0.006 in"', drift: str = "k = 0.1") -> str:
    return (
        'format = "calibore-rig/1"\nconfiguration = "perpendicular-plane"\n[camera]\nwidth = 1024\nheight = 768\n'
        'lens = "sine-law"\nk = 571.0\nprincipal_point = [512.0, 384.0]\n[laser]\nbaseline = "13.10 in"\n'
        f"[uncertainty]\n{uncertainty}\n[drift]\n{drift}\n"
    )


@pytest.mark.parametrize("stated", ['baseline = "1e308 mm"', 'baseline = { limits = "1e200 in" }', "k = 1e200"])
@pytest.mark.parametrize("table", ["uncertainty", "drift"])
def test_an_uncertainty_whose_square_is_no_number_is_refused_with_its_key(tmp_path, table, stated):
    (tmp_path / "rig.toml").write_text(rig(**{table: stated}), encoding="utf-8")
    with pytest.raises(InputError, match=rf"rig\.toml: key {table}\.{stated.split()[0]}"):
        read_rig(tmp_path / "rig.toml", drift=True)


def test_a_standard_uncertainty_whose_square_is_no_number_is_refused():
    with pytest.raises(InputError, match="of a is 1e\\+200"):
        Covariance.independent({"a": 1e200})


@pytest.mark.parametrize(("text", "dimension"), [("1e300 m", "length"), ("-9e99 deg", "angle"), ("1 parsec", "length")])
def test_a_quantity_beyond_any_pipe_is_refused(text, dimension):
    with pytest.raises(InputError, match="correct the number or its unit"):
        parse_quantity(text, dimension)
    assert parse_quantity("999 km", "length") == pytest.approx(999e3)


@pytest.mark.parametrize("marker", [1e-320, 1e-50, 1 - 1e-12])
def test_a_marker_that_cannot_be_printed_is_no_marker(marker):
    with pytest.raises(InputError, match="marker"):
        Board("charuco", (8, 5), marker=marker)


def test_a_table_of_a_wall_has_no_place_beyond_numbers(tmp_path):
    rows = [f"{axial},{clock},0.15" for axial in (0, 1e308) for clock in range(5)]
    (tmp_path / "wall.csv").write_text("axial_m,clock_rad,radius_m\n" + "\n".join(rows), encoding="utf-8")
    with pytest.raises(InputError, match="needs rows of numbers"):
        read_table(tmp_path / "wall.csv")


@pytest.mark.parametrize("stop", ["1e20", "1e308", "-1e20"])
def test_an_angular_stop_is_a_number_that_can_be_counted_to(tmp_path, stop):
    text = 'format = "calibore-target/1"\nkind = "probe"\nprobe_calibration = "line.csv"\ndiameters = "pairs.csv"\n'
    (tmp_path / "target.toml").write_text(text, encoding="utf-8")
    line = "\n".join(f"{0.1 * n},{n}" for n in range(1, 6))
    (tmp_path / "line.csv").write_text(f"raw_ratio,length_mm\n{line}\n", encoding="utf-8")
    for number in ("8", stop):
        pairs = f"stop_1,stop_2,raw_1,raw_2,diameter_mm\n0,{number},0.4,0.5,300\n"
        (tmp_path / "pairs.csv").write_text(pairs, encoding="utf-8")
        if number == "8":
            assert np.array_equal(read_probe_tables(tmp_path).stops, [[0, 8]])
    with pytest.raises(InputError, match=r"pairs\.csv needs rows of 5 "):
        read_probe_tables(tmp_path)

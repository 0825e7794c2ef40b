"""What fuzzing has found, reduced: each was a crash, a warning, gigabytes, or pages of text."""

import io
import os
import shutil
import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from calibore._native import decode_image, image_size
from PIL import Image

from calibore.calibration._in_situ._file import read_table
from calibore.comparison._files import is_tactile_result
from calibore.errors import CaliboreError, InputError, OutputError
from calibore.experiment._plan import REDUCED, _check_same
from calibore.folders import listed_in
from calibore.images import NamePattern, Video
from calibore.images._archive_metadata import read_metadata
from calibore.rigs import read_rig, write_rig
from calibore.scans import export, read_profile, read_rings, read_scan
from calibore.scans._staging import read_summary
from calibore.simulation import Overlay, random_rig, read_subject

GOLDEN = Path(__file__).parents[1] / "golden" / "v1"
LIMIT = 1 << 22


def tiff(tag: int, kind: int, count: int) -> bytes:
    """A TIFF of one pixel whose entry `tag` claims `count` values."""
    file = io.BytesIO()
    Image.fromarray(np.zeros((1, 1), np.uint8)).save(file, "TIFF")
    data = bytearray(file.getvalue())
    start = struct.unpack_from("<I", data, 4)[0]
    for at in range(start + 2, start + 2 + 12 * struct.unpack_from("<H", data, start)[0], 12):
        if struct.unpack_from("<H", data, at)[0] == tag:
            struct.pack_into("<HI", data, at + 2, kind, count)
    return bytes(data)


@pytest.mark.parametrize(("kind", "count"), [(3, 3_670_020), (4, 8_000_000), (1, 8_000_000), (3, 2**32 - 1)])
def test_a_tiff_entry_that_claims_more_values_than_the_file_holds_is_refused_before_they_get_memory(kind, count):
    before = peak_memory()
    for read in (lambda data: decode_image(data, limit=LIMIT), image_size):
        with pytest.raises(ValueError, match="truncated"):
            read(tiff(258, kind, count))
    assert peak_memory() - before < 50_000_000  # it was 117 MB, up to 256 MB


def peak_memory() -> int:
    """Bytes of address space: what is set aside and never touched is not resident."""
    with open("/proc/self/status", encoding="ascii") as file:
        return 1024 * next(int(line.split()[1]) for line in file if line.startswith("VmPeak"))


def test_a_decoder_that_repeats_thousands_of_numbers_is_cut_short():
    file = io.BytesIO()
    Image.fromarray(np.zeros((60, 60, 3), np.uint8)).save(file, "TIFF")
    data = bytearray(file.getvalue())
    start = struct.unpack_from("<I", data, 4)[0]
    for at in range(start + 2, start + 2 + 12 * struct.unpack_from("<H", data, start)[0], 12):
        if struct.unpack_from("<H", data, at)[0] == 258:  # bits of each sample: of 2000, all in the file
            struct.pack_into("<HII", data, at + 2, 3, 2000, 8)
    with pytest.raises(ValueError) as caught:
        decode_image(bytes(data))
    assert 20 < len(str(caught.value)) < 300


def test_the_smallest_bmp_with_the_oldest_header_has_a_size():
    header = struct.pack("<2sIHHI", b"BM", 30, 0, 0, 26) + struct.pack("<IHHHH", 12, 1, 1, 1, 24)
    data = header + bytes([3, 2, 1, 0])
    assert decode_image(data).tolist() == [[[1, 2, 3]]]
    assert image_size(data) == (1, 1)  # 30 bytes are fewer than the headers of later ones


@pytest.mark.parametrize(
    ("text", "said"),
    [("a = " + "[" * 5000, "nested too deeply"), ("a = " + "9" * 5000, "impossible number")],
)
def test_a_document_that_no_parser_gets_through_is_refused_in_a_sentence(tmp_path, text, said):
    (tmp_path / "rig.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=said):
        read_rig(tmp_path / "rig.toml")


def test_what_an_error_repeats_of_a_file_is_printable_and_short():
    sentence = str(InputError(f"Column \x1b[31m{'x' * 5000}\u202e\ud800\nis not known; remove it."))
    assert sentence.isprintable()
    assert len(sentence) < 1100
    assert sentence.startswith("Column \\x1b[31m")
    assert sentence.endswith("is not known; remove it.")
    assert str(CaliboreError("Grüße an „π“ in 12\u00a0mm.")) == "Grüße an „π“ in 12\u00a0mm."


def test_an_export_replaces_no_device(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputError, match="no file"):
        export(GOLDEN, "text3", tmp_path / "pipe")
    assert (tmp_path / "pipe").is_fifo()


def test_a_damaged_result_is_refused_in_a_sentence(tmp_path):
    shutil.copytree(GOLDEN, tmp_path / "result")
    for chunk in (tmp_path / "result" / "profile.zarr" / "radius" / "c").rglob("*"):
        if chunk.is_file():
            chunk.write_bytes(chunk.read_bytes()[:10] + b"\xff" * 40)
    for read in (read_profile, lambda out: export(out, "text3", tmp_path / "points.txt")):
        with pytest.raises(InputError, match=r"damaged|cannot be read"):
            read(tmp_path / "result")
    assert not (tmp_path / "points.txt").exists()


@pytest.mark.parametrize("what", ["missing", "a folder"])
def test_a_result_whose_metadata_is_no_file_is_damaged(tmp_path, what):
    shutil.copytree(GOLDEN, tmp_path / "result")
    metadata = tmp_path / "result" / "profile.zarr" / "zarr.json"
    metadata.unlink()
    if what == "a folder":
        metadata.mkdir()
    with pytest.raises(InputError, match=r"profile\.zarr cannot be read, it is damaged"):
        read_profile(tmp_path / "result")


def test_archive_metadata_nested_without_end_is_damage(tmp_path):
    (tmp_path / "images.zarr").mkdir()
    for text in ("[" * 100_000, "[]", '{"attributes": []}'):
        (tmp_path / "images.zarr" / "zarr.json").write_text(text, encoding="utf-8")
        with pytest.raises(InputError):
            read_metadata(tmp_path / "images.zarr")


def test_a_video_whose_title_is_no_text_is_read(tmp_path):
    import av

    path = tmp_path / "video.mkv"
    with av.open(str(path), "w") as container:
        container.metadata["title"] = "TITLETITLE"
        stream = container.add_stream("ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = 32, 32, "yuv420p"
        container.mux(stream.encode(av.VideoFrame(32, 32, "yuv420p")))
        container.mux(stream.encode())
    data = path.read_bytes()
    assert b"TITLETITLE" in data
    path.write_bytes(data.replace(b"TITLETITLE", b"\xff\xfeTLE\xffITLE"))
    assert len(list(Video(path).stations())) == 1


def test_a_scattered_table_of_a_wall_gets_no_grid_of_its_rows_squared(tmp_path):
    count = 20_000
    rows = np.column_stack([np.linspace(0, 1, count), np.linspace(0, 6, count), np.full(count, 0.15)])
    np.savetxt(tmp_path / "wall.csv", rows, delimiter=",", fmt="%.9f")
    tracemalloc.start()
    with pytest.raises(InputError, match="no grid"):
        read_table(tmp_path / "wall.csv")
    assert tracemalloc.get_traced_memory()[1] < 100e6  # a grid of all would need 3.2 GB
    tracemalloc.stop()
    for text in ("a_b\n", "axial_m,clock_rad,radius_m\n" + "0,inf,0.15\n" * 9):
        (tmp_path / "wall.csv").write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="needs rows"):
            read_table(tmp_path / "wall.csv")


SCAN = """format = "calibore-scan/1"
name = "a"
rig = "rig.toml"
[pipe]
nominal_radius = "6 in"
[images]
pattern = "PATTERN"
[motion]
axial = { origin = "0 in", step = "1 in" }
"""


@pytest.mark.parametrize("pattern", ["{station:4294967296d}", "{station:03d} {take:<99999}", "{station.real}"])
def test_no_pattern_of_names_fills_the_memory(tmp_path, pattern):
    (tmp_path / "scan.toml").write_text(SCAN.replace("PATTERN", pattern), encoding="utf-8")
    before = peak_memory()
    with pytest.raises(InputError, match=r"images\.pattern"):
        read_scan(tmp_path)
    with pytest.raises(InputError, match=r"integer format|unknown field"):
        NamePattern(pattern)
    assert peak_memory() - before < 50_000_000  # it was 4 GB


def test_a_file_whose_name_no_system_takes_does_not_exist(tmp_path):
    text = SCAN.replace("PATTERN", "{station}.png").replace("rig.toml", 4000 * "x")
    (tmp_path / "scan.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="names no existing file"):
        read_scan(tmp_path)


def test_an_archive_whose_name_no_system_takes_does_not_exist(tmp_path):
    text = SCAN.replace("PATTERN", f'{{station}}.png"\narchive = "{4000 * "x"}')
    (tmp_path / "rig.toml").write_text("", encoding="utf-8")
    (tmp_path / "scan.toml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="names no existing archive"):
        read_scan(tmp_path)


@pytest.mark.parametrize(
    ("motion", "said"),
    [
        ("stations = 2147483647 }", "motion.axial.stations"),
        ("stations = 3 }\ntakes = 2147483647", "motion.takes"),
        ('stations = 90000 }\nangular = { step = "0.1 deg", stops = 3600 }', "324000000 stops"),
    ],
)
def test_no_simulation_has_more_stations_than_memory_holds(tmp_path, motion, said):
    kind = "side-facing" if "stops" in motion else "perpendicular-plane"
    write_rig(random_rig(np.random.default_rng(1), 0.15, kind=kind), tmp_path / "rig.toml")
    head = 'format = "calibore-simulation/1"\nname = "a"\nrig = "rig.toml"\n[pipe]\nnominal_radius = "6 in"\n[motion]\n'
    (tmp_path / "simulation.toml").write_text(
        f'{head}axial = {{ origin = "0 in", step = "1 in", {motion}\n', encoding="utf-8"
    )
    before = peak_memory()
    with pytest.raises(InputError, match=said):
        read_subject(tmp_path / "simulation.toml")
    assert peak_memory() - before < 50_000_000  # it was 17 GB


@pytest.mark.parametrize("text", ["{axial:4294967296f}", "{station[0]}", "{station.x}", "{depth}"])
def test_no_overlay_fills_the_memory_or_looks_into_numbers(text):
    with pytest.raises(InputError, match="may hold"):
        Overlay(text)


DEEP = "[" * 100_000


@pytest.mark.parametrize("summary", [DEEP, "[]", '{"counts": 5}'])
def test_a_summary_that_nothing_wrote_says_nothing_about_the_scan(tmp_path, summary):
    (tmp_path / "summary.json").write_text(summary, encoding="utf-8")
    assert not is_tactile_result(tmp_path)
    assert read_summary(tmp_path) is None
    assert listed_in("summary.json", "calibore-result/1")(tmp_path) is None


def test_a_plan_nested_without_end_is_no_plan(tmp_path):
    (tmp_path / "plan.json").write_text(DEEP, encoding="utf-8")
    with pytest.raises(OutputError, match="is no plan of an experiment"):
        _check_same(tmp_path / "plan.json", REDUCED)


def test_a_column_of_numbers_that_no_integer_holds_is_one_of_numbers(tmp_path):
    (tmp_path / "rings.csv").write_text(f"station,mean\n{10**400},1.0\n7,2.0\n", encoding="utf-8")
    found = read_rings(tmp_path)
    assert found["station"].dtype.kind == "f"
    assert found["station"][1] == 7

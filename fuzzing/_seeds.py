"""Good folders to begin with: examples, the documentation's own files, small scans, results, archives, videos."""

import re
import shutil
import tempfile
from itertools import product
from pathlib import Path

import numpy as np

HERE = Path(__file__).parents[1]
BLOCK = re.compile(r"^```toml\n(.*?)^```", re.MULTILINE | re.DOTALL)
SURVEY = """format = "calibore-simulation/1"
name = "seed"
rig = "rig.toml"
seed = 1
[pipe]
nominal_radius = "6 in"
[stations]
count = 2
origin = "0 in"
step = "1 in"
"""
SCAN = """format = "calibore-scan/1"
name = "seed"
rig = "rig.toml"
[pipe]
nominal_radius = "6 in"
[images]
pattern = "{station:03d} {take}.png"
[motion]
axial = { origin = "-1 in", step = "0.1 in" }
"""
TOUCH = """format = "calibore-simulation/1"
name = "seed"
[pipe]
nominal_radius = "6 in"
[tactile]
tip_radius = "0.0625 in"
probe = { slope = "5.24 in", intercept = "4.57 in", noise = "0.0006 in", stroke = [0.02, 0.65] }
[motion]
axial = { origin = "0 in", step = "0.1 in", stations = 3 }
angular = { stops = 40 }
"""
PROBE = """format = "calibore-rig/1"
configuration = "tactile-probe"
[probe]
slope = "5.24 in"
intercept = "4.57 in"
noise = "0.0006 in"
stroke = [0.02, 0.65]
"""
FORMAT = 'format = "calibore-target/1"\n'
TARGETS = {
    "rings": """kind = "concentric-rings"
images = "*.png"
ring_spacing = "10 mm"
rings = 12
spokes = 4
nominal_baseline = "6 in"
""",
    "board": 'kind = "chessboard"\nimages = "*.png"\ncorners = [9, 6]\nsquare = "10 mm"\n',
    "charuco": 'kind = "charuco"\nimages = "*.png"\nsquares = [9, 6]\nsquare = "10 mm"\nmarker = "7 mm"\n',
    "gauges": """kind = "ring-gauge"
rig = "rig.toml"
[[look]]
gauge = "12 in"
images = "a {take}.png"
u = "0.01 mm"
[[look]]
gauge = "11 in"
images = "b {take}.png"
u = "0.1 mm"
""",
    "range": 'kind = "range"\nrig = "rig.toml"\nimages = "c {index}.png"\nrange_step = "10 mm"\nrange_origin = "0 m"\n',
    "pupil": """kind = "two-pin"
images = "d {slide} {turn}.png"
slides = ["0 mm", "10 mm"]
turntable = ["0 deg", "20 deg"]
near_pin = "upper"
far_pin = "lower"
""",
    "profile": 'kind = "profile"\nrig = "rig.toml"\nprofile = "result"\nreference = "wall.csv"\n',
    "probe": 'kind = "probe"\nprobe_calibration = "line.csv"\ndiameters = "pairs.csv"\n',
}
NAMES = ("a 0", "b 0", "c 1", "c 2", "d 0 0", "d 0 1", "d 1 0", "d 1 1")
"""Of the pictures; nothing is to be seen in them."""
LINE = "# raw_ratio,caliper_length_in\n" + "".join(f"{0.1 + 0.04 * i:.4f},{1 + 0.2 * i:.4f}\n" for i in range(20))
PAIRS = "# angular_index_1,angular_index_2,raw_1,raw_2,caliper_diameter_in\n" + "".join(
    f"{i},{i + 8},{0.4 + 0.01 * i:.4f},{0.5 + 0.01 * i:.4f},12.0{i}\n" for i in range(8)
)
WALL = "axial_m,clock_rad,radius_m\n" + "".join(
    f"0.{i},{j},0.15{i}\n" for i, j in product(range(4), (0, 0.8, 1.6, 2.4, 3.2, 4, 4.8, 5.6))
)


def documents(home: Path) -> None:
    """A folder for every example and every block of TOML in the documentation, each under all names that are read."""
    texts = [path.read_text(encoding="utf-8") for path in sorted((HERE / "examples").rglob("*.toml"))]
    for page in sorted((HERE / "docs").rglob("*.md")):
        texts += BLOCK.findall(page.read_text(encoding="utf-8"))
    for number, text in enumerate([*texts, SURVEY, SCAN, TOUCH, PROBE]):
        folder = home / f"{number:03d}"
        folder.mkdir()
        (folder / "document.toml").write_text(text, encoding="utf-8")
        for name in ("rig.toml", "test-pipe-rig.toml"):
            shutil.copy(HERE / "examples" / "test-pipe-rig.toml", folder / name)


def rigs(home: Path) -> None:
    """Rig files of every kind of light, with what a calibration says."""
    from calibore.rigs import write_rig
    from calibore.simulation import RIG_KINDS, random_rig

    rng = np.random.default_rng(1)
    for kind in RIG_KINDS:
        (home / kind).mkdir()
        write_rig(random_rig(rng, 0.15, kind=kind).with_default_uncertainty(0.15), home / kind / "rig.toml")
    for name in ("rig.toml", "document.toml"):
        (home / "example").mkdir(exist_ok=True)
        shutil.copy(HERE / "examples" / "test-pipe-rig.toml", home / "example" / name)


def targets(home: Path) -> None:
    """Descriptions of every calibration target, with the tables and dark pictures that they name."""
    from PIL import Image

    for name, text in TARGETS.items():
        folder = home / name
        folder.mkdir()
        (folder / "target.toml").write_text(FORMAT + text, encoding="utf-8")
        (folder / "bare.toml").write_text(text, encoding="utf-8")
        shutil.copy(HERE / "examples" / "test-pipe-rig.toml", folder / "rig.toml")
        for table, rows in (("line.csv", LINE), ("pairs.csv", PAIRS), ("wall.csv", WALL)):
            (folder / table).write_text(rows, encoding="utf-8")
        for picture in NAMES:
            Image.fromarray(np.zeros((16, 24), np.uint8)).save(folder / f"{picture}.png")


def tables(home: Path) -> None:
    """Tables of stations, of an odometer, of a probe's voltages."""
    folder = home / "tables"
    folder.mkdir()
    rows = "".join(f"{i},{0.01 * i},{0.1 * i},{i / 10},0.001,0,-0.002\n" for i in range(12))
    header = "station,axial_m,clock_rad,time_s,roll_rad,pitch_rad,yaw_rad\n"
    (folder / "stations.csv").write_text(header + rows, encoding="utf-8")
    rows = "".join(f"{0.1 * i},{0.01 * i},0.001\n" for i in range(12))
    (folder / "odometry.csv").write_text("time_s,axial_m,roll_rad\n" + rows, encoding="utf-8")
    rng = np.random.default_rng(1)
    for name, low, high in (("signal.csv", 1.0, 2.0), ("bias.csv", 4.9, 5.1)):
        np.savetxt(folder / name, rng.uniform(low, high, (6, 8)), delimiter=",", fmt="%.4f")


def scans(home: Path) -> None:
    """A scan of two small pictures, and the archive of it."""
    from calibore.profiling import archive_scan

    folder = home / "pictures"
    _small_scan(folder)
    archive_scan(folder, home / "archive", workers=1)


def archives(home: Path) -> None:
    """Archives of grey and of colour pictures, 8 and 16 bit."""
    from calibore.images import ImageFolder, write_archive

    with tempfile.TemporaryDirectory() as place:
        for number, (shape, dtype) in enumerate([((9, 7), np.uint8), ((9, 7, 3), np.uint8), ((9, 7), np.uint16)]):
            _pictures(Path(place), number, shape, dtype)
        source = ImageFolder(Path(place), "{station:03d}.png")
        (home / "archive").mkdir()
        journal = Path(place) / "journal"
        write_archive(source, home / "archive" / "images.zarr", journal=journal, workers=1)


def _pictures(folder: Path, number: int, shape: tuple[int, ...], dtype: type) -> None:
    from PIL import Image

    rng = np.random.default_rng(number)
    for station in (number, number + 3):
        pixels = rng.integers(0, 50 * np.iinfo(dtype).max // 255, shape, dtype=dtype)
        Image.fromarray(pixels).save(folder / f"{station:03d}.png")


def _small_scan(folder: Path) -> None:
    from dataclasses import replace

    from calibore.simulation import demo_survey, simulate_scan

    survey = demo_survey(seed=1)
    simulate_scan(folder, replace(survey, stations=survey.stations[:2]), seed=1, workers=1)


def results(home: Path) -> None:
    """A result folder of today and the stored one of version 1."""
    from calibore.profiling import profile_scan

    with tempfile.TemporaryDirectory() as place:
        _small_scan(Path(place) / "scan")
        profile_scan(Path(place) / "scan", home / "result", workers=1)
    shutil.copytree(HERE / "tests" / "golden" / "v1", home / "v1")


def calibrations(home: Path) -> None:
    """A calibration with its evidence, from the simulated photographs of a probe's line."""
    from calibore.calibration import calibrate, write_calibration

    with tempfile.TemporaryDirectory() as place:
        target = Path(place) / "target"
        target.mkdir()
        (target / "target.toml").write_text(FORMAT + TARGETS["probe"], encoding="utf-8")
        (target / "line.csv").write_text(LINE, encoding="utf-8")
        (target / "pairs.csv").write_text(PAIRS, encoding="utf-8")
        found = calibrate("probe", target)
    (home / "probe").mkdir()
    write_calibration(found, home / "probe" / "document.toml")


def videos(home: Path) -> None:
    """Short videos of the codecs and containers that recorders write."""
    import av

    kinds = [*product(("libx264", "mjpeg", "mpeg2video"), ("mp4", "avi", "mkv")), ("ffv1", "mkv"), ("rawvideo", "avi")]
    for codec, container in kinds:
        (home / f"{codec}-{container}").mkdir()
        path = home / f"{codec}-{container}" / "video.bin"
        with av.open(str(path), "w", format={"mkv": "matroska"}.get(container, container)) as file:
            stream = file.add_stream(codec, rate=25)
            stream.width, stream.height = 48, 32
            stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
            for number in range(8):
                picture = np.random.default_rng(number).integers(0, 60, (32, 48, 3), dtype=np.uint8)
                picture[8:20, 4 * number : 4 * number + 6] = 220
                frame = av.VideoFrame.from_ndarray(picture, format="rgb24").reformat(format=stream.pix_fmt)
                frame.pts = number
                file.mux(stream.encode(frame))
            file.mux(stream.encode())

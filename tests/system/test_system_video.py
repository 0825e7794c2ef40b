"""A video of a ring with an odometry table, from the encoder to the diameters."""

import json
from pathlib import Path

import av
import numpy as np
import pytest
from command_line import profile
from conftest import BASELINE, OVAL_CLOCK, small_rig, small_wall

from calibore.geometry import Pose, clock_of
from calibore.scans import open_points, open_profile, read_rings
from calibore.simulation import LineLight, Sensor, TrueRing, lit_line, photograph, true_ring

RATE = 25
FRAMES = 6
ROLLS = np.linspace(-0.3, 0.4, FRAMES)
AXIAL = 0.1 + 0.02 * np.arange(FRAMES)
WHITE = LineLight(colour=(1.0, 1.0, 1.0))  # cameras on video show the line washed out
ONE_PIXEL = BASELINE / (192 * np.cos(np.arctan(6 / 13.1)) ** 3)
"""How much radius one pixel is at the wall [m]: the derivative of baseline x tan(asin(r / k))."""
CODECS = {
    "H.264": ("libx264", "mp4", "yuv420p", {"crf": "16"}),
    "MJPEG": ("mjpeg", "avi", "yuvj420p", {"qmin": "2", "qmax": "3"}),
    "MPEG-2": ("mpeg2video", "mpg", "yuv420p", {"qmin": "2", "qmax": "3"}),
}


@pytest.fixture(scope="module")
def frames() -> list[tuple[np.ndarray, TrueRing]]:
    """Pictures of a rig that rolls as it travels, each with what it shows."""
    rig, wall, rendered = small_rig(channel=None), small_wall(), []
    for number, (roll, axial) in enumerate(zip(ROLLS, AXIAL, strict=True)):
        pose = Pose.from_roll_pitch_yaw(roll, 0.001, -0.002, translation=(0.002, -0.001, axial))
        lit = lit_line(rig, wall, pipe_from_rig=pose, line=WHITE, psf_sigma=Sensor().psf_sigma)
        rng, speckle = np.random.default_rng([1, number]), np.random.default_rng([2, number])
        image = photograph(lit, rig, line=WHITE, sensor=Sensor(), rng=rng, speckle_rng=speckle)
        rendered.append((image, true_ring(lit, rig, wall, pipe_from_rig=pose, line=WHITE)))
    return rendered


def video_scan(folder: Path, rendered: Path, frames: list[tuple[np.ndarray, TrueRing]], kind: str = "H.264") -> Path:
    """A scan folder with a video of the frames, an odometry table with roll, and a rig that names no channel."""
    codec, suffix, pixels, options = CODECS[kind]
    scan = folder / "survey"
    scan.mkdir()
    av.logging.set_level(av.logging.PANIC)
    with av.open(str(scan / f"survey.{suffix}"), "w") as container:
        stream = container.add_stream(codec, rate=RATE)
        stream.width, stream.height, stream.pix_fmt, stream.bit_rate = 320, 240, pixels, 8_000_000
        stream.options = options
        for number, (image, _) in enumerate(frames):
            frame = av.VideoFrame.from_ndarray(image, format="rgb24").reformat(format=pixels)
            frame.pts = number
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    rig = (rendered / "rig.toml").read_text(encoding="utf-8").replace('channel = "red"\n', "")
    (scan / "rig.toml").write_text(rig, encoding="utf-8")
    lines = ['format = "calibore-scan/1"', 'name = "video"', 'rig = "rig.toml"', '[pipe]\nnominal_radius = "6 in"']
    lines += [f'[images]\nvideo = "survey.{suffix}"', '[motion]\ntable = "odometry.csv"', ""]
    (scan / "scan.toml").write_text("\n".join(lines), encoding="utf-8")
    write_odometry(scan, FRAMES)
    return scan


def write_odometry(scan: Path, rows: int) -> None:
    table = [f"{n / RATE},{AXIAL[n]},{ROLLS[n]}\n" for n in range(rows)]
    (scan / "odometry.csv").write_text("time_s,axial_m,roll_rad\n" + "".join(table), encoding="utf-8")


@pytest.mark.parametrize("kind", CODECS)
def test_a_video_is_measured_as_well_as_its_pictures_allow(tmp_path, rendered, frames, kind):
    scan, out = video_scan(tmp_path, rendered, frames, kind), tmp_path / "out"
    outcome = profile(scan)
    assert (outcome.status, outcome.err) == (0, "")
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert summary["channel"] == "luma"
    with open_profile(out) as dataset:
        clock, radius = dataset["clock"].values, dataset["radius"].values
        assert dataset["station"].values.tolist() == list(range(FRAMES))
        assert dataset["time_s"].values == pytest.approx(np.arange(FRAMES) / RATE, abs=1e-3)
        assert dataset["axial"].values == pytest.approx(AXIAL, abs=1e-5)
        assert dataset["roll"].values == pytest.approx(ROLLS, abs=1e-4)
        u = np.hypot(dataset["u_independent"].values, dataset["u_common"].values)
    truth = np.stack([np.interp(clock, ring.clock, ring.radius, period=2 * np.pi) for _, ring in frames])
    error = radius - truth
    assert np.isfinite(error).mean() > 0.99
    assert np.nanmean(np.abs(error) <= 1.96 * u) > 0.9  # speckle grains of 2 px: some 40 independent arcs a ring
    assert abs(np.nanmean(error)) < 0.04 * ONE_PIXEL
    assert np.sqrt(np.nanmean(error**2)) < 0.25 * ONE_PIXEL  # what speckle leaves at best (anchors.md)


def test_clock_positions_count_from_the_crown_though_the_rig_rolls(tmp_path, rendered, frames):
    scan, out = video_scan(tmp_path, rendered, frames), tmp_path / "out"
    assert profile(scan).status == 0
    rings = read_rings(out)
    widest, u = rings["diameter_max_clock_rad"], rings["u_diameter_max_clock_rad"]
    assert np.all(np.abs(widest - OVAL_CLOCK) < 3 * u)
    assert np.all(u < 0.1)  # else the roll of 0.4 would not show
    horizontal = rings["diameter_horizontal_m"] / rings["diameter_mean_m"] - 1
    expected = 0.01 * np.cos(2 * (np.pi / 2 - OVAL_CLOCK))
    assert np.all(np.abs(horizontal - expected) < 3 * rings["u_diameter_horizontal_m"] / rings["diameter_mean_m"])


def test_points_lie_in_the_pipe_frame_rolled_with_the_rig(tmp_path, rendered, frames):
    scan, out = video_scan(tmp_path, rendered, frames), tmp_path / "out"
    assert profile(scan).status == 0
    with open_points(out) as points, open_profile(out) as dataset:
        x, y, clock, station = (points[name].values for name in ("x", "y", "clock", "station"))
        found = np.isfinite(x)
        turn = np.angle(np.exp(1j * (clock[found] - clock_of(x[found].astype(float), y[found].astype(float)))))
        assert np.abs(turn).max() < 1e-6
        assert np.hypot(x, y)[found] == pytest.approx(points["radius"].values[found], abs=1e-5)
        for number in (0, FRAMES - 1):
            ring = found & (station == number)
            order = np.argsort(clock[ring])
            rig_clock = dataset["clock"].values + ROLLS[number]
            here = np.interp(rig_clock, clock[ring][order], points["radius"].values[ring][order], period=2 * np.pi)
            away = here - dataset["radius"].sel(station=number).values
            assert abs(np.nanmean(away * np.cos(2 * rig_clock))) < 2e-5  # the oval part would show 0.2 mm if not rolled


def test_frames_beyond_the_odometry_are_refused_counted_and_named(tmp_path, rendered, frames):
    scan = video_scan(tmp_path, rendered, frames)
    write_odometry(scan, 4)
    outcome = profile(scan)
    assert outcome.status == 3
    assert outcome.out.startswith("4 stations from 4 images")
    assert "Warning: 2 frames left out, the first is frame 4: odometry shorter than the video" in outcome.err
    assert "the table covers 0 s to 0.12 s" in outcome.err
    summary = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["counts"]["refused_images"] == 2


def test_an_odometry_that_misses_the_video_leaves_nothing_to_measure(tmp_path, rendered, frames):
    scan = video_scan(tmp_path, rendered, frames)
    (scan / "odometry.csv").write_text("time_s,axial_m\n100,0\n101,1\n", encoding="utf-8")
    outcome = profile(scan)
    assert outcome.status == 1
    assert "survey.mp4" in outcome.sentence
    assert "6 frames left out" in outcome.sentence
    assert "the table covers 100 s to 101 s" in outcome.sentence
    assert not (tmp_path / "out").exists()


ODOMETRY = {
    "one row": ("time_s,axial_m\n0,0\n", "at least 2"),
    "time runs back": ("time_s,axial_m\n0,0\n2,1\n1,2\n", "line 4: time_s = 1 s does not increase"),
    "stations instead": ("station,axial_m\n0,0\n1,1\n", "column time_s is missing"),
    "NaN": ("time_s,axial_m\n0,0\n1,nan\n", 'line 3: axial_m = "nan"'),
}


@pytest.mark.parametrize("table", ODOMETRY.values(), ids=ODOMETRY.keys())
def test_a_mistake_in_the_odometry_is_named_with_its_line(tmp_path, rendered, frames, table):
    rows, words = table
    scan = video_scan(tmp_path, rendered, frames[:2])
    (scan / "odometry.csv").write_text(rows, encoding="utf-8")
    outcome = profile(scan)
    assert outcome.status == 1
    assert str(scan / "odometry.csv") in outcome.sentence
    assert words in outcome.sentence


def test_a_frame_without_a_ring_is_named_by_its_number(tmp_path, rendered, frames):
    black = (np.zeros_like(frames[0][0]), frames[0][1])
    outcome = profile(video_scan(tmp_path, rendered, [frames[0], black, *frames[2:]]))
    assert outcome.status == 3
    assert "1 image could not be used: frame 1 (there is no laser ring" in outcome.err


def test_a_video_of_another_size_is_refused_before_it_is_decoded(tmp_path, rendered, frames):
    scan = video_scan(tmp_path, rendered, frames[:2])
    text = (scan / "rig.toml").read_text(encoding="utf-8")
    (scan / "rig.toml").write_text(text.replace("width = 320", "width = 640"), encoding="utf-8")
    sentence = profile(scan).sentence
    assert "survey.mp4" in sentence
    assert "320 x 240 px" in sentence
    assert "640 x 240 px; use the rig file of the camera" in sentence


def test_a_file_that_is_no_video_is_told_so(tmp_path, rendered, frames):
    scan = video_scan(tmp_path, rendered, frames[:2])
    (scan / "survey.mp4").write_bytes(b"this is no video" * 100)
    outcome = profile(scan)
    assert outcome.status == 1
    assert "survey.mp4" in outcome.sentence
    assert "give a readable video file" in outcome.sentence


def test_a_video_cut_short_is_measured_as_far_as_it_goes(tmp_path, rendered, frames):
    scan = video_scan(tmp_path, rendered, frames, "MJPEG")
    whole = (scan / "survey.avi").read_bytes()
    (scan / "survey.avi").write_bytes(whole[: len(whole) * 2 // 3])
    outcome = profile(scan)
    assert outcome.status == 3
    assert "left out" in outcome.err
    measured = read_rings(tmp_path / "out")["station"].tolist()
    assert measured == list(range(len(measured)))
    assert 0 < len(measured) < FRAMES

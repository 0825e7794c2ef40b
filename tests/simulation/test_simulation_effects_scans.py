"""Scans with dirt, water, glare, JPEG and video: written as specified, read and measured by the profiler."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from calibore.errors import InputError
from calibore.geometry import Pose
from calibore.images import Video, read_image, read_odometry
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.profiling import profile_scan
from calibore.rigs import Laser, Rig
from calibore.scans import open_profile, read_scan
from calibore.simulation import (
    Dent,
    Film,
    Ghost,
    Lamp,
    Overlay,
    PipeWall,
    Sensor,
    Smudge,
    Station,
    Still,
    Survey,
    Water,
    Window,
    read_survey,
    simulate_scan,
)
from calibore.status import Status

INCH = 0.0254
R = 6 * INCH
SMALL = Survey(
    name="small",
    rig=Rig(
        "perpendicular-plane",
        Camera(320, 240, Lens("sine-law", 178.0, 120.0), (160.0, 120.0)),
        (Laser(Plane(0.33), "red"),),
    ),
    wall=PipeWall(R, (Dent(0.008, 4.7, 0.0, 0.2, 0.05),)),
    stations=(Station(0), Station(3), Station(5)),
    origin=-0.33,
    step=0.01,
    pose=Pose.from_roll_pitch_yaw(0.01, translation=(0.002, 0.001, 0.0)),
)
LARGE = replace(
    SMALL,
    rig=Rig(
        "perpendicular-plane",
        Camera(1024, 768, Lens("sine-law", 571.0, 384.0), (512.0, 384.0)),
        (Laser(Plane(0.33), "red"),),
    ),
)


def measured(folder, survey, seed=1):
    """Error [m], its stated independent u, status, and truth's visible and signal, each (station, clock)."""
    scan = simulate_scan(folder / "scan", survey, seed=seed)
    profile_scan(scan, folder / "out")
    with open_profile(folder / "out") as found, np.load(scan / "truth.npz") as truth:
        assert found["station"].values.tolist() == truth["stop"].tolist()
        u, status = found["u_independent"].values, found["status"].values
        visible, signal = (truth[f"ring_rig_{name}"][:, 0] for name in ("visible", "signal"))
        return found["radius"].values - truth["ring_rig_R"][:, 0] * INCH, u, status, visible, signal


def test_a_finer_jpeg_is_read_back_nearer_to_what_the_sensor_gave(tmp_path):
    pixels = read_image(simulate_scan(tmp_path / "png", SMALL, seed=1) / "pipe 003 0.png").astype(float)
    worst = []
    for quality, chroma in ((95, "4:4:4"), (95, "4:2:0"), (60, "4:2:0"), (20, "4:2:0")):
        survey = replace(SMALL, images=Still("jpeg", quality, chroma))
        folder = simulate_scan(tmp_path / f"{quality} {chroma[-1]}", survey, seed=1)
        assert read_scan(folder).pattern == "pipe {station:03d} {take}.jpg"
        worst.append(np.sqrt(np.mean((read_image(folder / "pipe 003 0.jpg") - pixels) ** 2)))
    assert (np.diff(worst) > 0).all()
    assert worst[0] < 2  # grey of 255
    assert worst[0] < 0.6 * worst[1]  # half the resolution of a thin red line is half its colour


@pytest.mark.parametrize("codec", ["h264", "mjpeg", "mpeg2"])
def test_a_video_holds_the_stations_as_frames_with_their_odometry(tmp_path, codec):
    survey = replace(SMALL, images=Film(codec, rate=25, quality=4))
    folder = simulate_scan(tmp_path / "scan", survey, seed=1)
    scan = read_scan(folder)
    assert scan.video is not None
    assert {path.name for path in folder.iterdir()} == {
        scan.video.name,
        "odometry.csv",
        "rig.toml",
        "scan.toml",
        "truth.npz",
    }
    assert isinstance(scan.motion, Path)
    odometry = read_odometry(scan.motion)
    assert odometry.time == pytest.approx([0.0, 0.04, 0.08])
    assert odometry.axial == pytest.approx([-0.33, -0.30, -0.28])
    film, stills = Video(scan.video, "red"), simulate_scan(tmp_path / "stills", SMALL, seed=1)
    for frame, number in zip(film.stations(), (0, 3, 5), strict=True):
        original = read_image(stills / f"pipe {number:03d} 0.png")[..., 0].astype(float)
        assert np.corrcoef(frame.read(0)[..., 0].ravel(), original.ravel())[0, 1] > 0.9
    assert not film.refusals
    with np.load(folder / "truth.npz") as truth, np.load(stills / "truth.npz") as same:
        assert truth["stop"].tolist() == [0, 1, 2]
        assert np.array_equal(truth["ring_rig_R"], same["ring_rig_R"])
    again = simulate_scan(tmp_path / "again", survey, seed=1)
    assert (again / scan.video.name).read_bytes() == scan.video.read_bytes()


def test_what_no_video_can_hold_is_told():
    with pytest.raises(InputError, match="two stations or more with one take each"):
        replace(SMALL, images=Film(), stations=(Station(0), Station(1, takes=2)))
    with pytest.raises(InputError, match="two stations or more"):
        replace(SMALL, images=Film(), stations=(Station(0),))
    with pytest.raises(InputError, match="JPEG and video hold 8 bits, the sensor gives 16"):
        replace(SMALL, images=Still("jpeg"), sensor=Sensor(bits=16))
    with pytest.raises(InputError, match=r'"vp9" is not known of a video .*; allowed: h264, mjpeg, mpeg2'):
        Film("vp9")
    with pytest.raises(InputError, match=r"quality of mjpeg must be between 2 \(finest\) and 31, got 40"):
        Film("mjpeg", quality=40)
    with pytest.raises(InputError, match="mpeg2 has 24, 25, 30, 50 or 60 frames a second, got 10"):
        Film("mpeg2", rate=10)
    with pytest.raises(InputError, match="quality of a JPEG must be between 1 and 100"):
        Still("jpeg", 0)


def test_an_odd_number_of_pixels_is_no_video_with_halved_colour(tmp_path):
    camera = Camera(321, 240, Lens("sine-law", 178.0, 120.0), (160.0, 120.0))
    survey = replace(SMALL, rig=replace(SMALL.rig, camera=camera), images=Film())
    with pytest.raises(InputError, match=r"321 x 240 px, .* needs even numbers"):
        simulate_scan(tmp_path / "scan", survey, seed=1)
    assert not (tmp_path / "scan").exists()


def test_an_overlay_and_a_lamp_reach_the_pictures_of_a_scan(tmp_path):
    plain = simulate_scan(tmp_path / "plain", SMALL, seed=1)
    survey = replace(SMALL, overlays=(Overlay("{station}", height=12.0),), lamps=(Lamp(0.9),))
    folder = simulate_scan(tmp_path / "scan", survey, seed=1)
    one, other = (read_image(path / "pipe 003 0.png").astype(int) for path in (folder, plain))
    assert (one - other)[15:40, 15:60].max() > 150
    assert (one - other)[40:].max() > 100
    with np.load(folder / "truth.npz") as truth, np.load(plain / "truth.npz") as same:
        for key in same:
            assert np.array_equal(truth[key], same[key]), key


@pytest.mark.slow
@pytest.mark.parametrize(
    ("water", "most"),
    [(Water(0.02), 0.01), (Water(0.045, ripple=0.003), 0.01), (Water(0.04, glints=3.0), 0.2)],  # a glint is the surface
)
def test_what_water_covers_is_missing_or_flagged(tmp_path, water, most):
    error, u, status, visible, _ = measured(tmp_path, replace(LARGE, wall=replace(LARGE.wall, water=water)))
    assert 0.1 < (~visible).mean() < 0.35
    wrong = np.isfinite(error) & (np.abs(error) > 3 * u) & (status == Status.OK)
    assert wrong[~visible].mean() < most
    assert np.isfinite(error[visible]).mean() > 0.99


@pytest.mark.slow
def test_glare_is_hardly_ever_taken_for_the_wall(tmp_path):
    window = Window(smudges=(Smudge(330.0, 250.0, 60.0),), ghosts=(Ghost(0.15, 0.92, (3.0, 2.0)),), halo=0.05)
    survey = replace(LARGE, window=window, lamps=(Lamp(0.6, 0.2, 1.6, 0.05),), overlays=(Overlay("MH 12"),))
    error, u, _, visible, signal = measured(tmp_path, survey)
    wanted = visible & (signal > 0.05)
    assert np.mean(np.abs(error[wanted]) > 5 * u[wanted]) < 0.01
    assert np.isfinite(error[wanted]).mean() > 0.97


@pytest.mark.slow
@pytest.mark.parametrize("images", [Still("jpeg", 90), Still("jpeg", 90, "4:4:4"), Film("h264", quality=20)])
def test_the_scatter_that_an_encoder_adds_is_stated(tmp_path, images):
    survey = replace(LARGE, images=images, stations=tuple(map(Station, range(5))))
    error, u, _, _, _ = measured(tmp_path, survey)
    assert np.isfinite(error).mean() > 0.99
    assert 0.9 < np.sqrt(np.nanmean((error / u) ** 2)) < 1.15
    assert np.nanmean(np.abs(error) <= 1.96 * u) > 0.93


SPEC = """
format = "calibore-simulation/1"
name = "wet"
rig = "rig.toml"
[pipe]
nominal_radius = "6 in"
water = { level = "30 mm", ripple = "0.5 deg", glints = 2 }
[pipe.finish]
reflectance = 0.8
contrast = 0.2
grain = "15 mm"
specular = 0.2
stains = [
  { kind = "patch", clock = "90 deg", axial = "20 mm", radius = "15 mm", height = "2 mm" },
  { kind = "band", axial = ["30 mm", "40 mm"], reflectance = 0.1 },
  { kind = "specks", spacing = "20 mm", radius = "5 mm" },
]
[motion]
axial = { origin = "-13.1 in", step = "10 mm", stations = 2 }
[window]
smudges = [{ u = 60, v = 60, radius = 20 }]
ghosts = [{ strength = 0.1, scale = 0.9 }]
halo = 0.05
[[lamps]]
distance = "0.8 m"
[[overlays]]
text = "MH 12"
[images]
video = { codec = "h264", rate = 25, quality = 20 }
"""


def written(folder, text=SPEC):
    camera = 'width = 320\nheight = 240\nlens = "sine-law"\nk = 178.0\nc1 = 0.0\nprincipal_point = [160, 120]'
    rig = f'format = "calibore-rig/1"\nconfiguration = "perpendicular-plane"\n[camera]\n{camera}\n'
    (folder / "rig.toml").write_text(rig + '[laser]\nbaseline = "13.1 in"\nchannel = "red"\n', encoding="utf-8")
    (folder / "spec.toml").write_text(text, encoding="utf-8")
    return folder / "spec.toml"


def test_every_effect_can_be_specified_in_a_file(tmp_path):
    survey, seed = read_survey(written(tmp_path))
    assert survey.wall.water == Water(0.03, np.radians(0.5), 2.0)
    assert survey.wall.finish is not None
    assert [type(stain).__name__ for stain in survey.wall.finish.stains] == ["Patch", "Band", "Specks"]
    assert survey.wall.radius(0.02, np.pi / 2) == pytest.approx(R - 0.002)
    assert survey.window == Window((Smudge(60, 60, 20),), (Ghost(0.1, 0.9),), 0.05)
    assert survey.lamps == (Lamp(0.8),)
    assert survey.overlays == (Overlay("MH 12"),)
    assert survey.images == Film("h264", 25, 20)
    assert read_scan(simulate_scan(tmp_path / "scan", survey, seed=seed)).video == tmp_path / "scan" / "pipe.mp4"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('level = "30 mm"', "level = 30"), "pipe.water.level"),
        (('kind = "band"', 'kind = "stripe"'), "pipe.finish.stains"),
        (("halo = 0.05", "halo = 2.0"), "scatters 0 to 1 of the light, got a halo of 2"),
        (('codec = "h264"', 'codec = "vp9"'), "allowed: h264, mjpeg, mpeg2"),
        (("reflectance = 0.8", "reflectance = 9.0"), "reflectance of a wall must be between 0"),
        (('text = "MH 12"', 'text = "{depth}"'), "{station} and {axial} only"),
    ],
)
def test_a_mistake_in_an_effect_is_named_with_its_file(tmp_path, change, said):
    path = written(tmp_path, SPEC.replace(*change))
    with pytest.raises(InputError) as told:
        read_survey(path)
    assert "spec.toml" in str(told.value)
    assert said in str(told.value)


def test_the_example_of_the_documentation_is_a_specification(tmp_path):
    page = (Path(__file__).parents[2] / "docs" / "how-to" / "simulate.md").read_text(encoding="utf-8")
    (block,) = (text.split("```")[0] for text in page.split("```toml\n")[1:] if "[pipe.finish]" in text)
    plain = SPEC.split("water =")[0] + "[motion]\n" + SPEC.split("[motion]\n")[1].split("[window]")[0]
    survey, _ = read_survey(written(tmp_path, plain + block))
    assert survey.images == Still("jpeg", 90, "4:2:0")
    film = block.split("# video = ")[1].split("}")[0] + "}"
    survey, _ = read_survey(written(tmp_path, f"{plain}[images]\nvideo = {film}\n"))
    assert survey.images == Film()

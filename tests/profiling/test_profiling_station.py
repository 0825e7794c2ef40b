"""One station: which of its images count, what the others are called, and where its points lie."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from calibore.errors import ImageError, InputError
from calibore.geometry import Pose
from calibore.images import ImageFileError, Pixels, StationImages
from calibore.lasers import Plane
from calibore.optics import Camera, Lens
from calibore.profiling import Job, measure_station
from calibore.profiling._lasers import Look
from calibore.profiling._placement import Placement
from calibore.profiling._search import Search, search_region
from calibore.profiling._station import StationRefusedError
from calibore.rigs import Laser, Rig
from calibore.simulation import Ovality, PipeWall, Sensor, render_ring
from calibore.status import Status
from calibore.uncertainty import Covariance

RADIUS, BASELINE = 0.15, 0.32
WIDTH, HEIGHT, K = 320, 240, 190.0


def rig(*, k: float = K, takes: tuple[int, ...] | None = None) -> Rig:
    camera = Camera(WIDTH, HEIGHT, Lens("sine-law", k, HEIGHT / 2), (WIDTH / 2, HEIGHT / 2))
    covariance = Covariance.independent({"laser.baseline": 1e-4})
    return Rig("perpendicular-plane", camera, (Laser(Plane(BASELINE), "red", takes),), covariance=covariance)


@pytest.fixture(scope="module")
def ring() -> Pixels:
    """An oval ring, widest at the crown."""
    wall = PipeWall(RADIUS, (Ovality((4.0, 4.0), axial=(0.0, 1.0), axis=0.0),))
    pose = Pose.from_roll_pitch_yaw(0.0, 0.0, 0.0, translation=(0.0, 0.0, 0.0))
    return render_ring(rig(), wall, pipe_from_rig=pose, rng=np.random.default_rng(1), sensor=Sensor.perfect(bits=8))


def station(*pictures: Pixels | ImageError) -> StationImages:
    def read(take: int) -> Pixels:
        picture = pictures[take]
        if isinstance(picture, ImageError):
            raise picture
        return picture

    names = tuple(f"ring 7 {take}.png" for take in range(len(pictures)))
    return StationImages(7, tuple(range(len(pictures))), read, names=names)


def black() -> Pixels:
    return np.zeros((HEIGHT, WIDTH, 3), np.uint8)


BROKEN = ImageFileError(Path("/survey/ring 7 0.png"), "it is truncated")
HERE = Placement(1.0)


def test_an_image_that_cannot_be_read_is_refused_by_its_name_and_the_other_takes_count(ring):
    result = measure_station(station(BROKEN, ring, black()), HERE, Job.of(rig(), RADIUS))
    assert [image.name for image in result.refused] == ["ring 7 0.png", "ring 7 2.png"]
    assert result.refused[0].reason == "it is truncated; copy or save it again, or remove it"
    assert result.refused[1].reason.startswith("there is no laser ring in the image")
    assert set(result.points.take) == {1}
    assert result.row["takes"] == 1
    assert np.array_equal(result.first_image(), ring)


def test_a_station_of_which_no_image_can_be_used_is_refused_with_every_reason():
    with pytest.raises(StationRefusedError) as refused:
        measure_station(station(BROKEN, black()), HERE, Job.of(rig(), RADIUS))
    assert [image.name for image in refused.value.images] == ["ring 7 0.png", "ring 7 1.png"]
    assert "ring 7 0.png: it is truncated" in str(refused.value)


def test_takes_in_which_the_laser_is_not_lit_are_no_part_of_the_station(ring):
    result = measure_station(station(BROKEN, ring), HERE, Job.of(rig(takes=(1,)), RADIUS))
    assert result.refused == ()
    assert result.unlit == (0,)
    assert set(result.points.take) == {1}
    with pytest.raises(StationRefusedError, match=r"laser\.takes"):
        measure_station(station(ring, ring), HERE, Job.of(rig(takes=(5,)), RADIUS))


def test_more_takes_than_elsewhere_are_simply_used(ring):
    result = measure_station(station(ring, ring, ring, ring), HERE, Job.of(rig(), RADIUS))
    assert result.row["takes"] == 4
    assert result.take_correlation == pytest.approx(1.0)  # four copies of one image tell no more than one


def test_an_image_of_another_size_is_told_both_sizes(ring):
    with pytest.raises(StationRefusedError, match="it is 160 x 120 px but the rig's camera has 320 x 240 px"):
        measure_station(station(ring[::2, ::2].copy()), HERE, Job.of(rig(), RADIUS))


def test_a_ring_whose_every_ray_misses_the_laser_plane_is_refused_and_not_a_crash(ring):
    narrow = rig(k=60.0)  # the ring lies at 80 px: beyond what this lens can image
    job = replace(
        Job.of(rig(), RADIUS), rig=narrow, looks=(Look(0, Search((WIDTH / 2, HEIGHT / 2), 62.0, 115.0), "red"),)
    )
    with pytest.raises(StationRefusedError, match="no point of its line lies in the light of the laser"):
        measure_station(station(ring), HERE, job)


def test_points_are_in_the_pipe_frame_and_the_profile_in_the_rigs(ring):
    job = Job.of(rig(), RADIUS)
    straight = measure_station(station(ring), HERE, job)
    rolled = measure_station(station(ring), Placement(2.0, roll=0.5), job)
    assert np.array_equal(rolled.profile.radius, straight.profile.radius, equal_nan=True)
    assert rolled.profile.roll == 0.5
    turn = np.mod(rolled.points.clock - straight.points.clock, 2 * np.pi)
    assert turn == pytest.approx(0.5, abs=1e-9)
    assert rolled.points.z - straight.points.z == pytest.approx(1.0, abs=1e-12, nan_ok=True)
    widest = rolled.row["diameter_max_clock_rad"] - straight.row["diameter_max_clock_rad"]
    assert np.mod(widest, np.pi) == pytest.approx(0.5, abs=1e-6)


def test_rays_without_a_point_have_a_clock_and_say_why(ring):
    hidden = ring.copy()
    hidden[:, : WIDTH // 2 - 40] = 0
    points = measure_station(station(hidden), HERE, Job.of(rig(), RADIUS)).points
    missing = points.status > Status.SATURATED
    assert 0.1 < missing.mean() < 0.4
    assert np.isfinite(points.clock).all()
    assert np.isnan(points.radius[missing]).all()
    assert np.median(points.clock[missing]) == pytest.approx(1.5 * np.pi, abs=0.1)


@pytest.mark.parametrize("values", [(0, 0), (255, 255), (3, 200)])
def test_a_picture_without_a_ring_is_told_with_its_brightness_in_the_lasers_channel(values):
    picture = black()
    picture[..., 0] = values[0]
    picture[:8, :8, 0] = values[1]
    picture[..., 1] = np.arange(WIDTH) % 256
    with pytest.raises(StationRefusedError) as refused:
        measure_station(station(picture), HERE, Job.of(rig(), RADIUS))
    low, high = values
    said = f"every red value is {low} of 255" if low == high else f"red values {low} to {high} of 255"
    assert said in str(refused.value)


def search(radius: float = RADIUS, **camera: Any) -> Search:
    here = rig()
    return search_region(replace(here, camera=replace(here.camera, **camera)), radius, inner=0.5, outer=1.5)


def test_the_ring_is_looked_for_where_the_nominal_pipe_would_show():
    where = search()
    outline = K * np.sin(np.arctan(np.array([0.5, 1.5]) * RADIUS / BASELINE))
    assert where.centre == pytest.approx((WIDTH / 2, HEIGHT / 2), abs=1e-6)
    assert (where.inner, where.outer) == pytest.approx(outline)
    assert str(where) == f"looked for {outline[0]:.0f} to {outline[1]:.0f} px from column 160, row 120"


@pytest.mark.parametrize("radius", [1e-6, 1e-3, 30.0, 1e6])
def test_a_pipe_too_small_or_too_large_for_this_camera_is_an_error_that_says_what_to_check(radius):
    with pytest.raises(InputError, match="check nominal_radius, baseline, lens, k"):
        search(radius)


@pytest.mark.parametrize("centre", [(-500.0, 120.0), (160.0, 5000.0), (700.0, -500.0)])
def test_a_ring_beside_the_image_is_an_error_that_says_what_to_check(centre):
    with pytest.raises(InputError, match=r"no room for its ring in the image of 320 x 240 px .* principal_point"):
        search(principal_point=centre)


def test_a_ring_partly_beside_the_image_is_looked_for():
    assert search(principal_point=(20.0, 120.0)).outer > 100

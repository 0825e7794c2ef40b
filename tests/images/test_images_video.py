"""Videos written here with PyAV: every codec and container, padding, damage, odometry."""

import tracemalloc
from itertools import pairwise, product
from pathlib import Path

import av
import numpy as np
import pytest

from calibore.errors import ImageError, InputError
from calibore.images import Odometry, Video, _video, read_odometry

RATE = 25
FRAMES = 40
CODED_LEVELS = 1.9  # quantisation of flat frames at these bit rates; half the step from frame to frame
KINDS = list(product(("libx264", "mjpeg", "mpeg2video"), ("mp4", "avi", "mkv", "mpg")))
KINDS.remove(("mjpeg", "mpg"))  # that container does not know this codec


def level(number: int) -> int:
    return 40 + 4 * (number % FRAMES)


def write_video(
    path: Path, codec: str = "libx264", *, size: tuple[int, int] = (90, 70), frames: int = FRAMES, **options: str
) -> Path:
    """Frame n is flat grey of `level(n)` with a speckled part at the top left, which makes most of its packet."""
    av.logging.set_level(av.logging.PANIC)
    width, height = size
    rng = np.random.default_rng(width)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=RATE)
        stream.width, stream.height, stream.bit_rate = width, height, 4_000_000
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        stream.options = options
        for number in range(frames):
            frame = av.VideoFrame(width, height, stream.pix_fmt)
            for index, plane in enumerate(frame.planes):
                lines = np.full((plane.height, plane.line_size), 128 if index else level(number), np.uint8)
                if index == 0:
                    lines[: height // 4, : width // 2] = rng.integers(100, 256, (height // 4, width // 2))
                plane.update(lines)
            frame.pts = number
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def coding_error(pixels: np.ndarray, number: int) -> float:
    """Of the flat part, away from the speckled one."""
    return float(np.abs(pixels[pixels.shape[0] // 2 :].astype(int) - level(number)).max())


@pytest.mark.parametrize(("codec", "container"), KINDS)
def test_frames_come_in_order_with_their_number_time_and_luma(tmp_path: Path, codec: str, container: str) -> None:
    video = Video(write_video(tmp_path / f"a b.{container}", codec))
    assert (video.width, video.height) == (90, 70)
    assert video.expected_stations in (FRAMES, None)
    numbers, times = [], []
    for images in video.stations():
        assert images.takes == (0,)
        pixels = images.read(0)
        assert (pixels.shape, pixels.dtype) == ((70, 90), np.uint8)
        assert coding_error(pixels, images.station) <= CODED_LEVELS
        numbers.append(images.station)
        times.append(images.time_s)
    assert numbers == list(range(FRAMES))
    assert np.allclose(times, np.arange(FRAMES) / RATE, atol=1e-3)  # Matroska counts milliseconds
    assert video.refusals == ()


@pytest.mark.parametrize("width", [34, 66, 90, 130, 642])
def test_the_padding_at_the_end_of_lines_is_cut_off(tmp_path: Path, width: int) -> None:
    path = write_video(tmp_path / "a.mp4", size=(width, 50), frames=3)
    with av.open(str(path)) as container:
        assert next(container.decode(video=0)).planes[0].line_size != width
    for images in Video(path).stations():
        pixels = images.read(0)
        assert pixels.shape == (50, width)
        assert coding_error(pixels, images.station) <= CODED_LEVELS


def test_luma_stays_in_the_range_it_was_coded_and_colour_is_three_channels(tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.mp4", frames=2)
    luma = next(Video(path).stations()).read(0)
    colour = next(Video(path, channel="red").stations()).read(0)
    assert colour.shape == (70, 90, 3)
    assert np.median(luma) == level(0)
    assert abs(np.median(colour) - (level(0) - 16) * 255 / 219) <= 2  # limited range expanded by the conversion only


def test_ten_bit_luma_is_scaled_to_sixteen_bits(tmp_path: Path) -> None:
    path = tmp_path / "a.mkv"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=RATE)
        stream.width, stream.height, stream.pix_fmt = 50, 40, "yuv420p10le"
        frame = av.VideoFrame(50, 40, "yuv420p10le")
        for plane in frame.planes:
            plane.update(np.full((plane.height, plane.line_size // 2), 513, "<u2"))
        frame.pts = 0
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    pixels = next(Video(path).stations()).read(0)
    assert (pixels.dtype, pixels.shape) == (np.uint16, (40, 50))
    assert (pixels == 513 << 6).all()


@pytest.mark.parametrize(
    ("codec", "container"), [("libx264", "mp4"), ("mjpeg", "avi"), ("mjpeg", "mp4"), ("mpeg2video", "mp4")]
)
def test_damaged_packets_cost_frames_but_no_wrong_picture(tmp_path: Path, codec: str, container: str) -> None:
    path = write_video(tmp_path / f"whole.{container}", codec, g="10")
    with av.open(str(path)) as opened:
        packets = [(packet.pos, packet.size) for packet in opened.demux(video=0) if packet.size and packet.pos]
    rng = np.random.default_rng(1)
    lost = 0
    for trial in range(8):
        data = bytearray(path.read_bytes())
        start, size = packets[int(rng.integers(5, len(packets) - 5))]
        place = start + size // 3
        data[place : place + size // 3] = rng.bytes(size // 3)
        damaged = tmp_path / f"{trial}.{container}"
        damaged.write_bytes(data)
        video = Video(damaged)
        seen = []
        for images in video.stations():
            assert coding_error(images.read(0), images.station) <= CODED_LEVELS
            seen.append(images.station)
        assert all(before < after for before, after in pairwise(seen))
        refused = sum(refusal.count for refusal in video.refusals)
        assert len(seen) + refused == FRAMES
        lost += refused > 0
    assert lost >= 4  # random bytes may happen to decode


def test_a_video_cut_short_gives_what_is_left_and_says_so(tmp_path: Path) -> None:
    data = write_video(tmp_path / "a.avi", "mjpeg").read_bytes()
    short = tmp_path / "short.avi"
    short.write_bytes(data[: len(data) * 6 // 10])
    video = Video(short)
    seen = len(list(video.stations()))
    assert 10 < seen < 30
    assert seen + sum(refusal.count for refusal in video.refusals) == FRAMES
    assert "cut short" in str(video.refusals[-1])


def test_frames_outside_the_odometry_are_left_out_and_counted(tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.mp4")
    (tmp_path / "odometry.csv").write_text("time_s,axial_m\n0,0\n0.5,1\n")
    odometry = read_odometry(tmp_path / "odometry.csv")
    video = Video(path, odometry=odometry)
    stations = [images.station for images in video.stations()]
    assert stations == list(range(13))  # 0.5 s is frame 12.5
    (refusal,) = video.refusals
    assert (refusal.count, refusal.station) == (FRAMES - 13, 13)
    assert "odometry shorter than the video" in str(refusal)
    assert len(list(video.stations())) == 13
    assert video.refusals == (refusal,)


def test_odometry_beside_the_video_leaves_nothing_and_is_an_error(tmp_path: Path) -> None:
    path = write_video(tmp_path / "a.mp4", frames=5)
    elsewhere = Odometry(np.array([100.0, 200.0]), np.zeros(2), np.zeros(2))
    with pytest.raises(InputError, match="odometry shorter than the video"):
        list(Video(path, odometry=elsewhere).stations())


def test_what_is_no_video_is_an_input_error(tmp_path: Path) -> None:
    text, empty, sound = tmp_path / "text.mp4", tmp_path / "empty.mp4", tmp_path / "sound.mp4"
    text.write_text("not a video at all " * 50)
    empty.write_bytes(b"")
    with av.open(str(sound), "w") as container:
        stream = container.add_stream("aac", rate=44100)
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), "fltp", "mono")
        frame.sample_rate = 44100
        container.mux(stream.encode(frame))
        container.mux(stream.encode())
    for path in (text, empty, tmp_path, tmp_path / "absent.mp4", sound):
        with pytest.raises(InputError, match=path.name):
            Video(path)
    with pytest.raises(InputError, match="luma, red, green, blue"):
        Video(write_video(tmp_path / "a.mp4", frames=2), channel="infrared")


def test_a_frame_has_take_zero_only(tmp_path: Path) -> None:
    images = next(Video(write_video(tmp_path / "a.mp4", frames=2)).stations())
    with pytest.raises(ImageError, match="take 0 only"):
        images.read(1)


def test_memory_does_not_grow_with_the_length_of_the_video(tmp_path: Path) -> None:
    peaks = []
    for frames in (10, 200):
        video = Video(write_video(tmp_path / f"{frames}.mp4", size=(320, 240), frames=frames))
        list(zip(range(2), video.stations(), strict=False))
        tracemalloc.start()
        for images in video.stations():
            images.read(0)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < peaks[0] + 320 * 240


def test_a_frame_whose_colours_nobody_can_make_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fuzzing found such a frame: its header claims a kind of colours that FFmpeg cannot convert from."""
    path = write_video(tmp_path / "a.mp4")
    convert, seen = av.VideoFrame.to_ndarray, []

    class Frame:
        def __init__(self, frame: av.VideoFrame) -> None:
            self._frame = frame

        def to_ndarray(self, **options: str) -> np.ndarray:
            seen.append(self)
            if len(seen) == 3:
                raise av.error.OSError(95, "Operation not supported")
            return convert(self._frame, **options)

    pixels = _video.frame_pixels
    monkeypatch.setattr(_video, "frame_pixels", lambda frame, channel: pixels(Frame(frame), channel))
    video = Video(path, "red")
    numbers = [images.station for images in video.stations()]
    assert numbers == [number for number in range(FRAMES) if number != 2]
    (refusal,) = video.refusals
    assert (refusal.count, refusal.station) == (1, 2)
    assert "cannot be turned into red, green and blue" in str(refusal)

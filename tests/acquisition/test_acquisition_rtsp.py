"""A film served by real RTSP servers gives the rings of the film, whatever happens on the way."""

import signal
import subprocess
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from live_parts import HERE, PICTURES, Record, free_port, python, run

from calibore.acquisition import LEFT_OUT, Wanted, described
from calibore.errors import InputError, OutputError
from calibore.scans import open_profile

pytest.importorskip("rtsp", reason="needs the RTSP server rtsp-rs (a development dependency, for Linux and macOS)")
SYSTEM_PYTHON = "/usr/bin/python3"
NEXT = 1
"""A picture is complete when the next begins (FFmpeg does not trust the mark that ends it), or the stream is silent."""
KEY_FRAMES = 5
"""Pictures from key frame to key frame."""


@contextmanager
def serving(*films: Path, port: int, more=(), script: str = "rtsp_server.py"):
    server = python(HERE / script, port, *films, *more)
    try:
        assert server.stdout.readline() == "ready\n"
        yield server
    finally:
        server.kill()
        server.communicate()


def address(port: int) -> str:
    return f"rtsp://127.0.0.1:{port}/stream"


def wanted(film: Path, port: int, **more) -> Wanted:
    return Wanted(address(port), film / "scan.toml", **{"keep": True, **more})


def rings(out: Path) -> dict[str, np.ndarray]:
    with open_profile(out) as dataset:
        names = ("station", "axial", "time_s", "radius", "u_independent", "u_common", "status")
        return {name: dataset[name].values for name in names}


def same_wall(ours, theirs, rows=slice(None), their_rows=slice(None)) -> None:
    """The pictures are the same bytes after decoding, so the rings are the same numbers, far within the video's u."""
    for name in ("radius", "u_independent", "u_common"):
        np.testing.assert_array_equal(ours[name][rows], theirs[name][their_rows])


def test_a_film_over_rtsp_gives_the_rings_of_the_film(film, tmp_path):
    port = free_port()
    with serving(film / "film.mp4", port=port):
        summary = run(wanted(film, port), tmp_path / "out", count=PICTURES, silence=1.0)
    ours, theirs = rings(tmp_path / "out"), rings(film.parent / "profiled")
    same_wall(ours, theirs)
    assert ours["station"].tolist() == list(range(PICTURES))
    np.testing.assert_array_equal(ours["axial"], theirs["axial"])
    assert ours["time_s"] == pytest.approx(theirs["time_s"], abs=1e-3)
    assert (summary["counts"]["images"], summary["counts"]["dropped_images"]) == (PICTURES, 0)
    with pytest.raises(OutputError, match="no camera can repeat"):
        run(wanted(film, port), tmp_path / "out")


def test_gstreamer_s_server_over_tcp_gives_them_too(film, tmp_path):
    needed = "import gi; gi.require_version('GstRtspServer', '1.0'); from gi.repository import GstRtspServer"
    if (
        not Path(SYSTEM_PYTHON).exists()
        or subprocess.run([SYSTEM_PYTHON, "-c", needed], capture_output=True).returncode
    ):
        pytest.skip("GStreamer's RTSP server is not installed; gstreamer_server.py says what it takes")
    port = free_port()
    command = [SYSTEM_PYTHON, HERE / "gstreamer_server.py", str(port), film / "film.mp4"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout.readline() == "ready\n"
        try:
            run(wanted(film, port), tmp_path / "out", count=PICTURES)
        finally:
            server.kill()
    same_wall(rings(tmp_path / "out"), rings(film.parent / "profiled"))


def test_a_server_that_dies_and_comes_back_costs_what_it_did_not_send(film, tmp_path):
    port, before = free_port(), 4
    with serving(film / "film.mp4", port=port, more=("--rate", 5)) as first:
        replaced = []

        def replace_server(vitals):
            if vitals.rings == before:
                first.send_signal(signal.SIGKILL)
                first.wait()
                replaced.append(serving(film / "film.mp4", port=port))
                replaced[0].__enter__()

        watch = Record(each=replace_server)
        try:
            summary = run(
                wanted(film, port), tmp_path / "out", watch=watch, silence=1.0, count=before + PICTURES - NEXT
            )
        finally:
            replaced[0].__exit__(None, None, None)
    said = " ".join(watch.sentences)
    assert f"{address(port)} is gone (" in said
    assert f"{address(port)} is back." in watch.sentences
    assert summary["live"]["absences"] == 1
    assert any("Use a speed or an odometry table" in warning for warning in summary["warnings"])
    ours, theirs = rings(tmp_path / "out"), rings(film.parent / "profiled")
    back = next(n for n in range(before, len(ours["radius"])) if np.array_equal(ours["radius"][n], theirs["radius"][0]))
    same_wall(ours, theirs, slice(back), slice(back))
    same_wall(ours, theirs, slice(back, None), slice(len(ours["station"]) - back))
    assert np.all(np.diff(ours["station"]) == 1)
    assert np.all(np.diff(ours["time_s"]) > 0)


def test_a_server_that_stutters_is_waited_for(film, tmp_path):
    port, watch = free_port(), Record()
    with serving(film / "film.mp4", port=port, more=("--silent-after", 4, 1.0)):
        summary = run(wanted(film, port), tmp_path / "out", watch=watch, count=PICTURES - NEXT)
    assert watch.sentences == []
    assert summary["live"]["absences"] == 0
    same_wall(rings(tmp_path / "out"), rings(film.parent / "profiled"), their_rows=slice(PICTURES - NEXT))


def test_pictures_of_another_size_are_refused_with_one_sentence_and_the_rest_is_measured(film, tmp_path):
    port, watch = free_port(), Record()
    with serving(film / "film.mp4", film / "smaller.mp4", film / "film.mp4", port=port):
        summary = run(wanted(film, port), tmp_path / "out", watch=watch, count=2 * PICTURES - NEXT)
    assert len(watch.sentences) == 2
    assert "now sends pictures of 160 x 120 px but the rig's camera has 320 x 240 px" in watch.sentences[0]
    assert "sends pictures of 320 x 240 px again" in watch.sentences[1]
    assert summary["counts"]["refused_images"] == 5
    ours, theirs = rings(tmp_path / "out"), rings(film.parent / "profiled")
    assert ours["station"].tolist() == [*range(PICTURES), *range(PICTURES + 5, 2 * PICTURES + 4)]
    same_wall(ours, theirs, slice(PICTURES))
    same_wall(ours, theirs, slice(PICTURES, None), slice(PICTURES - NEXT))
    assert len((tmp_path / "out" / LEFT_OUT).read_text(encoding="utf-8").splitlines()) == 1 + 5


def test_a_stream_joined_late_begins_with_its_next_key_frame(film, tmp_path):
    port = free_port()
    other = Record()
    with serving(film / "film.mp4", port=port, more=("--rate", 20, "--loops", 20)):
        run(wanted(film, port), tmp_path / "first", watch=other, count=2)
        summary = run(wanted(film, port), tmp_path / "out", count=PICTURES)
    ours, theirs = rings(tmp_path / "out"), rings(film.parent / "profiled")
    starts = [n for n in range(PICTURES) if np.array_equal(ours["radius"][0], theirs["radius"][n])]
    assert len(starts) == 1
    assert starts[0] % KEY_FRAMES == 0
    assert summary["counts"]["refused_images"] == 0


def test_an_address_where_nothing_answers_is_told_without_its_password(film, tmp_path):
    port = free_port()
    source = Wanted(f"rtsp://name:secret@127.0.0.1:{port}/stream", film / "scan.toml")
    job, _ = described(source)
    with pytest.raises(InputError) as caught:
        run(source, tmp_path / "out", patience=0.0)
    assert str(caught.value).startswith(f"rtsp://127.0.0.1:{port}/stream sends no picture (connection refused); check")
    assert "secret" not in str(caught.value) + job.spec.identity
    assert list(tmp_path.iterdir()) == []

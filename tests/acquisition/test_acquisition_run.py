"""A run that is overloaded stays fresh and small; one that is stopped or killed keeps what it has measured."""

import gc
import json
import os
import shutil
import signal
import sys
import time
import tracemalloc
from dataclasses import dataclass

import numpy as np
import pytest
from live_parts import PATTERN, PICTURES, Record, contents, python, run

from calibore.acquisition import (
    LEFT_OUT,
    Arrival,
    Limits,
    LiveJob,
    Wanted,
    described,
    journal_folder,
    live_scan,
    placed_by_speed,
)
from calibore.errors import InputError, OutputError
from calibore.images import StationImages
from calibore.scans import read_rings

PARTS = ("profile.zarr", "points.zarr", "rings.csv")
MOST = 4
"""Pictures that may wait."""
WORKERS = 2


@dataclass
class FastCamera:
    """A source that sends pictures faster than they can be measured; `fresh`: each in memory of its own."""

    images: list
    rate: float
    fresh: bool = False
    name: str = "fast camera"
    keeps: bool = False
    waiting: int = 0
    connected: bool = True

    def arrivals(self, backlog, stop):
        begun = time.monotonic()
        for number in range(10**9):
            if stop.wait(max(0.0, begun + number / self.rate - time.monotonic())):
                return
            image = self.images[number % len(self.images)]
            image = image.copy() if self.fresh else image
            station = StationImages(number, (0,), lambda take, image=image: image, time_s=number / self.rate)
            yield Arrival(station, time.monotonic())


@pytest.mark.parametrize("rate", [500.0, 3000.0])
def test_overloaded_a_run_drops_the_oldest_and_no_ring_is_later_than_its_queue_allows(film, images, tmp_path, rate):
    job, _ = described(Wanted("rtsp://camera/1", film / "scan.toml"))
    live = LiveJob(job.spec, job.job, placed_by_speed(0.1), WORKERS, MOST)
    told = []
    watch = Record(each=lambda vitals: told.append(time.monotonic()))
    summary = live_scan(live, lambda book: FastCamera(images, rate), tmp_path / "out", limits=Limits(60), watch=watch)
    slowest = max(np.diff(told))
    queue = MOST + WORKERS + 1
    assert max(watch.latencies[1:]) <= (queue + 1) * slowest
    stations = read_rings(tmp_path / "out")["station"]
    assert np.all(np.diff(stations) > 0)
    lines = (tmp_path / "out" / LEFT_OUT).read_text(encoding="utf-8").splitlines()[1:]
    dropped = {int(line.split(",")[0]): float(line.split(",")[1]) for line in lines}
    assert len(dropped) == summary["counts"]["dropped_images"] > 0
    assert not set(dropped) & set(stations.tolist())
    assert set(range(stations[-1])) <= set(dropped) | set(stations.tolist())
    assert all(abs(moment - number / rate) < 1e-9 for number, moment in dropped.items())
    assert any(f"{len(dropped)} pictures were dropped between" in warning for warning in summary["warnings"])


def started(*arguments):
    return python("-m", "calibore", "live", *arguments, "--no-pictures", "--json")


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_ctrl_c_ends_a_run_with_a_whole_result(pictures, tmp_path):
    out = tmp_path / "out"
    process = started(pictures, "--out", out)
    rows = [json.loads(process.stdout.readline()) for _ in range(PICTURES)]
    process.send_signal(signal.SIGINT)
    rest, errors = process.communicate()
    assert (process.returncode, errors) == (0, "")
    assert json.loads(rest)["summary"]["live"]["ended"] == "stopped by hand"
    assert contents(out, *PARTS) == contents(pictures.parent / "profiled", *PARTS)
    rings = read_rings(out)
    for name, values in rings.items():
        if name != "flags":
            assert [row[name] for row in rows] == pytest.approx(values.tolist(), nan_ok=True)
    assert os.listdir(tmp_path) == ["out"]


@pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX signals")
def test_killed_a_run_loses_no_ring_that_it_has_told_and_goes_on_where_it_was(pictures, tmp_path):
    scan, out, half = tmp_path / "pipe", tmp_path / "out", PICTURES // 2
    shutil.copytree(pictures, scan)
    for number in range(half, PICTURES):
        (scan / PATTERN.format(station=number, take=0)).unlink()
    process = started(scan, "--out", out)
    for _ in range(half):
        process.stdout.readline()
    process.kill()
    process.communicate()
    assert not out.exists()
    with pytest.raises(OutputError, match=f"holds {half} rings that a run into .* go on with them by --resume"):
        run(Wanted(str(scan)), out)
    shutil.copytree(journal_folder(out), journal_folder(tmp_path / "finished"))
    summary = run(Wanted(str(scan)), tmp_path / "finished", finish_only=True)
    assert (summary["counts"]["stations"], summary["live"]["rings_of_a_killed_run"]) == (half, half)
    header, *rows = (pictures.parent / "profiled" / "rings.csv").read_bytes().splitlines()
    assert (tmp_path / "finished" / "rings.csv").read_bytes().splitlines() == [header, *rows[:half]]
    for number in range(half, PICTURES):
        shutil.copy(pictures / PATTERN.format(station=number, take=0), scan)
    watch = Record()
    run(Wanted(str(scan), idle=0.5), out, watch=watch, resume=True)
    assert [row["station"] for row in watch.rows] == list(range(half, PICTURES))
    assert contents(out, *PARTS) == contents(pictures.parent / "profiled", *PARTS)
    assert sorted(os.listdir(tmp_path)) == ["finished", "out", "pipe"]


def test_a_run_is_not_gone_on_with_by_another_rig(pictures, tmp_path):
    def die(vitals):
        raise RuntimeError("killed")

    scan, out = tmp_path / "pipe", tmp_path / "out"
    shutil.copytree(pictures, scan)
    with pytest.raises(RuntimeError, match="killed"):
        run(Wanted(str(scan)), out, watch=Record(each=die))
    rig = scan / "rig.toml"
    rig.write_text(rig.read_text(encoding="utf-8").replace("k = 192", "k = 193"), encoding="utf-8")
    with pytest.raises(InputError, match="was measured with another rig file"):
        run(Wanted(str(scan)), out, resume=True)


FEW, MANY = 15, 75
MARGIN = 8 * 2**20
"""Bytes: what waits to fill a chunk of points takes up to 6 MB; the further pictures alone would take 14 MB."""


def test_five_times_the_pictures_take_no_more_memory(film, images, tmp_path):
    job, _ = described(Wanted("rtsp://camera/1", film / "scan.toml"))
    live = LiveJob(job.spec, job.job, placed_by_speed(0.1), WORKERS, MOST)
    taken = {}

    def weigh(vitals):
        if vitals.rings in (FEW, MANY):
            gc.collect()
            taken[vitals.rings] = tracemalloc.get_traced_memory()[0]

    def source(book):
        return FastCamera([image.copy() for image in images], 500.0, fresh=True)

    tracemalloc.start()
    try:
        live_scan(live, source, tmp_path / "out", limits=Limits(MANY), watch=Record(each=weigh))
    finally:
        tracemalloc.stop()
    assert taken[MANY] - taken[FEW] < MARGIN

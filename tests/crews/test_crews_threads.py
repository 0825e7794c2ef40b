"""Many stations on several threads: in order, and never more of them in memory than can be worked on."""

import threading
import time

import numpy as np
import pytest

from calibore.crews import AHEAD, in_order


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_results_come_in_the_order_of_the_items_however_long_each_takes(workers):
    pauses = np.random.default_rng(1).uniform(0, 0.003, 60)

    def work(number: int) -> int:
        time.sleep(pauses[number])
        return number**2

    assert list(in_order(range(60), work, workers=workers)) == [number**2 for number in range(60)]


@pytest.mark.parametrize("workers", [1, 2, 4])
@pytest.mark.parametrize("slow", ["work", "consumer"])
def test_items_are_drawn_only_as_fast_as_their_results_are_taken(workers, slow):
    lock, drawn, taken, most = threading.Lock(), 0, 0, 0

    def items():
        nonlocal drawn, most
        for number in range(40):
            with lock:
                drawn += 1
                most = max(most, drawn - taken)
            yield number

    def work(number: int) -> int:
        time.sleep(0.002 if slow == "work" else 0)
        return number

    for _ in in_order(items(), work, workers=workers):
        time.sleep(0.002 if slow == "consumer" else 0)
        with lock:
            taken += 1
    assert (drawn, taken) == (40, 40)
    assert most <= AHEAD * workers + 1


def test_all_workers_work_at_once():
    together = threading.Barrier(4, timeout=10)

    def work(_: int) -> int:
        return together.wait()

    assert len(set(in_order(range(4), work, workers=4))) == 4


@pytest.mark.parametrize("workers", [1, 3])
def test_a_failure_ends_the_work_and_nothing_is_drawn_any_more(workers):
    drawn = []

    def items():
        for number in range(1000):
            drawn.append(number)
            yield number

    def work(number: int) -> int:
        if number == 5:
            raise OSError("the disk has gone")
        return number

    results = in_order(items(), work, workers=workers)
    assert [next(results) for _ in range(5)] == [0, 1, 2, 3, 4]
    with pytest.raises(OSError, match="the disk has gone"):
        next(results)
    assert len(drawn) <= 6 + AHEAD * workers
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("calibore")]


def test_who_stops_taking_results_stops_the_work():
    finished = threading.Event()

    def items():
        try:
            yield from range(1000)
        finally:
            finished.set()

    results = in_order(items(), lambda number: number, workers=3)
    assert next(results) == 0
    results.close()
    del results
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("calibore")]

"""A reader that is too slow for its stream skips to what is fresh; one that keeps up skips nothing."""

import numpy as np

from calibore.images._pace import Pace

RATE = 25.0
KEY = 10
"""Packets from key frame to key frame."""


def read(sent, stamped, *, work: float, skip: float = 1e-4):
    """Which packets are skipped, and how late each other one is read, where reading one takes `work` [s]: `sent` at
    these moments, bearing these times.
    """
    pace, free, skipped, late = Pace(), 0.0, [], {}
    for number, (moment, time) in enumerate(zip(sent, stamped, strict=True)):
        begin = max(free, moment)
        if pace.skips(time, begin, key=number % KEY == 0):
            skipped.append(number)
            free = begin + skip
        else:
            late[number] = begin - moment
            free = begin + work
    return skipped, late


def test_a_reader_that_keeps_up_skips_nothing_whatever_the_clocks_and_the_network_do():
    rng = np.random.default_rng(6)
    times = np.arange(3000) / RATE
    jitter = np.maximum.accumulate(times + rng.exponential(0.05, times.size))
    paused = times + 3.0 * (times > 40)  # the source stops for 3 s, and its clock too
    stalled = np.where((times > 40) & (times < 43), 43.0, times)  # the network stops for 3 s, then brings all at once
    for sent, stamped in ((times, times), (jitter, times), (times * 1.0005, times), (paused, times), (stalled, times)):
        assert read(sent, stamped, work=0.01)[0] == []


def test_a_reader_that_is_too_slow_is_never_more_than_a_few_seconds_late_and_begins_again_at_key_frames():
    times = np.arange(3000) / RATE
    for work in (0.05, 0.08, 0.4):
        skipped, late = read(times, times, work=work)
        assert max(late.values()) < 3.0 + 4 * work
        after = [number for number in late if number - 1 in set(skipped)]
        assert after
        assert all(number % KEY == 0 for number in after)

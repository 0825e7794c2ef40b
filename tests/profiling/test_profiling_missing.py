"""What could not be measured is counted and named, in words a person would use."""

import time

import numpy as np
import pytest

from calibore.profiling._missing import NAMED, counted, gap_sentences, refused_sentence, some, unplaced_sentence


def sentences(stations, *, takes=1, expected=()):
    return gap_sentences([(station, takes) for station in stations], expected)


def test_one_is_one_and_two_are_two():
    assert (counted(1, "image"), counted(2, "image"), counted(0, "image")) == ("1 image", "2 images", "0 images")


def test_long_lists_end_with_how_many_more_there_are():
    assert some(["a"]) == "a"
    assert some(list(range(NAMED))).endswith(f", {NAMED - 1}")
    assert some(list(range(NAMED + 3))).endswith(f"{NAMED - 1} and 3 more")
    assert some([1, 2], 50) == "1, 2 and 48 more"


@pytest.mark.parametrize("step", [1, 2, 5])
def test_a_regular_numbering_has_no_gaps_whatever_its_step(step):
    assert sentences(range(10, 10 + 20 * step, step)) == []


def test_every_station_missing_from_a_regular_numbering_is_named():
    rng = np.random.default_rng(3)
    for _ in range(200):
        step, first, count = rng.integers(1, 7), rng.integers(-50, 1000), rng.integers(30, 80)
        numbers = first + step * np.arange(count)
        gone = np.sort(rng.choice(np.arange(1, count - 1), size=rng.integers(1, 4), replace=False))
        found = sentences(np.delete(numbers, gone).tolist())
        missing = ", ".join(map(str, numbers[gone].tolist()))
        why = "the numbering of the others has gaps there"
        assert found == [f"{counted(len(gone), 'station')} without an image, but {why}: {missing}."]


def test_an_irregular_numbering_is_nobodys_mistake():
    rng = np.random.default_rng(4)
    assert sentences(np.cumsum(rng.integers(1, 30, 50)).tolist()) == []
    assert sentences([3]) == sentences([]) == sentences([1, 9, 10]) == []


def test_an_enormous_gap_is_counted_without_listing_it():
    begun = time.perf_counter()
    (sentence,) = sentences([*range(20), 10**15])
    assert sentence.startswith(f"{10**15 - 20} stations without an image")
    assert sentence.endswith(f"20, 21, 22, 23, 24, 25, 26, 27, 28, 29 and {10**15 - 30} more.")
    assert time.perf_counter() - begun < 1


def test_the_motion_table_knows_better_than_the_numbering():
    assert sentences([1, 2, 3, 7, 8, 9], expected={1, 2, 3, 7, 8, 9}) == []
    (sentence,) = sentences([1, 2, 3], expected=range(1, 6))
    assert sentence == "2 stations without an image, but motion.table has a row for them: 4, 5."


def test_a_station_with_fewer_takes_is_named_while_it_is_the_exception():
    assert gap_sentences([(1, 2), (2, 2), (3, 1), (4, 2)]) == ["1 station has fewer than the usual 2 takes: 3."]
    assert gap_sentences([(n, 3 if n % 10 else 1) for n in range(20)]) == [
        "2 stations have fewer than the usual 3 takes: 0, 10."
    ]
    assert gap_sentences([(1, 1), (2, 2), (3, 1), (4, 2)]) == []  # as in the demonstration: some simply have more


def test_a_take_too_many_at_one_station_is_no_lack_at_the_others():
    assert gap_sentences([(1, 2), *((n, 1) for n in range(2, 30))]) == []


def test_images_refused_for_one_reason_stand_together():
    skipped = [{"image": f"{n}.png", "reason": "it is empty" if n % 2 else "it is truncated"} for n in range(4)]
    assert refused_sentence(4, skipped) == (
        "4 images could not be used: 0.png, 2.png (it is truncated); 1.png, 3.png (it is empty)."
    )


def test_thousands_of_refused_images_stay_one_readable_sentence():
    same = [{"image": f"{n}.png", "reason": "it is empty"} for n in range(5000)]
    other = [{"image": f"{n}.png", "reason": f"a line was found on {n} of 1500 rays"} for n in range(5000)]
    assert len(refused_sentence(5000, same)) < 300
    assert "and 4990 more (it is empty)" in refused_sentence(5000, same)
    assert len(refused_sentence(5000, other)) < 1000
    assert refused_sentence(5000, other).endswith("4990 more reasons in summary.json.")


def test_stations_without_a_row_in_the_table_are_named():
    assert unplaced_sentence([4]) == "motion.table has no row for 1 station, whose image was left out: 4."
    assert unplaced_sentence([4, 9]) == "motion.table has no row for 2 stations, whose images were left out: 4, 9."

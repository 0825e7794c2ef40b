"""What of a side-facing scan is missing, in words."""

from collections import Counter
from collections.abc import Sequence

from calibore.profiling._missing import FEW_SHARE, counted, gap_sentences, some
from calibore.profiling._side._stop import Stop


def gaps_of(stops: Sequence[Stop], *, expected: Sequence[int] = ()) -> list[str]:
    """Sentences on stations, angular stops and takes that the others let one expect; `expected`: stations of the motion
    table.
    """
    takes = {(stop.images.station, stop.images.angular): len(stop.images.takes) for stop in stops}
    stations, angles = sorted({station for station, _ in takes}), sorted({angular for _, angular in takes})
    found = gap_sentences([(station, 1) for station in stations], expected)
    found += [
        sentence.replace("station", "angular stop") for sentence in gap_sentences([(angular, 1) for angular in angles])
    ]
    lacking = [(s, a) for s in stations for a in angles if (s, a) not in takes]
    if lacking:
        found.append(f"{counted(len(lacking), 'stop')} without an image, but others have one there: {_named(lacking)}.")
    usual, _ = Counter(takes.values()).most_common(1)[0]
    fewer = [key for key, count in sorted(takes.items()) if count < usual]
    if fewer and len(fewer) < FEW_SHARE * len(takes):
        have = "has" if len(fewer) == 1 else "have"
        found.append(f"{counted(len(fewer), 'stop')} {have} fewer than the usual {usual} takes: {_named(fewer)}.")
    return found


def _named(stops: Sequence[tuple[int, int]]) -> str:
    return some([f"station {station} angular stop {angular}" for station, angular in stops])

"""`python -m fuzzing`: every entry until each has had its minutes of the processor; see docs/how-to/fuzz.md."""

import argparse
from pathlib import Path

from fuzzing._ledger import table
from fuzzing._runs import end_on_signals, every_entry, names, run

HOME = Path(__file__).parent / "out"


def main() -> None:
    """Run the entries named, or all; `--table` prints what was done so far."""
    parser = argparse.ArgumentParser(prog="python -m fuzzing", description=main.__doc__)
    parser.add_argument("entries", nargs="*", help=f"some of {', '.join(names())}; all where none is named")
    parser.add_argument("--minutes", type=float, default=10.0, help="of the processor for each entry, earlier runs too")
    parser.add_argument("--seed", type=int, default=1, help="of the first run of an entry; later runs go on from there")
    parser.add_argument("--pause-while", type=Path, help="stand still while this file exists")
    parser.add_argument("--home", type=Path, default=HOME, help="where corpora, cases and the ledger are kept")
    parser.add_argument("--table", action="store_true", help="only print the table of what was done")
    parser.add_argument("--attempt", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    given.home.mkdir(parents=True, exist_ok=True)
    if given.table:
        print("\n".join(table(given.home)))
    elif given.attempt:
        from fuzzing._trying import work

        work(given.entries[0], given.home, seed=given.seed, minutes=given.minutes)
    else:
        end_on_signals()
        for name in every_entry(given.entries):
            run(name, given.home, minutes=given.minutes, seed=given.seed, pause=given.pause_while)
        print("\n".join(table(given.home)))


main()

"""What is wrong with a tactile scan is told in one sentence, before anything is written."""

import numpy as np
import pytest
from tactile_walls import NOMINAL, PROBE, SCAN, written

from calibore.errors import InputError
from calibore.profiling import profile_scan


def voltages(folder, name, change):
    table = np.loadtxt(folder / name, delimiter=",")
    np.savetxt(folder / name, change(table), delimiter=",", fmt="%.6f")


def exchanged(folder):
    for one, other in (("signal.csv", "old"), ("bias.csv", "signal.csv"), ("old", "bias.csv")):
        (folder / one).rename(folder / other)


def cell(folder, text):
    lines = (folder / "signal.csv").read_text().splitlines()
    lines[2] = f"{text}," + lines[2].split(",", 1)[1]
    (folder / "signal.csv").write_text("\n".join(lines))


def ragged(folder):
    lines = (folder / "bias.csv").read_text().splitlines()
    lines[3] = lines[3].rsplit(",", 1)[0]
    (folder / "bias.csv").write_text("\n".join(lines))


def of_scan(old, new):
    return lambda folder: (folder / "scan.toml").write_text(SCAN.replace(old, new))


def of_probe(old, new):
    return lambda folder: (folder / "probe.toml").write_text(PROBE.replace(old, new))


MISTAKES = {
    "shapes differ": (lambda f: voltages(f, "bias.csv", lambda t: t[:-1]), "signal.csv has 6 rows.*bias.csv 5 rows"),
    "signal above bias": (lambda f: voltages(f, "signal.csv", lambda t: t + 6), "between 0 V and its bias.*row 1, col"),
    "exchanged": (exchanged, "are the two files exchanged"),
    "negative": (lambda f: voltages(f, "signal.csv", lambda t: -t), "between 0 V and its bias"),
    "a column missing": (
        lambda f: [voltages(f, name, lambda t: t[:, :-1]) for name in ("signal.csv", "bias.csv")],
        "399 stops a ring.*359.1 deg instead of 360",
    ),
    "a cell missing": (ragged, "bias.csv, line 4 has 399 cells, the first row has 400"),
    "text": (lambda f: cell(f, "off"), 'line 3, column 1 holds "off", which is no number'),
    "all missing": (lambda f: voltages(f, "signal.csv", lambda t: np.nan * t), "hold no reading with both voltages"),
    "empty": (lambda f: (f / "signal.csv").write_text("# volts\n"), "holds no numbers"),
    "a picture": (lambda f: (f / "signal.csv").write_bytes(b"\x89PNG\xff\xfe"), "cannot be read as text"),
    "another step": (of_scan("0.9 deg", "1 deg"), "400 deg instead of 360 deg; correct motion.angular"),
    "no stops": (of_scan("angular =", "# angular ="), "does not say where the probe's stops are; add"),
    "no probe": (of_scan("probe =", "# probe ="), "names no probe; add probe = .*calibore calibrate probe"),
    "no such probe": (of_scan("probe.toml", "other.toml"), "tactile.probe.*names no existing file"),
    "another kind of rig": (of_probe("tactile-probe", "single-cone"), "configuration.*tactile-probe"),
    "another unit": (of_scan('"6 in"', '"6 mm"'), "pipe of nominal radius 6 mm; check the unit"),
    "a huge tip": (of_scan('"0.0625 in"', '"7 in"'), "less than tactile.tip_radius"),
    "a negative drift": (of_scan('drift = "0 in"', 'drift = "-1 mm"'), "tactile.drift"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_sentence_that_says_what_to_do(mistake, tmp_path):
    change, said = MISTAKES[mistake]
    folder = written(tmp_path / "scan", np.full((6, 400), NOMINAL))
    change(folder)
    with pytest.raises(InputError, match=said) as caught:
        profile_scan(folder, tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert str(caught.value).rstrip().endswith((".", ")."))
    assert not (tmp_path / "out").exists()

"""Journal, odometry, panel and command line, each alone."""

import io
import re
import time
from pathlib import Path

import numpy as np
import pytest

from calibore.acquisition import (
    Journal,
    Latencies,
    LiveOdometry,
    Vitals,
    Wanted,
    described,
    panel,
    plain_line,
    speed_of,
)
from calibore.cli._live_watch import watch_of
from calibore.errors import InputError, UsageError
from calibore.images import StationImages
from calibore.metrics import RingShape, ring_quantities
from calibore.profiling import row_quantities
from calibore.profiling._station import ring_row


def test_a_journal_cut_or_damaged_anywhere_gives_back_the_whole_records_before(tmp_path):
    rng, journal = np.random.default_rng(3), Journal(tmp_path / "journal")
    journal.begin({"identity": "a"})
    arrays = [{"x": rng.normal(size=n), "status": rng.integers(0, 9, n).astype(np.uint8)} for n in range(6)]
    for number, one in enumerate(arrays):
        journal.add({"kind": "ring", "number": number, "nothing": float("nan")}, one)
    journal.close()
    file = tmp_path / "journal" / "journal"
    whole = file.read_bytes()
    for cut in rng.integers(0, len(whole), 60).tolist():
        damaged = bytearray(whole)
        damaged[cut] ^= 0x55
        for content in (whole[:cut], bytes(damaged)):
            file.write_bytes(content)
            found = [one for one in journal.records() if one[0]["kind"] == "ring"]
            assert len(found) < len(arrays) or content == whole
            for (header, values), expected in zip(found, arrays, strict=False):
                assert header["number"] == [one[0]["number"] for one in found].index(header["number"])
                assert all(np.array_equal(values[name], expected[name]) for name in expected)
        journal.begin({"identity": "b"})
        journal.add({"kind": "ring", "number": 99})
        journal.close()
        assert [header for header, _ in journal.records()][-1]["number"] == 99


def test_a_row_of_rings_csv_gives_its_quantities_back():
    rng, clock = np.random.default_rng(4), 2 * np.pi * np.arange(400) / 400
    for share in (0.0, 0.3, 0.99):
        radius = np.where(rng.random(400) < share, np.nan, 0.15 + 1e-3 * np.cos(2 * clock))
        shape = RingShape(clock, radius, np.full(400, 1e-4), np.zeros((1, 400)), np.zeros(3))
        quantities = ring_quantities(shape, nominal_radius=0.15)
        assert repr(row_quantities(ring_row(quantities, takes=1))) == repr(quantities)


def station(seconds: float) -> StationImages:
    return StationImages(0, (0,), lambda take: np.zeros((1, 1), np.uint8), time_s=seconds)


def test_an_odometry_table_is_read_as_it_grows_and_a_half_written_row_is_no_row(tmp_path):
    path, began = tmp_path / "odometry.csv", 1.7e9
    path.write_text("time_s,axial_m\n0,0\n1,0.5\n2,1.", encoding="utf-8")
    place = LiveOdometry(path, lambda: began)
    assert place(station(0.5)).axial == pytest.approx(0.25)
    begun = time.monotonic()
    assert place(station(1.5)) is None
    assert time.monotonic() - begun > 0.5  # it waited for the row
    with path.open("a", encoding="utf-8") as file:
        file.write("25\n")
    assert place(station(1.5)).axial == pytest.approx(0.875)
    path.write_text(f"axial_m,time_s,roll_rad\n0,{began},0\n3,{began + 10},0.2\n", encoding="utf-8")
    placement = place(station(5.0))
    assert (placement.axial, placement.roll, placement.time) == pytest.approx((1.5, 0.1, 5.0))
    path.write_text("time,axial\n0,1\n", encoding="utf-8")
    with pytest.raises(InputError, match="needs the columns time_s,axial_m"):
        place(station(1.0))


def test_quantiles_of_latency_are_those_of_the_values_to_a_bin():
    rng, latencies = np.random.default_rng(5), Latencies()
    values = np.exp(rng.normal(-3, 1, 2000))
    for value in values:
        latencies.add(float(value))
    for share in (0.5, 0.95):
        assert latencies.quantile(share) == pytest.approx(np.quantile(values, share), rel=0.025)
    assert latencies.largest == values.max()


def test_the_panel_shows_what_is_measured_with_its_u95_in_few_short_lines():
    vitals = Vitals("rtsp://camera/1")
    assert all("nan" not in line for line in [*panel(vitals, unit="mm"), plain_line(vitals, unit="mm")])
    row = {"station": 7, "fraction": 0.987, "centre_x_m": 0.001, "centre_y_m": -0.002, "diameter_mean_m": 0.3048}
    row |= {"u_centre_x_m": 1e-5, "u_centre_y_m": 2e-5, "u_diameter_mean_m": 0.0001, "ovality_f1216_max_percent": 1.5}
    row |= {"ovality_f1216_min_percent": 1.25, "u_ovality_f1216_max_percent": 0.05, "u_ovality_f1216_min_percent": 0.1}
    vitals.ring(row, 0.0421)
    vitals.dropped, vitals.sentence = 3, "rtsp://camera/1 is gone (" + 100 * "x"
    text = panel(vitals, unit="mm")
    assert max(map(len, text)) <= 78
    for words in (
        "98.7 %",
        "304.800 mm +- 0.200",
        "1.50 % +- 0.10",
        "x 1.000  y -2.000 mm +- 0.040",
        "dropped 3",
        "42 ms",
    ):
        assert any(words in line for line in text), words
    assert "12.0000 in +- 0.0079" in plain_line(vitals, unit="in")


class Terminal(io.StringIO):
    """Somebody who looks."""

    def isatty(self) -> bool:
        return True


def test_the_panel_is_drawn_in_place_and_what_is_said_stays_above_it(monkeypatch, capsys):
    screen, vitals = Terminal(), Vitals("camera")
    monkeypatch.setattr("sys.stdout", screen)
    monkeypatch.setenv("COLUMNS", "40")
    with watch_of(unit="mm", json=False, quiet=False) as watch:
        watch.beat(vitals)
        height = screen.getvalue().count("\n")
        watch.say("camera is gone")
        time.sleep(0.25)
        watch.beat(vitals)
    assert screen.getvalue().count(f"\x1b[{height}A\r\x1b[J") == 1
    assert screen.getvalue().count("source    camera") == 2
    assert max(map(len, screen.getvalue().replace("\x1b[J", "\n").split("\n"))) < 40
    assert capsys.readouterr().err == "camera is gone\n"


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"step": 0.1, "speed": 0.1}, "Give one of --step, --speed and --odometry, not --step and --speed."),
        ({"rig": Path("rig.toml")}, "Give --rig and --radius together"),
        ({"scan": Path("a"), "rig": Path("b"), "nominal_radius": 0.1}, "Give either --scan, or --rig and --radius"),
    ],
)
def test_options_that_contradict_each_other_are_wrong_usage(given, sentence):
    with pytest.raises(UsageError, match=re.escape(sentence)):
        Wanted("0", **given)


def test_a_source_that_does_not_suit_is_told(tmp_path, film, pictures):
    with pytest.raises(UsageError, match=r"needs --scan scan.toml, or --rig rig.toml with --radius"):
        described(Wanted("rtsp://camera/1"))
    with pytest.raises(InputError, match="no folder of pictures that may be growing, and no stream"):
        described(Wanted(str(film)))
    with pytest.raises(UsageError, match="none is dropped"):
        described(Wanted(str(pictures), keep=False))
    with pytest.raises(UsageError, match=r"said by \[motion\]"):
        described(Wanted(str(pictures), step=0.1))
    for wrong in ("100 mm", "100 /s", "fast"):
        with pytest.raises(InputError):
            speed_of(wrong)
    assert speed_of("100 mm/s") == pytest.approx(0.1)
    live, _ = described(Wanted("rtsp://camera/1", rig=film / "rig.toml", nominal_radius=0.1524, speed=0.2))
    assert live.place(station(3.0)).axial == pytest.approx(0.6)

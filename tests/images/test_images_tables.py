"""Station and odometry tables: every mistake is named with its line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calibore.errors import InputError
from calibore.images import Odometry, StationRow, read_odometry, read_station_table


def table(folder: Path, text: str) -> Path:
    path = folder / "table.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_station_table_gives_every_column_it_has(tmp_path: Path) -> None:
    full = (
        "station,axial_m,clock_rad,time_s,roll_rad,pitch_rad,yaw_rad\n4,0.25,1,2,0.1,0.2,0.3\n\n2, -1e-3 ,0,0,0,0,0\n"
    )
    rows = read_station_table(table(tmp_path, full))
    assert rows[4] == StationRow(4, 0.25, clock=1.0, time=2.0, roll=0.1, pitch=0.2, yaw=0.3)
    assert rows[2].axial == -1e-3
    short = read_station_table(table(tmp_path, "\ufeffaxial_m,station,comment\n0.5,7,fine\n"))
    assert short == {7: StationRow(7, 0.5)}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "column station is missing"),
        ("station,clock_rad\n1,2\n", "column axial_m is missing"),
        ("station,axial_m\n", "no rows"),
        ("station,axial_m\n1,0\n2,x\n", 'line 3: axial_m = "x" is not a finite number'),
        ("station,axial_m\n1,nan\n", "line 2: axial_m"),
        ("station,axial_m\n1,inf\n", "line 2: axial_m"),
        ("station,axial_m\n1.5,0\n", "line 2: station"),
        ("station,axial_m\n1,0\n\n1,1\n", "line 4: station 1 is there twice"),
        ("station,axial_m\n1\n", "line 2: 1 cells"),
        ("station,axial_m,roll_deg\n1,0,3\n", "column roll_deg is not known; write roll_rad"),
        ("station,axial_m,axial_m\n1,0,0\n", "column axial_m is there twice"),
    ],
)
def test_a_mistake_in_a_station_table_is_named(tmp_path: Path, text: str, said: str) -> None:
    path = table(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_station_table(path)
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time_s\n1\n", "column axial_m is missing"),
        ("time_s,axial_m\n0,0\n1,1\n1,2\n", "line 4: time_s = 1 s does not increase"),
        ("time_s,axial_m\n0,0\n-1,1\n", "line 3: time_s = -1 s does not increase"),
        ("time_s,axial_m\n0,0\n", "at least 2"),
        ("time_s,axial_m,roll_rad\n0,0,0\n1,1,\n", 'line 3: roll_rad = ""'),
    ],
)
def test_a_mistake_in_an_odometry_table_is_named(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        read_odometry(table(tmp_path, text))
    assert said in str(caught.value)


def test_files_that_are_no_tables_are_input_errors(tmp_path: Path) -> None:
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00\x81" * 20)
    for path in (tmp_path / "absent.csv", tmp_path, binary):
        with pytest.raises(InputError):
            read_odometry(path)


@given(st.lists(st.floats(-100, 100), min_size=2, max_size=8, unique_by=lambda time: round(time, 3)), st.floats(0, 1))
def test_odometry_is_linear_between_rows_and_never_extrapolated(times: list[float], share: float) -> None:
    time = np.sort(times)
    axial, roll = np.cos(time), np.sin(time)
    odometry = Odometry(time, axial, roll)
    between = time[:-1] + share * np.diff(time)
    at = (1 - share) * axial[:-1] + share * axial[1:]
    inside = (between >= time[:-1]) & (between <= time[1:])
    # The share is recovered from rounded times: that rounding over the shortest step of 1e-3 s.
    assert np.allclose(odometry.at(between)[0][inside], at[inside], atol=1e-9)
    assert np.allclose(odometry.at(time)[1], roll, rtol=0, atol=0)
    outside = np.array([time[0] - 1e-6, time[-1] + 1e-6])
    assert np.isnan(odometry.at(outside)).all()
    assert not odometry.covers(outside).any()
    assert odometry.covers(time).all()


def test_odometry_is_validated_when_it_is_made() -> None:
    good = np.arange(3.0)
    for time, axial in [(good[::-1], good), (good, good[:2]), (good, np.array([0, np.nan, 1])), (good[:1], good[:1])]:
        with pytest.raises(InputError):
            Odometry(time, axial, np.zeros_like(axial))

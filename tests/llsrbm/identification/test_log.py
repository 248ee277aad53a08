"""Logs as files: what is read of them, and what is refused."""

import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.identification import read_log
from tests.llsrbm.identification.synthetic import GO2, PERIOD, as_csv, synthetic_log

LOG = synthetic_log(5.0)


def test_a_csv_is_read_as_it_is(tmp_path):
    read = read_log(as_csv(LOG, tmp_path / "a.csv"), GO2)
    assert read.name == "a.csv"
    assert read.period == pytest.approx(PERIOD)
    for name in ("q", "dq", "sent"):
        assert getattr(read, name) == pytest.approx(getattr(LOG, name), abs=1e-6)
    assert read.usable.all()
    assert read.gyro is None


def test_rows_that_are_missing_are_not_used(tmp_path):
    rows = np.delete(np.arange(len(LOG.q)), np.arange(1000, 1010))
    read = read_log(as_csv(LOG, tmp_path / "a.csv", rows=rows), GO2)
    assert len(read.q) == len(LOG.q)
    assert not read.usable[1001:1009].any()
    assert read.usable[:990].all()
    assert read.q[1500:] == pytest.approx(LOG.q[1500:], abs=1e-6)


def without(name):
    return lambda table: {key: values for key, values in table.items() if key != name}


def put(name, row, value):
    def change(table):
        values = table[name].copy()
        values[row] = value
        return {**table, name: values}

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (without("tau:FL_hip_joint"), "no column tau:FL_hip_joint; expected time, and q:NAME"),
        (without("time"), "no column time; expected"),
        (lambda table: {"time": table["time"]}, "no column q:FL_hip_joint and 35 more"),
        (lambda table: {**table, "q:knee": table["time"]}, "column q:knee: go2 has no such joint"),
        (put("dq:RR_calf_joint", 6, np.nan), "row 7: dq:RR_calf_joint is not finite"),
        (put("time", 10, 0.001), "row 11: time 0.001 after 0.018; expected increasing times"),
        (lambda t: {**t, "time": 10 * t["time"]}, "a row each 20 ms; expected one each 10 ms or"),
        (lambda t: {**t, "time": 0.1 * t["time"]}, "expected a log of 2 s or more"),
    ],
)
def test_bad_tables_are_refused_in_one_line(change, message, tmp_path):
    path = as_csv(LOG, tmp_path / "bad.csv", change)
    with pytest.raises(InputError) as raised:
        read_log(path, GO2)
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.txt", "1", "expected a log that ends in .csv or .mcap"),
        ("a.csv", "", "an empty file; expected a log in CSV"),
        ("a.mcap", "not one", "cannot be read"),
    ],
)
def test_other_files_are_refused(name, content, message, tmp_path):
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(InputError, match=message):
        read_log(path, GO2)

import threading
import time
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from llsrbm.errors import Cancelled
from llsrbm.ocp import progress
from llsrbm.ocp.progress import IterationTable, attended, printed_into, when_idle
from tests.llsrbm.processes import printed

FATROP = """
iter    objective   inf_pr   inf_du lg(mu)    ||d||   lg(rg)   alpha_du   alpha_pr ls
   0  1.27405799e+01 9.29e-01 7.04e-01   -2.0 0.00e+00      -  0.00e+00   0.00e+00x  1
   1  1.21490933e+01 5.69e-01 1.52e+00   -2.0 0.00e+00      -  6.15e-01   3.87e-01h  1
 117 -1.03713929e+01 4.29e-06 3.64e-08   -5.0 1.20e-01   -3.2  1.00e+00   1.00e+00h  1
operation                               time (s)   share
fatrop                                  0.302172   39.6%
total                                   0.763381
"""
ROWS = [(0, 0.929), (1, 0.569), (117, 4.29e-06)]


@given(st.lists(st.integers(0, len(FATROP)), max_size=40))
def test_rows_are_read_wherever_the_pieces_end(cuts):
    table, seen = IterationTable(), []
    places = [0, *sorted(cuts), len(FATROP)]
    for start, end in pairwise(places):
        table.read(FATROP[start:end])
        if table.last is not None and table.last not in seen:
            seen.append(table.last)
    assert seen == [row for row in ROWS if row in seen]  # pieces may hold several rows
    assert table.last == ROWS[-1]


def test_only_this_threads_prints_are_taken(capsys):
    taken = []
    other = threading.Thread(target=print, args=("of another thread",))
    with printed_into(taken.append):
        print("mine")
        other.start()
        other.join()
    print("after")
    assert "".join(taken) == "mine\n"
    assert capsys.readouterr().out == "of another thread\nafter\n"


def test_results_and_errors_of_a_solve_come_through():
    for report, cancelled in ((None, None), (lambda n, r: None, None), (None, lambda: False)):
        assert attended(lambda: 7, lambda: None, report, cancelled) == 7
        with pytest.raises(ZeroDivisionError):
            attended(lambda: 1 / 0, lambda: None, report, cancelled)


def test_reports_come_from_the_callers_thread_and_not_too_often(monkeypatch):
    monkeypatch.setattr(progress, "POLL_INTERVAL", 0.005)
    monkeypatch.setattr(progress, "REPORT_INTERVAL", 0.05)
    count, reported, enough = iter(range(10**6)), [], threading.Event()

    def report(iteration, residual):
        reported.append((time.monotonic(), threading.get_ident()))
        if len(reported) == 3:
            enough.set()

    attended(lambda: enough.wait(30), lambda: (next(count), 0.1), report, None)
    assert enough.is_set()
    assert all(b - a > 0.9 * 0.05 for (a, _), (b, _) in pairwise(reported))
    assert {who for _, who in reported} == {threading.get_ident()}


@pytest.fixture
def abandoned():
    """A solve that was cancelled and goes on until the event is set."""
    release = threading.Event()
    with pytest.raises(Cancelled):
        attended(lambda: release.wait(30), lambda: None, None, lambda: True)
    assert not release.is_set()  # the caller did not wait
    yield release
    release.set()


def test_the_solve_after_an_abandoned_one_waits_for_it(abandoned):
    threading.Timer(0.1, abandoned.set).start()
    assert attended(abandoned.is_set, lambda: None, None, None)


def test_when_idle_waits_for_an_abandoned_solve(abandoned):
    with pytest.raises(Cancelled):
        when_idle(lambda: True)
    threading.Timer(0.1, abandoned.set).start()
    when_idle()
    assert abandoned.is_set()
    when_idle(lambda: True)  # nothing to wait for


def test_a_solve_that_was_cancelled_before_it_began_never_does(abandoned):
    begun = []
    with pytest.raises(Cancelled):
        attended(lambda: begun.append(1), lambda: None, None, lambda: True)
    abandoned.set()
    attended(lambda: None, lambda: None, None, None)
    when_idle()
    assert not begun


# Its cost falls for ever, a line of the table at a time; no patch ends it.
LEAVING = """
import casadi as ca
from llsrbm.errors import Cancelled
from llsrbm.ocp.progress import attended, printed_into
x = ca.SX.sym("x")
options = {"print_time": False, "fatrop": {"max_iter": 10**8, "tolerance": 1e-300}}
solver = ca.nlpsol("solver", "fatrop", {"x": x, "f": x}, options)
printed = []
def solve():
    with printed_into(printed.append):
        solver(x0=0.0)
try:
    attended(solve, lambda: None, None, lambda: len(printed) > 100)
except Cancelled:
    print("leaving")
"""


def test_the_process_ends_although_a_cancelled_solve_runs():
    assert printed(LEAVING) == "leaving\n"

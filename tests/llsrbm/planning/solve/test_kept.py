"""`kept`: what is not used for longest makes room for the others."""

from dataclasses import dataclass

import pytest

from llsrbm.planning.solve import kept as module
from llsrbm.planning.solve.kept import MOST, kept


@dataclass
class FakeSolver:
    megabytes: float


class FakeHolder:
    def __init__(self, megabytes: float) -> None:
        self.solvers = (FakeSolver(megabytes),)


@pytest.fixture(autouse=True)
def _nothing_is_kept(monkeypatch):
    monkeypatch.setattr(module, "_holders", module.OrderedDict())


def test_what_was_not_used_for_longest_goes():
    old, other = (kept(k, lambda: FakeHolder(0.4 * MOST)) for k in ("old", "other"))
    assert kept("old", lambda: FakeHolder(0.0)) is old
    kept("new", lambda: FakeHolder(0.4 * MOST))
    assert kept("old", lambda: FakeHolder(0.0)) is old
    assert kept("other", lambda: FakeHolder(0.0)) is not other


def test_a_solver_that_has_grown_since_makes_the_others_go():
    """Solvers hold more with each set of options that they are used with."""
    kept("old", lambda: FakeHolder(0.4 * MOST))
    grows = kept("grows", lambda: FakeHolder(0.1 * MOST))
    grows.solvers[0].megabytes = 0.8 * MOST
    kept("grows", lambda: FakeHolder(0.0))
    assert module.size() == pytest.approx(0.8 * MOST)

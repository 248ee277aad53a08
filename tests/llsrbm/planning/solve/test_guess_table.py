"""Plans that begin from solutions nearby: the same plans, sooner; and where there are none.

The table is one of sixteen jumps of one robot, planned here.
"""

import logging
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.models import make_model
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.answer.planner import BY_NEARER, FOLLOWED, NEARBY, planner_of
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.solve import guess_table
from llsrbm.planning.solve.guess_table import (
    TURNING_NEAR,
    Guesses,
    make_table,
    read_table,
    write_table,
)
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_drives
from tests.llsrbm.planning.solved import FLIPS, solved

ROBOT = "go2"
COLD = "from the analytic guess"
UNSEEN = Jump(robot=ROBOT, twist=0.3, forward=0.2, lateral=0.03)
BACK = Jump(robot=ROBOT, **FLIPS["flip"])
TWISTS = (-45.0, -15.0, 15.0, 45.0)
JUMPS = [  # each beside the one before
    Jump(robot=ROBOT, twist=np.radians(twist), forward=forward, lateral=lateral, height=height)
    for turn, forward, lateral, height in (
        (1, 0.1, 0.0, 0.0),
        (-1, 0.1, 0.1, 0.05),
        (1, 0.3, 0.1, 0.0),
        (-1, 0.3, 0.0, 0.05),
    )
    for twist in TWISTS[::turn]
]


def planner():
    return planner_of(UNSEEN)


def formulation():
    return planner().formulation


def task(**asked):
    return make_task(replace(UNSEEN, **asked), load_robot(ROBOT))


@pytest.fixture(scope="module")
def solutions():
    """Requests, solutions and costs, each planned from the one before."""
    found, plan = [], None
    for jump in JUMPS:
        plan = planner().plan(jump, near=plan, explains=False)
        found.append((jump, plan.solution, plan.report.cost))
    return found


@pytest.fixture(scope="module")
def written(solutions, tmp_path_factory):
    path = tmp_path_factory.mktemp("guesses") / f"{ROBOT}.npz"
    write_table(path, make_table(solutions, formulation()), formulation())
    return path


@pytest.fixture
def table(written):
    return read_table(written, formulation())


@pytest.fixture
def in_force(tmp_path, monkeypatch):
    """A function that has planners find a table's file, or a copy of it; the copy's path."""

    def put(path, own=None):
        copy = tmp_path / f"copy of {path.name}"
        copy.write_bytes(path.read_bytes())
        monkeypatch.setattr(guess_table, "table_path", lambda formulation: copy)
        own = own or planner()
        monkeypatch.setitem(own.__dict__, "guesses", Guesses(own.formulation))
        return copy

    return put


@pytest.fixture
def shipped(in_force, written):
    """The table that planners find."""
    return in_force(written)


@pytest.fixture
def refused(caplog, monkeypatch):
    """The warning that goes with a table that is not used."""

    def of(other=None):
        caplog.clear()
        monkeypatch.setattr(guess_table, "_refused", set())
        for _ in range(2):
            assert Guesses(other or formulation()).start(task()) is None
        assert len(caplog.records) <= 1  # said once
        return caplog.text

    caplog.set_level(logging.WARNING)
    return of


# ---- plans


def test_the_plan_is_the_one_without_and_comes_sooner(shipped):
    cold, warm = (planner().plan(UNSEEN, guesses=guesses) for guesses in (False, True))
    assert (cold.report.guess, warm.report.guess) == (COLD, NEARBY)
    assert warm.solved
    assert warm.report.attempts == 1
    assert warm.report.iterations < cold.report.iterations
    assert warm.report.cost == pytest.approx(cold.report.cost, rel=1e-3)
    assert np.abs(warm.com - cold.com).max() < 5e-3
    near = planner().plan(replace(UNSEEN, twist=0.32), near=warm, guesses=True)
    assert near.report.guess == FOLLOWED


def test_flips_begin_from_the_flip_beside_them_alone(table, monkeypatch):
    """Between whole turns nothing is interpolated."""
    kind = {name: getattr(BACK, name) for name in ("type", "pitch")}
    guesses, robot = Guesses(formulation()), load_robot(ROBOT)
    monkeypatch.setitem(guesses.__dict__, "_table", replace(table, kind=kind))
    first = replace(BACK, **table.request(5))

    def start(**changes):
        return guesses.start(make_task(replace(first, **changes), robot))

    away = TURNING_NEAR * table.scale[1]  # forward
    jump, begun = start(forward=first.forward - 0.9 * away)
    assert jump == first
    np.testing.assert_array_equal(begun.variables, table.variables[5])
    assert start(forward=first.forward - 1.1 * away) is None
    assert start(pitch=2 * np.pi) is None


@pytest.mark.nightly
def test_a_flip_from_a_flip_takes_one_solve(in_force, tmp_path):
    """With what the whole body says of the one that is followed."""
    first, path = solved("llsrbm-plus", "flip", ROBOT), tmp_path / "flip.npz"
    form, plan = first.planner.formulation, first.plan
    write_table(path, make_table([(BACK, plan.solution, plan.report.cost)], form), form)
    in_force(path, first.planner)
    beside = first.planner.plan(replace(BACK, forward=0.02), guesses=True)
    assert (beside.report.guess, beside.report.attempts) == (NEARBY, 1)


def test_other_limits_and_weights_begin_elsewhere(shipped):
    usual = task()
    assert planner().guesses.start(usual) is not None
    for tuning in (Tuning(limits={"friction": 0.4}), Tuning(weights={"force": 1.0})):
        assert planner().guesses.start(replace(usual, tuning=tuning)) is None


def test_where_it_leads_nowhere_nothing_is_lost(monkeypatch):
    """The elastic problem follows, in which all of it is found."""

    def far(self, task):
        sizes = formulation().solver.sizes
        return task.jump, Iterate(np.full(sizes[0], 1e3), np.zeros(sizes[1]))

    monkeypatch.setattr(Guesses, "start", far)
    said = []
    plan = planner().plan(UNSEEN, guesses=True, progress=said.append)
    assert (plan.report.guess, plan.report.attempts) == (BY_NEARER, 2)
    assert said[0].text == f"attempt 1: {NEARBY}"
    np.testing.assert_allclose(plan.com, planner().plan(UNSEEN).com, atol=5e-3)


# ---- between solutions


def test_attitudes_have_no_jumps_of_sign(table):
    """From the same start to where half the twist is, so that neighbours can be mixed."""
    layout = planner().layout
    places = [layout.variables(k)["quat"] for k in range(1, layout.knots)]
    quats = np.stack([table.variables[:, place] for place in places], axis=1)
    assert quats[:, 0, 0].min() > 0.99
    assert np.einsum("nkq,nkq->nk", quats[:, 1:], quats[:, :-1]).min() > 0.98
    half = table.requests[:, 0] / 2
    end = np.stack([np.cos(half), np.zeros_like(half), np.zeros_like(half), np.sin(half)], axis=1)
    assert np.sum(quats[:, -1] * end, axis=1).min() > 0.99


@pytest.mark.parametrize("degrees", [-45, -30, 0, 20, 45])
def test_a_guess_turns_the_way_it_is_asked_to(table, degrees):
    jump = replace(UNSEEN, twist=np.radians(degrees))
    w, layout = table.guess(jump, formulation()).variables, planner().layout
    quats = np.array([w[layout.variables(k)["quat"]] for k in range(1, layout.knots)])
    np.testing.assert_allclose(np.linalg.norm(quats, axis=1), 1.0, atol=1e-12)
    turn = np.unwrap(Rotation.from_quat(quats, scalar_first=True).as_euler("ZYX")[:, 0])
    assert np.degrees(turn[-1]) == pytest.approx(degrees, abs=6)


# ---- files


def test_a_table_is_made_of_solutions(solutions, table):
    """With 16 bits of some metres, and multipliers of bounds alone."""
    _, solution, cost = solutions[3]
    kept = table.solution(3)
    assert table.costs[3] == cost
    np.testing.assert_allclose(kept.variables, solution.variables, atol=5e-3)
    problem = formulation().problem(task())
    bounds = problem.lower < problem.upper
    assert not kept.multipliers[~bounds].any()
    np.testing.assert_allclose(
        kept.multipliers[bounds], solution.multipliers[bounds], rtol=0.05, atol=2e-4
    )


def test_what_was_written_is_read(table, tmp_path):
    write_table(tmp_path / "again.npz", table, formulation())
    again = read_table(tmp_path / "again.npz", formulation())
    for name in ("variables", "multipliers", "requests"):
        np.testing.assert_array_equal(getattr(again, name), getattr(table, name))


def with_file(tmp_path, pattern, new):
    """The planner's formulation, of a robot whose file has another text in one place."""
    text, count = re.subn(f"(?m){pattern}", new, load_robot(ROBOT).path.read_text("utf-8"))
    assert count == 1
    path = tmp_path / "mine.toml"
    path.write_text(text, "utf-8")
    return replace(formulation(), robot=load_robot(str(path)))


NUMBER = r"[\d.]+"
DRIVES = [rf"^{name} = (\[.*\]|{NUMBER})" for name in ("armature", "damping")]


@pytest.mark.parametrize("pattern", [f"^clearance = {NUMBER}", *DRIVES])
def test_it_is_for_the_robots_numbers(shipped, tmp_path, refused, pattern):
    """A jump that was planned without rotors is none of a robot that has some."""
    mine = with_file(tmp_path, pattern, f"{pattern[1:].split()[0]} = 0.0")
    assert "ignored: built for other robot parameters" in refused(mine)


def test_it_is_not_for_the_bytes_of_its_file(shipped, tmp_path):
    commented = with_file(tmp_path, f"^(clearance = {NUMBER})", r"\g<1>  # over grass")
    assert Guesses(commented).start(task()) is not None


def test_it_is_not_meant_for_other_drives_models_layouts(shipped, refused):
    form = formulation()
    for other in (
        replace(form, robot=with_drives(form.robot, 1.2, 1.0)),
        replace(form, layout=replace(form.layout, intervals=(15, 15, 15))),
        replace(form, model=make_model("srbm", form.robot)),
    ):
        assert refused(other) == ""


def test_it_is_for_one_problem(shipped, refused, table):
    """A constraint or a cost that is another one now."""
    write_table(shipped, replace(table, costs=table.costs * 1.1), formulation())
    assert "of another problem" in refused()
    variables = table.variables.copy()
    variables[0] += 0.1
    write_table(shipped, replace(table, variables=variables), formulation())
    assert "of another problem" in refused()


@pytest.mark.parametrize("damage", ["cut", "text", "few"])
def test_a_damaged_table_is_none(shipped, refused, table, solutions, damage):
    if damage == "cut":
        shipped.write_bytes(shipped.read_bytes()[:-5000])
    elif damage == "text":
        shipped.write_text("no table")
    else:
        write_table(shipped, make_table(solutions[:3], formulation()), formulation())
    assert "damaged" in refused()


def test_where_there_is_no_table_nothing_is_said(shipped, refused):
    shipped.unlink()
    assert refused() == ""

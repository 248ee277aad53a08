"""Plans that begin from solutions nearby: the same plans, sooner; and where there are none."""

import logging
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.solve import guess_table
from llsrbm.planning.solve.guess_table import (
    REQUEST,
    Guesses,
    make_table,
    read_table,
    table_path,
    write_table,
)
from llsrbm.planning.solve.planner import BY_NEARER, FOLLOWED, NEARBY, planner_of
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.drives import with_drives

COLD = "from the analytic guess"
UNSEEN = {
    "anymal": [{"twist": 1.3}, {"twist": -1.1, "forward": 0.25, "lateral": -0.1, "height": 0.1}],
    "go2": [{"forward": 0.33}],
    "slider": [{"forward": 0.15}],
}
LARGEST = 2 * 10**6  # bytes
LARGE = [pytest.param(robot, marks=pytest.mark.nightly) for robot in ("g1", "g1_legs")]
TABLED = ("anymal", *LARGE, "go2", "slider")


def planner(robot="anymal"):
    return planner_of(Jump(robot=robot))


def table(robot="anymal"):
    formulation = planner(robot).formulation
    return read_table(table_path(formulation), formulation)


def task(**asked):
    jump = Jump(**asked)
    return make_task(jump, load_robot(jump.robot))


# ---- the tables that ship


@pytest.mark.parametrize("robot", TABLED)
def test_tables_that_ship_are_in_force(robot):
    """Where it is refused: python -m benchmarks.guess_tables."""
    assert table_path(planner(robot).formulation).stat().st_size <= LARGEST
    assert len(table(robot).requests) > 100


@pytest.mark.parametrize(
    ("robot", "asked"), [(robot, asked) for robot, several in UNSEEN.items() for asked in several]
)
def test_the_plan_is_the_one_without_and_comes_sooner(robot, asked):
    jump = Jump(robot=robot, **asked)
    assert (
        not (np.abs(table(robot).requests - [getattr(jump, n) for n in REQUEST]) < 1e-3)
        .all(axis=1)
        .any()
    )
    cold, warm = (llsrbm.plan(jump, guesses=guesses) for guesses in (False, True))
    assert (cold.report.guess, warm.report.guess) == (COLD, NEARBY)
    assert warm.solved
    assert warm.report.attempts == 1
    assert warm.report.iterations < cold.report.iterations
    assert warm.report.cost <= 1.001 * cold.report.cost
    if robot != "slider":  # which comes to another optimum, that costs less
        assert warm.report.cost == pytest.approx(cold.report.cost, rel=1e-3)
        assert np.abs(warm.com - cold.com).max() < 5e-3


BACK = Jump(robot="go2", type="flip", pitch=-2 * np.pi)


def test_flips_begin_from_flips():
    """The nearest one, with what the whole body says of it: one solve, where a guess takes two."""
    own = planner_of(BACK)
    plan = own.plan(BACK, guesses=True)
    assert (plan.report.guess, plan.report.attempts) == (NEARBY, 1)
    again = own.plan(replace(BACK, forward=0.02), near=plan)
    assert (again.report.guess, again.report.attempts) == (FOLLOWED, 1)


def test_a_table_of_flips_is_for_no_other_turn():
    own = planner_of(BACK)
    assert own.guesses.start(make_task(BACK, own.robot)) is not None
    front = make_task(replace(BACK, pitch=2 * np.pi), own.robot)
    assert own.guesses.start(front) is None


def test_the_planner_itself_depends_on_the_request_alone():
    """Sweeps rely on it."""
    assert planner().plan(Jump(twist=2.0)).report.guess == COLD


def test_a_near_plan_comes_first():
    near = llsrbm.plan(Jump(twist=1.0))
    assert llsrbm.plan(Jump(twist=1.02), near=near).report.guess == FOLLOWED


@pytest.mark.parametrize("robot", TABLED)
def test_attitudes_have_no_jumps_of_sign(robot):
    """From the same start to where half the twist is, so that neighbours can be mixed."""
    of, layout = table(robot), planner(robot).layout
    places = [layout.variables(k)["quat"] for k in range(1, layout.knots)]
    quats = np.stack([of.variables[:, place] for place in places], axis=1)
    assert quats[:, 0, 0].min() > 0.99
    assert np.einsum("nkq,nkq->nk", quats[:, 1:], quats[:, :-1]).min() > 0.98
    half = of.requests[:, 0] / 2
    end = np.stack([np.cos(half), np.zeros_like(half), np.zeros_like(half), np.sin(half)], axis=1)
    assert np.sum(quats[:, -1] * end, axis=1).min() > 0.99


@pytest.mark.parametrize("degrees", [-180, -179, 0, 179, 180])
def test_a_guess_turns_the_way_it_is_asked_to(degrees):
    jump = Jump(twist=np.radians(degrees))
    formulation = planner().formulation
    w = table().guess(jump, formulation).variables
    quats = np.array(
        [w[formulation.layout.variables(k)["quat"]] for k in range(1, formulation.layout.knots)]
    )
    np.testing.assert_allclose(np.linalg.norm(quats, axis=1), 1.0, atol=1e-12)
    turn = np.unwrap(Rotation.from_quat(quats, scalar_first=True).as_euler("ZYX")[:, 0])
    # The largest twists are in no table: they cannot be planned.
    assert np.degrees(turn[-1]) == pytest.approx(degrees, abs=8)


# ---- between solutions


# ---- files


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A copy of ANYmal's table that planners find, and one that reads it anew."""
    path = tmp_path / "anymal.npz"
    path.write_bytes(table_path(planner().formulation).read_bytes())
    monkeypatch.setattr(guess_table, "table_path", lambda formulation: path)
    return path


@pytest.fixture
def refused(caplog, monkeypatch):
    """The warning that goes with a table that is not used."""

    def of(formulation=None, **asked):
        caplog.clear()
        monkeypatch.setattr(guess_table, "_refused", set())
        for _ in range(2):
            assert Guesses(formulation or planner().formulation).start(task(**asked)) is None
        assert len(caplog.records) <= 1  # said once
        return caplog.text

    caplog.set_level(logging.WARNING)
    return of


def test_what_was_written_is_read(tmp_path):
    formulation, of = planner().formulation, table()
    write_table(tmp_path / "again.npz", of, formulation)
    again = read_table(tmp_path / "again.npz", formulation)
    np.testing.assert_array_equal(again.variables, of.variables)
    np.testing.assert_array_equal(again.multipliers, of.multipliers)
    np.testing.assert_array_equal(again.requests, of.requests)


def test_a_table_is_made_of_solutions(tmp_path):
    own, jumps = planner(), [Jump(twist=0.1 * k) for k in range(16)]
    plan = own.plan(jumps[0])
    solved = [(jump, plan.solution, plan.report.cost) for jump in jumps]
    write_table(tmp_path / "one.npz", make_table(solved, own.formulation), own.formulation)
    of = read_table(tmp_path / "one.npz", own.formulation)
    # 16 bits of some metres
    kept = of.solution(3)
    np.testing.assert_allclose(kept.variables, plan.solution.variables, atol=5e-3)
    problem = own.formulation.problem(task())
    bounds = problem.lower < problem.upper
    assert not kept.multipliers[~bounds].any()
    np.testing.assert_allclose(
        kept.multipliers[bounds], plan.solution.multipliers[bounds], rtol=0.05, atol=2e-4
    )


def with_file(tmp_path, old, new):
    """The planner's formulation, of a robot whose file has another text in one place."""
    text = load_robot("anymal").path.read_text("utf-8")
    assert old in text
    path = tmp_path / "mine.toml"
    path.write_text(text.replace(old, new), "utf-8")
    return replace(planner().formulation, robot=load_robot(str(path)))


def test_it_is_for_the_robots_numbers(elsewhere, tmp_path, refused):
    """Not for the bytes of its file."""
    mine = with_file(tmp_path, "friction = 0.5", "friction = 0.45")
    assert "the robot's numbers were others when it was made" in refused(mine)
    commented = with_file(tmp_path, "friction = 0.5", "friction = 0.50  # dry concrete")
    assert Guesses(commented).start(task()) is not None


def test_it_is_not_meant_for_other_drives_models_layouts(elsewhere, refused):
    stronger = with_drives(load_robot("anymal"), 1.2, 1.0)
    layout = replace(planner().layout, intervals=(15, 15, 15))
    for formulation in (
        replace(planner().formulation, robot=stronger),
        replace(planner().formulation, layout=layout),
        planner_of(Jump(model="srbm")).formulation,
    ):
        assert refused(formulation) == ""


def test_it_is_for_one_problem(elsewhere, refused):
    """A constraint or a cost that is another one now."""
    formulation, of = planner().formulation, table()
    write_table(elsewhere, replace(of, costs=of.costs * 1.1), formulation)
    assert "of another problem" in refused()
    variables = of.variables.copy()
    variables[0] += 0.1
    write_table(elsewhere, replace(of, variables=variables), formulation)
    assert "of another problem" in refused()


@pytest.mark.parametrize("damage", ["cut", "text", "gone"])
def test_a_damaged_table_is_none(elsewhere, refused, damage):
    if damage == "cut":
        elsewhere.write_bytes(elsewhere.read_bytes()[:-5000])
    elif damage == "text":
        elsewhere.write_text("no table")
    else:
        elsewhere.unlink()
    assert ("damaged" in refused()) == (damage != "gone")


def test_other_limits_and_weights_begin_elsewhere():
    guesses = Guesses(planner().formulation)
    usual = task(twist=0.3)
    assert guesses.start(usual) is not None
    assert guesses.start(replace(usual, tuning=Tuning(limits={"friction": 0.4}))) is None
    assert guesses.start(replace(usual, tuning=Tuning(weights={"force": 1.0}))) is None
    plan = llsrbm.plan(Jump(forward=0.2), limits={"friction": 0.45})
    assert plan.report.guess == COLD


def test_where_it_leads_nowhere_nothing_is_lost(monkeypatch):
    """The elastic problem follows, in which all of it is found."""

    def far(self, task):
        sizes = planner().formulation.solver.sizes
        return task.jump, Iterate(np.full(sizes[0], 1e3), np.zeros(sizes[1]))

    monkeypatch.setattr(Guesses, "start", far)
    jump, said = Jump(forward=0.2), []
    plan = llsrbm.plan(jump, progress=said.append)
    assert (plan.report.guess, plan.report.attempts) == (BY_NEARER, 2)
    assert said[0].text == f"attempt 1: {NEARBY}"
    np.testing.assert_allclose(plan.com, llsrbm.plan(jump, guesses=False).com, atol=5e-3)

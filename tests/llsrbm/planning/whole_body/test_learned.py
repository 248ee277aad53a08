"""Tables of solved jumps: what they give, and which are ignored."""

import logging
import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from llsrbm import certified_plan, drafting
from llsrbm.analysis.summaries import plan_summary
from llsrbm.certificate import certified
from llsrbm.ocp import fatrop_patches
from llsrbm.ocp.horizon import Iterate
from llsrbm.ocp.solvers import Fatrop
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.whole_body import learned_file
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.learned import NEIGHBOURS, Learned, Refused, Solved
from llsrbm.planning.whole_body.refine import planned, refined
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_drives

ROBOT = "go2"
GRID = Grid((((0, 1, 2, 3), 8), ((), 12), ((0, 1, 2, 3), 8)))
SLOPES = np.random.default_rng(1).normal(size=(4, 7))


def values(jump):
    """Numbers that are linear in a request."""
    return np.array([getattr(jump, name) for name in COMPONENTS]) @ SLOPES + np.arange(7)


@pytest.fixture
def table():
    rng, robot = np.random.default_rng(2), load_robot(ROBOT)
    ranges = np.array([getattr(robot.file.task, name) for name in COMPONENTS])
    jumps = [
        Jump(robot=ROBOT, **dict(zip(COMPONENTS, map(float, rng.uniform(*ranges.T)), strict=True)))
        for _ in range(3 * NEIGHBOURS)
    ]
    solved = [Solved(j, Iterate(values(j), values(j)[:3]), 0.4, 0.8) for j in jumps]
    refused = [Refused(replace(j, twist=-j.twist), "friction") for j in jumps[:3]]
    return Learned.of(solved, refused, robot)


def test_what_is_linear_in_the_request_is_met(table):
    jump = Jump(robot=ROBOT, twist=0.7, forward=0.1, lateral=-0.05, height=0.04)
    found = table.guess(jump)
    np.testing.assert_allclose(found.variables, values(jump), atol=5e-3)
    np.testing.assert_allclose(found.multipliers, values(jump)[:3], atol=5e-3)


def test_a_file_has_the_table(table, tmp_path):
    robot, path = load_robot(ROBOT), tmp_path / "go2.npz"
    learned_file.write(path, table, robot, GRID)
    again = learned_file.read(path, robot, GRID)
    largest = np.abs(table.variables).max(axis=0)
    assert (np.abs(again.variables - table.variables) <= 2.0**-11 * largest).all()
    np.testing.assert_allclose(again.multipliers, table.multipliers, rtol=2.0**-4)
    for one, other in zip(again.solved(robot), table.solved(robot), strict=True):
        assert (one.jump, one.flight, one.torque_share) == (other.jump, 0.4, 0.8)
    light = learned_file.read_outcomes(path, robot, GRID)
    assert light.refusals(robot) == table.outcomes.refusals(robot)
    assert {each.stopped_by for each in light.refusals(robot)} == {"friction"}


def test_of_other_numbers_it_is_ignored_with_a_warning(table, tmp_path, caplog):
    robot, path = load_robot(ROBOT), tmp_path / "go2.npz"
    learned_file.write(path, table, robot, GRID)
    stronger = with_drives(robot, torque=1.2)
    with caplog.at_level(logging.WARNING):
        assert learned_file.read(path, stronger, GRID) is None
    assert "learned with other numbers of the robot" in caplog.text


def test_of_another_type_of_jump_it_is_left_alone(table, tmp_path, caplog):
    robot, path = load_robot(ROBOT), tmp_path / "go2.npz"
    learned_file.write(path, table, robot, GRID)
    with caplog.at_level(logging.WARNING):
        assert learned_file.read(path, robot, Grid((GRID.phases[0], *GRID.phases))) is None
        assert learned_file.read(tmp_path / "none.npz", robot, GRID) is None
    assert caplog.text == ""


@pytest.mark.parametrize("share", [0.0, 0.99])
def test_a_damaged_one_is_ignored_with_a_warning(share, table, tmp_path, caplog):
    robot, path = load_robot(ROBOT), tmp_path / f"{share}.npz"
    learned_file.write(path, table, robot, GRID)
    path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])
    with caplog.at_level(logging.WARNING):
        assert learned_file.read(path, robot, GRID) is None
    assert "it is damaged" in caplog.text


def test_jumps_from_a_table_are_those_from_drafts_in_fewer_iterations():
    draft = llsrbm.plan(Jump(robot=ROBOT, twist=0.5, forward=0.12, lateral=0.04), draft=True)
    own, nearby = refined(draft, learned=False), refined(draft)
    assert nearby.refined
    # Half of them until drafts are kept near to, and feet come down more steeply than the table's.
    assert nearby.refinement.iterations <= own.refinement.iterations / 2
    assert nearby.refinement.cost < 1.02 * own.refinement.cost
    assert llsrbm.certify(nearby).holds


def test_a_table_is_of_the_default_model_and_type(table, monkeypatch):
    monkeypatch.setattr(learned_file, "_table", lambda robot, grid: table)
    plain = Jump(robot=ROBOT, twist=0.3)

    def found(jump=plain, **tuning):
        return learned_file.table_for(jump, Tuning(**tuning), GRID)

    assert found() is table
    for other in ({"model": "srbm"}, {"type": "one-foot-first"}):
        assert found(replace(plain, **other)) is None
    # Others begin from the same jump without.
    for other in ({"stones": {"FL": (0.03, 0.0)}}, {"payload": (1.0, 0, 0, 0)}):
        assert found(replace(plain, **other)) is table
    assert found(limits={"torque_share": 0.8, "flight_min": 0.3}) is table
    # Only drafts know these.
    assert found(limits={"foot_speed": 3.0}) is None
    assert found(weights={"angular_momentum": 2.0}) is None


def test_one_of_another_problem_is_not_begun_from(table, monkeypatch):
    monkeypatch.setattr(learned_file, "_table", lambda robot, grid: table)
    task = make_task(Jump(robot=ROBOT, twist=0.3), load_robot(ROBOT))
    assert planned(task, (16, 16, 16)) is None


def test_without_a_draft_it_is_the_plan_that_it_is_with_one():
    jump = Jump(robot=ROBOT, twist=0.4, forward=0.1)
    robot, draft = load_robot(ROBOT), llsrbm.plan(jump, draft=True)
    with_one, without = refined(draft), planned(make_task(jump, robot), (16, 16, 16))
    for quantity in ("time", "base_position", "base_quat", "joint_torque", "foot_in_hip", "com"):
        np.testing.assert_allclose(getattr(without, quantity), getattr(with_one, quantity))
    assert without.limits == draft.limits
    assert without.base_mass == pytest.approx(draft.base_mass)
    np.testing.assert_allclose(without.leg_mass, draft.leg_mass)
    # At the ends both stand as the request says, but for the base, which has a little room.
    np.testing.assert_allclose(without.foot_in_hip[-1], draft.foot_in_hip[-1], atol=0.02)


NEAR_THE_TABLE = Jump(robot=ROBOT, twist=0.4, forward=0.1)


@cache
def from_the_table():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drafting, "planner_of", lambda *_, **__: pytest.fail("a draft was begun"))
        return llsrbm.plan(NEAR_THE_TABLE)


def test_no_draft_is_made_where_the_table_leads_to_a_plan_that_holds():
    plan = from_the_table()
    assert plan.certified
    assert (plan.report.attempts, plan.report.iterations) == (0, 0)
    # Its figures are then the whole body's, not zeros.
    summary = plan_summary(plan)
    for name in ("iterations", "solve_time_s", "cost"):
        assert summary[name] == getattr(plan.refinement, name) > 0


def test_a_draft_is_made_where_the_certificate_does_not_hold(monkeypatch):
    nearby = from_the_table()
    held = iter([False])
    monkeypatch.setattr(
        certified_plan,
        "certified",
        lambda plan, robot: plan if not next(held, True) else certified(plan, robot),
    )
    monkeypatch.setattr(certified_plan.CertifiedPlanner, "nearest", lambda *_, **__: None)
    plan = llsrbm.plan(NEAR_THE_TABLE)
    assert plan.certified
    assert plan.report.attempts > 0
    assert plan.refinement.iterations > 2 * nearby.refinement.iterations  # not from the table again


def test_what_had_no_draft_starts_no_draft():
    jump = replace(NEAR_THE_TABLE, twist=0.42)
    draft = llsrbm.plan(jump, near=from_the_table(), draft=True)
    assert draft.solved
    assert draft.report.guess == "from the analytic guess"


def test_without_patches_only_near_starts_are_begun_from(monkeypatch):
    """Of this one, which misses by 0.75, a solver that never gives up did not come back."""
    far = Jump(
        robot="slider",
        twist=-0.5396402974272445,
        forward=0.2962278526402172,
        lateral=0.11704523110979032,
        height=0.29620445808865703,
    )
    begun = []

    def follow(solver, problem, start, max_miss, acceptable):
        begun.append((solver.miss(problem, start.variables), max_miss))
        raise StopFollowing

    monkeypatch.setattr(Fatrop, "follow", follow)
    for loaded in (False, True):
        monkeypatch.setattr(fatrop_patches, "is_loaded", lambda loaded=loaded: loaded)
        with pytest.raises(StopFollowing):
            planned(make_task(far, load_robot("slider")), (16, 16, 16))
    (miss, sure), (_, bold) = begun
    assert sure < miss < bold


class StopFollowing(Exception):
    """Ends a solve as it begins."""


@pytest.mark.parametrize("robot", [pytest.param("anymal", marks=pytest.mark.nightly), "go2"])
def test_a_plan_from_a_table_ends_as_it_begins_turned_and_moved_by_all_that_was_asked(robot):
    """Between the table's jumps of 120 degrees on ANYmal's spot ends were turned by 109."""
    jump = llsrbm.Jump(robot=robot, twist=math.radians(120), lateral=0.1)
    plan = llsrbm.plan(jump)
    assert plan.report.attempts == 0  # it has no draft
    turn = Rotation.from_euler("z", jump.twist)
    begins, ends = (Rotation.from_quat(plan.base_quat[k], scalar_first=True) for k in (0, -1))
    assert (ends * (turn * begins).inv()).magnitude() < 1e-3
    moved = turn.apply(plan.base_position[0]) + np.array([0.0, jump.lateral, 0.0])
    np.testing.assert_allclose(plan.base_position[-1], moved, atol=1e-3)

"""Landings that are moved: what rows say of an offset, and how far it gets."""

import math
from dataclasses import replace

import numpy as np
import pytest

from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.motion.robot import robot_of
from llsrbm.planning.problem.placement import make_task, retargeted
from llsrbm.planning.problem.shortfall import distance
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.solve.watch import Watch
from llsrbm.planning.whole_body import nearest, problem
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.problem import make_problem
from llsrbm.planning.whole_body.refine import Refiner
from llsrbm.planning.whole_body.sizes import Sizes
from llsrbm.planning.whole_body.unplanned import unplanned
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots import load_robot
from llsrbm.robots.payload import with_payload


def refiner(robot):
    task = make_task(Jump(robot=robot.name), robot)
    return Refiner(robot, Grid.at(task.schedule, layout_of(task.jump, robot).intervals))


def rows_of(refiner, task, wanted, offset):
    """Name -> what each row leaves to its bounds."""
    nearby = refiner.nearby(Jump(robot=task.robot.name, twist=0.5), task.tuning)
    start = refiner._beside(nearby, unplanned(task, task.robot, "fatrop"))
    start = replace(start, wanted=wanted, price=1.0)
    grid, sizes = refiner.grid, Sizes.of(task.robot, len(refiner.grid.phases))
    rows = RowBounds(task.robot, grid, sizes, start)
    numbers, variables, at = make_problem(rows), nearby.variables.copy(), 0
    for knot in grid.knots:
        end = at + sizes.states
        variables[end - len(COMPONENTS) : end] = offset
        at = end + sizes.controls(knot)
    values = np.array(refiner.solver.function("nlp_g")(variables, numbers.parameters)).ravel()
    found, at = {}, 0
    for name, _, _, low, high in rows:
        part = slice(at, at + len(low))
        at = part.stop
        both = values[part] - low, high - values[part]
        found.setdefault(name, []).append(np.concatenate(both))
    return {name: np.concatenate(each) for name, each in found.items()}


@pytest.mark.parametrize("name", ["go2", "slider"])
@pytest.mark.parametrize(
    "offset",
    [(0.0, 0.3, 0.05, -0.04, 0.0), (0.15, -0.4, -0.1, 0.02, 0.06), (-0.15, 0.2, 0.1, 0.0, -0.05)],
    ids=["level", "up", "down"],
)
def test_rows_with_an_offset_are_those_of_the_landing_that_is_moved(name, offset, monkeypatch):
    # One motion for both rolls alike, and a landing that turns takes what feet have rolled along.
    monkeypatch.setattr(problem, "rolled_by", lambda *_: 0.0)
    robot, height, offset = load_robot(name), offset[0], np.array(offset[1:])
    of = refiner(robot)
    here = make_task(Jump(robot=name, twist=0.5, forward=0.4, height=height), robot)
    values = [getattr(here.jump, c) + o for c, o in zip(COMPONENTS, offset, strict=True)]
    there = retargeted(here, replace(here.jump, **dict(zip(COMPONENTS, values, strict=True))))
    moved, placed = rows_of(of, here, offset, offset), rows_of(of, there, offset * 0.0, 0.0)
    assert moved.keys() == placed.keys()
    # Edges are taken to move and not to turn; what swinging feet clear has corners.
    for row in moved.keys() - {"offset", "apart", "start", "edge"}:
        within = 8e-3 if row == "clearance" else 1e-3
        assert moved[row] == pytest.approx(placed[row], abs=within), row


@pytest.mark.parametrize("name", [pytest.param("go2", marks=pytest.mark.nightly), "anymal"])
def test_a_landing_is_moved_as_far_as_the_robot_can(name):
    robot = load_robot(name)
    wanted = Jump(robot=name, twist=math.radians(175), forward=0.3, height=0.1)
    near = CertifiedPlanner().nearest(make_task(wanted, robot))
    assert near.plan.certified
    reached = near.plan.jump
    assert 0 < distance(make_task(wanted, robot), reached) < 0.25
    assert reached.twist < wanted.twist
    assert near.stop.demand.joint in robot.joint_names


def test_what_can_be_done_is_done_in_full():
    jump = Jump(robot="go2", twist=math.radians(100), forward=0.2)
    near = CertifiedPlanner().nearest(make_task(jump, load_robot("go2")), less=False)
    assert near.plan.jump == jump
    assert near.plan.certified


@pytest.mark.parametrize(
    ("payload", "limits"),
    [((3.0, 0.0, 0.0, 0.08), {}), ((), {"friction": 0.35}), ((), {"drive_strength": 0.8})],
)
def test_a_payload_and_other_limits_are_kept(payload, limits):
    wanted = Jump(robot="go2", twist=1.5, forward=0.2, payload=payload)
    task = make_task(wanted, with_payload(load_robot("go2"), payload), limits=limits)
    plan = CertifiedPlanner().from_table(task)
    assert plan.jump == wanted
    robot = robot_of(plan)
    assert robot.mass == pytest.approx(load_robot("go2").mass + sum(payload[:1]))
    assert robot.drive_strength == limits.get("drive_strength", 1.0)
    assert limits.items() <= plan.limits.items()
    horizontal, up = (plan.contact_force[..., part] for part in (slice(2), 2))
    assert (np.linalg.norm(horizontal, axis=-1) - plan.limits["friction"] * up).max() < 1.0


def test_less_begins_where_the_table_is_sure_and_where_that_leads_nowhere_further_back():
    robot = load_robot("go2")
    feasible, wanted = feasible_of(robot), Jump(robot="go2", twist=2.9, forward=0.4)
    for limits in {}, {"friction": 0.5}:
        sure, *back = nearest._shares(make_task(wanted, robot, limits=limits), feasible)
        assert feasible.score(nearest._share(wanted, sure)) >= nearest.SURE
        assert 0 < back[-1] < back[0] < sure


def test_behind_what_is_reached_is_what_the_table_leads_to_by_itself(monkeypatch):
    robot = load_robot("go2")
    of, wanted = refiner(robot), Jump(robot="go2", twist=2.9, forward=0.4)
    task = make_task(wanted, robot, limits={"friction": 0.5})
    begun = nearest._shares(task, feasible_of(robot))
    for far in (None, replace(wanted, twist=2.6)):
        reached = None if far is None else nearest.Reached(far, of.nearby(far, task.tuning))
        monkeypatch.setattr(nearest, "_moved", lambda *_, reached=reached: reached)
        found = [each.jump for each in nearest.nearest(of, task, feasible_of(robot), Watch())]
        own = [nearest._in_whole_steps(nearest._share(wanted, s), task, 0.0) for s in begun]
        assert found[-len(own) :] == own
        assert (len(found) > len(own)) == (far is not None)


def test_of_types_limits_and_weights_without_a_table_no_less_is_looked_for():
    robot = load_robot("go2")
    for jump, tuning in (
        (Jump(robot="go2", type="hops"), {}),
        (Jump(robot="go2", twist=2.9), {"limits": {"foot_speed": 3.0}}),
        (Jump(robot="go2", twist=2.9), {"weights": {"time": 2.0}}),
    ):
        assert CertifiedPlanner().nearest(make_task(jump, robot, **tuning)) is None
    twist = make_task(Jump(robot="go2", twist=2.9), robot)
    assert CertifiedPlanner(guesses=False).nearest(twist) is None

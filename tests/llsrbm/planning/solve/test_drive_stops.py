"""Jumps beyond the drives are refused by the name of the joint, the place and the amount."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm.errors import NotConverged
from llsrbm.planning.problem.constraints.drives import JointSpeed, JointTorque, TorqueAtSpeed
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import describe_worst, stops, violations
from llsrbm.planning.solve.explanation import explain, in_words
from llsrbm.planning.solve.planner import planner_for
from llsrbm.planning.solve.search import FeasibilitySearch
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import solved

ANYMAL = load_robot("anymal")
HOP = Jump(model="srbm", height=0.1)
LITTLE_TORQUE = {"torque_share": 0.25}
# Larger than ANYmal's drives allow in any of its components together.
BEYOND = Jump(twist=math.radians(162), forward=-0.12, lateral=0.27, height=-0.1)

TORQUE = re.compile(r"(\w\w_\w+) would need (\d+) Nm (at|in) .*, (\d+) % of its drive's 40 Nm")


def under(knots, **limits):
    task = make_task(knots.task.jump, knots.task.robot, None, limits)
    return knots.under(task)


def test_the_error_names_joint_place_and_amount_in_one_line():
    with pytest.raises(NotConverged) as caught:
        llsrbm.plan(HOP, limits=LITTLE_TORQUE)
    (stop,) = caught.value.stops
    assert str(caught.value) == f"no plan found in 3 attempts: {stop.detail}"
    assert "\n" not in stop.detail
    assert (stop.constraint, stop.limit, stop.value) == ("joint_torque", "torque_share", 0.25)
    found = TORQUE.match(stop.detail)
    assert found, stop.detail
    joint, torque, _, percent = found.groups()
    assert joint in ANYMAL.joint_names
    assert float(torque) == pytest.approx(0.4 * float(percent), abs=0.8)
    assert float(percent) > 25
    assert stop.detail.endswith("; plans may use 25 % (torque_share)")
    assert str(stop) == stop.detail == in_words((stop,))
    # A plan is possible with what it says would be needed.
    planner = planner_for("anymal", "srbm")
    assert planner.plan(HOP, limits={"torque_share": stop.needed}).solved


def test_a_jump_that_no_drive_limit_alone_allows_names_the_joints_first():
    planner = planner_for("anymal", "llsrbm-plus")
    task = make_task(BEYOND, ANYMAL, None, {"torque_share": 0.5, "speed_share": 0.5})
    found = explain(FeasibilitySearch(planner.formulation), task)
    assert len(found) > 1
    assert all(stop.together for stop in found)
    assert found[0].limit in ("torque_share", "speed_share")
    (torque,) = [stop for stop in found if stop.limit == "torque_share"]
    joint = torque.detail.split()[0]
    assert joint in ANYMAL.joint_names
    assert "plans may use 50 %" in torque.detail
    assert "\n" not in in_words(found)


@pytest.mark.parametrize("constraint", [JointTorque(), TorqueAtSpeed()])
def test_the_demand_is_the_largest_excess_of_torque(constraint):
    knots = under(solved("srbm", "twist").knots, torque_share=0.3)
    loads, limit = knots.loads, ANYMAL.torque_limit
    excess = (np.abs(loads.joint_torque) - 0.3 * loads.torque_available) / limit
    k, j = np.unravel_index(excess.argmax(), excess.shape)
    demand = constraint.demand(knots)
    assert demand.interval == k
    torque = abs(loads.joint_torque[k, j])
    assert demand.words.startswith(f"{loads.joint_names[j]} would need {torque:.0f} Nm ")
    # As the robot's own limits have it, there is nothing to say.
    assert constraint.demand(under(knots, torque_share=3.0)) is None


def test_the_demand_of_speed():
    knots = under(solved("srbm", "forward").knots, speed_share=0.2)
    speed = np.abs(knots.loads.joint_velocity) / ANYMAL.speed_limit
    k, j = np.unravel_index(speed.argmax(), speed.shape)
    demand = JointSpeed().demand(knots)
    assert demand.interval == k
    assert demand.words.startswith(f"{knots.loads.joint_names[j]} would have to turn at ")
    percent = f"{100 * speed[k, j]:.0f} % of its drive's 15 rad/s"
    assert demand.words.endswith(f"{percent}; plans may use 20 % (speed_share)")


def test_sliding_joints_have_forces_and_slide():
    knots = solved("llsrbm-plus", "box", "slider").knots
    robot, loads = knots.task.robot, knots.loads
    (slide, *_) = [j for j, n in enumerate(robot.joint_names) if n in robot.sliding_joints]
    torque, speed = np.zeros_like(loads.joint_torque), np.zeros_like(loads.joint_velocity)
    torque[10, slide], speed[10, slide] = 2000.0, 7.0
    knots = under(knots)
    vars(knots)["loads"] = replace(
        loads,
        joint_torque=torque,
        joint_velocity=speed,
        torque_available=np.tile(robot.torque_limit, (len(torque), 1)),
    )
    assert "would need 2000 N " in JointTorque().demand(knots).words
    assert "would have to slide at 7 m/s" in JointSpeed().demand(knots).words


def test_what_a_motion_violates_is_told_with_the_joint():
    """Of the planner's last iterate, where no further solve has looked for the limit."""
    knots = under(solved("srbm", "twist").knots, torque_share=0.3)
    broken = violations(knots)
    words = describe_worst(broken, knots)
    demand = JointTorque().demand(knots)
    # The same joint breaks torque at rest and torque at speed: the message names it once.
    assert words == demand.words
    assert describe_worst(broken).startswith(("joint_torque is", "torque_at_speed is"))
    found = stops(knots)
    assert {stop.constraint for stop in found} == {"joint_torque", "torque_at_speed"}
    for stop in found:
        assert str(stop) == demand.words
        assert stop.time == knots.time[demand.interval]
    (limited,) = [stop for stop in found if stop.limit is not None]
    assert 0.3 < limited.needed < 0.9

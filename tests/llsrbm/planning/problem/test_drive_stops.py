"""Jumps beyond the drives are refused by the name of the joint, the place and the amount."""

import numpy as np
import pytest

from llsrbm.planning.problem.constraints.drives import JointSpeed, JointTorque, TorqueAtSpeed
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.violations import describe_worst, stops, violations
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import solved

ANYMAL = load_robot("anymal")


def under(knots, **limits):
    task = make_task(knots.task.jump, knots.task.robot, None, limits)
    return knots.under(task)


@pytest.mark.parametrize("constraint", [JointTorque(), TorqueAtSpeed()])
def test_the_demand_is_the_largest_excess_of_torque(constraint):
    knots = under(solved("srbm", "twist").knots, torque_share=0.3)
    loads, limit = knots.loads, ANYMAL.torque_limit
    # In the middle of intervals, and with the speeds at lift-off and touchdown.
    places = np.stack([loads.torque_available, loads.edge_available])
    excess = (np.abs(loads.joint_torque) - 0.3 * places) / limit
    i, k, j = np.unravel_index(np.nanargmax(excess), excess.shape)
    demand = constraint.demand(knots)
    assert demand.interval == k
    torque = abs(loads.joint_torque[k, j])
    has = 0.3 * places[i, k, j]
    found = demand.demand
    assert (found.joint, found.needed, found.unit) == (loads.joint_names[j], torque, "Nm")
    assert found.has == pytest.approx(has)
    assert str(found).startswith(f"{found.joint} needs {torque:.2g} Nm ")
    assert str(found).endswith(f", it has {has:.2g}")
    # As the robot's own limits have it, there is nothing to say.
    assert constraint.demand(under(knots, torque_share=3.0)) is None


def test_the_demand_of_speed():
    knots = under(solved("srbm", "forward").knots, speed_share=0.2)
    speed = np.abs(np.stack([knots.loads.joint_velocity, knots.loads.edge_velocity]))
    has = 15.0 * np.array([0.2, 0.2 / 0.9])  # more of it at lift-off and touchdown
    excess = speed - has[:, None, None]
    i, k, j = np.unravel_index(np.nanargmax(excess), excess.shape)
    demand = JointSpeed().demand(knots)
    assert demand.interval == k
    found = demand.demand
    assert (found.joint, found.unit) == (knots.loads.joint_names[j], "rad/s")
    assert (found.needed, found.has) == pytest.approx((speed[i, k, j], has[i]))


def test_what_a_motion_violates_is_told_with_the_joint():
    """Of the planner's last iterate, where no further solve has looked for the limit."""
    knots = under(solved("srbm", "twist").knots, torque_share=0.3)
    broken = violations(knots)
    words = describe_worst(broken, knots)
    demand = JointTorque().demand(knots)
    # The same joint breaks torque at rest and torque at speed: the message names it once.
    assert words == str(demand.demand)
    assert describe_worst(broken).startswith("a joint needs more torque than it has")
    found = stops(knots)
    assert {stop.constraint for stop in found} == {"joint_torque", "torque_at_speed"}
    for stop in found:
        assert stop.demand == demand.demand
        assert stop.time == knots.time[demand.interval]
    assert any(str(stop) == words for stop in found)
    (limited,) = [stop for stop in found if stop.limit is not None]
    assert 0.3 < limited.needed < 0.9

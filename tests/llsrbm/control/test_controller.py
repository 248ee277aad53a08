"""Feet that find the ground without a sound."""

import numpy as np
import pytest

from llsrbm.control.controller import WholeBodyController
from llsrbm.control.delay import Measurement
from llsrbm.control.foot_force import FootForces
from llsrbm.control.leaving import SWINGING
from llsrbm.control.whole_body import WholeBody
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import solved

ROBOT = load_robot("anymal")
SINKING = 0.2  # m/s


class TouchdownAt:
    """A detector that knows."""

    signal = 0.0

    def __init__(self, ticks):
        self.left = ticks

    def reset(self):
        pass

    def update(self, _):
        self.left -= 1
        return self.left < 0


@pytest.fixture
def controller(monkeypatch):
    """In flight for three ticks, then told that something was touched."""
    plan = solved("llsrbm-plus", "forward").plan
    controller = WholeBodyController(ROBOT, plan, Scenario())
    controller.detector = TouchdownAt(3)
    # The states below are made by hand: they show no force at the feet.
    monkeypatch.setattr(FootForces, "met_ground", lambda self: True)
    return controller, plan.phase_start[1]


def sinking(feet):
    """A standing robot's state, some of whose feet sink, and torques that leave no foot force."""
    body, v = WholeBody(ROBOT), np.zeros(18)
    body.update(ROBOT.posture, v)
    for leg, sinks in enumerate(feet):
        if sinks:
            rows = 6 + ROBOT.leg_joint_index[leg]
            v[rows] = np.linalg.solve(body.foot_jacobian[leg][:, rows], [0, 0, -SINKING])
    body.update(ROBOT.posture, v)
    return ROBOT.posture, v, body.h[6:]


def standing_over_time(controller, start, phases):
    """{s since detection: (L,) feet that stand}; phases: (s until which, feet that sink)."""
    tick, found = 1 / ROBOT.file.control.rate, {}
    for k in range(100):
        since = k * tick - 3 * tick
        feet = next((feet for until, feet in phases if since < until - 1e-9), None)
        if feet is None:
            break
        done = controller.step(Measurement(start + k * tick, *sinking(feet)))
        if (detected := controller.contacts.detected) is not None:
            assert done.phase == 2
            found[round(start + k * tick - detected, 6)] = controller.contacts.standing
    return found


def test_feet_put_down_gently_stand_within_40_ms(controller):
    """No force shows at any foot; those that do not sink though they should are on the ground."""
    found = standing_over_time(*controller, [(0.06, (False, False, True, True))])
    first = min(found)
    assert first == 0.0
    assert found[first].sum() == 1  # something was touched, nobody knows by whom
    assert not any(feet[2:].any() for feet in found.values())
    settled = min(time for time, feet in found.items() if feet[:2].all())
    assert 0.010 < settled <= 0.040


@pytest.mark.parametrize("off", [-0.2, 0.03])
def test_feet_in_flight_are_at_their_planned_height_whatever_the_robots(controller, off):
    """Up to 5 cm; beyond, the ground is not where it was planned."""
    controller, start = controller
    controller.detector = TouchdownAt(100)
    q = ROBOT.posture.copy()
    for late in (False, True):
        # Of the flight, and after feet that are on the ground still have left it.
        time = controller.contacts.plan_time(start) + SWINGING.lasts + 0.002
        if late:
            time = controller.flights[-1].touchdown + 0.01
        planned = controller.target(time)
        body = WholeBody(ROBOT)
        body.update(q, np.zeros(18))
        if not late:
            q[2] += planned.com[2] + off - body.com[2]
        done = controller.step(Measurement(time, q, np.zeros(18), np.zeros(12)))
        if late:
            planned = controller._reference.late(1)
        moved = (done.target.foot_from_com - planned.foot_from_com)[:, 2]
        np.testing.assert_allclose(moved, np.clip(-off, -0.05, 0.05), atol=1e-9)

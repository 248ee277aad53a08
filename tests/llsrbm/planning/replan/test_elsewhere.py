"""The whole planner and replanner with the world turned, moved or mirrored: the same motion."""

from functools import cache

import numpy as np
import pytest

from llsrbm.mechanics import interpolated
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.replan.replanner import Replanner
from llsrbm.planning.solve.watch import Watch
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.llsrbm.planning.elsewhere import Elsewhere, other_side
from tests.llsrbm.planning.replan.test_replanner import FLIGHT, LANDING, plan, state
from tests.llsrbm.planning.solved import solved

ROBOT = load_robot("anymal")
HEADINGS = [*np.radians([17.0, 45.0, 60.0, 133.0]), *np.random.default_rng(3).uniform(-3, 3, 1)]
# The pyramid of friction has the world's axes: on rough ground that matters by some millimetres.
ROUGH = {"friction": 1.5}


@cache
def first():
    return planned(Elsewhere())


def planned(there):
    """Knots of a jump elsewhere, from the same guess: those that are made begin at the origin."""
    formulation = solved("llsrbm-plus", "all").planner.formulation
    jump = Jump(robot="anymal", twist=0.8, forward=0.2, lateral=0.15, height=0.15)
    task = make_task(jump, ROBOT, None, ROUGH)
    guess = there.variables(ROBOT, formulation.layout, formulation.guess(task))
    attempt = formulation.solve(there.task(task), guess, Watch())
    assert attempt.solved
    return attempt.knots


@pytest.mark.parametrize("heading", HEADINGS)
def test_jumps_are_planned_alike_whatever_the_heading_and_the_origin(heading):
    there = Elsewhere(heading, (1.3, -0.8, 0.4))
    knots = planned(there)
    np.testing.assert_allclose(knots.durations, first().durations, atol=5e-3)
    np.testing.assert_allclose(knots.position, there.points(first().position), atol=6e-3)
    np.testing.assert_allclose(knots.feet_in_hip, first().feet_in_hip, atol=0.01)
    quat = there.quats(first().quat)
    np.testing.assert_allclose(np.abs(np.sum(knots.quat * quat, axis=1)), 1.0, atol=1e-4)


def test_jumps_to_the_other_side_are_the_mirror_image():
    """As far as ANYmal's file is the same on both sides."""
    there = Elsewhere(mirrored=True)
    knots, legs = planned(there), other_side(ROBOT)
    np.testing.assert_allclose(knots.durations, first().durations, atol=2e-3)
    np.testing.assert_allclose(knots.position, there.points(first().position), atol=3e-3)
    np.testing.assert_allclose(knots.feet_in_hip, first().feet_in_hip[:, legs], atol=0.01)


@pytest.mark.parametrize("phase", [FLIGHT, pytest.param(LANDING, marks=pytest.mark.nightly)])
def test_what_is_planned_anew_does_not_depend_on_the_heading(phase):
    """From the same push, seen from the robot."""
    at = state(plan().phase_start[phase] + 0.04, phase, velocity=(0.2, 0.3, 0.0))
    here = Replanner(plan(), ROBOT).replan(at).plan
    for heading in HEADINGS:
        there = Elsewhere(heading, (1.3, -0.8, 0.0))
        replanner = Replanner(there.plan(plan()), ROBOT)
        replanner._task = there.task(replanner._task)
        new = replanner.replan(there.state(at)).plan
        assert new.phase_start == pytest.approx(here.phase_start, abs=5e-3)
        com = interpolated(here.time, new.time, new.com)
        np.testing.assert_allclose(com, there.points(here.com), atol=5e-3)
        feet = there.points(here.foot_position[-1])
        np.testing.assert_allclose(new.foot_position[-1], feet, atol=5e-3)

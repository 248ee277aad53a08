"""What drives, payload and links would change in the cost, against solving again, on Go2."""

from dataclasses import replace
from functools import cache

import numpy as np
import pinocchio as pin
import pytest

import llsrbm
from llsrbm.analysis.sensitivity import EXACTLY, Optimum
from llsrbm.planning.whole_body.sizes import robot_numbers
from llsrbm.robots import load_robot
from tests.llsrbm.player.stages import stored_plan

ROBOT = load_robot("go2")
LENGTH = "length from FL_thigh_joint to FL_calf_joint"


plan = stored_plan  # of a quarter turn


@cache
def found():
    return {each.name: each for each in llsrbm.sensitivity(plan())}


@cache
def optimum():
    return Optimum.of(plan())


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("payload", ROBOT.mass),
        (LENGTH, 21.3),
    ],
)
def test_the_cost_changes_so_when_it_is_solved_again(name, value):
    """With 2 % of the robot's own more and less."""
    at, step = optimum(), 0.02 * value
    moved = {each: move for each, _, move in at.moves()}[name]
    more, less = (
        at.refiner.solver.solve(moved(change), at.solution.variables, EXACTLY)
        for change in (step, -step)
    )
    assert more.converged
    assert less.converged
    changed = (more.cost - less.cost) / (2 * step) / at.solution.cost
    assert found()[name].share == pytest.approx(changed, rel=0.05)


def test_a_kilogram_is_a_point_mass_on_the_trunk():
    model = ROBOT.model.copy()
    model.inertias[1] += pin.Inertia(1.0, np.zeros(3), np.zeros((3, 3)))
    loaded = robot_numbers(replace(ROBOT, model=model, mass=pin.computeTotalMass(model)))
    moves = {name: move for name, _, move in optimum().moves()}
    found = moves["payload"](1.0).parameters[: len(loaded)]
    np.testing.assert_allclose(found, loaded, rtol=1e-12)


def test_a_robot_with_longer_links_stands_as_much_higher():
    """By Pinocchio, whose feet then are where they land."""
    model = ROBOT.model.copy()
    for leg in ROBOT.legs:
        arm = model.jointPlacements[leg.joint_ids[2]].translation
        arm *= 1 + 0.01 / np.linalg.norm(arm)
    data = model.createData()
    pin.framesForwardKinematics(model, data, ROBOT.posture)
    feet = np.array([data.oMf[leg.foot_frame_id].translation for leg in ROBOT.legs])
    before = ROBOT.feet + np.array([0.0, 0.0, ROBOT.foot_lift])
    np.testing.assert_allclose(0.01 * optimum()._stretched(2), feet - before, atol=1e-9)


def test_they_are_sorted_and_said_in_sentences():
    shares = [abs(each.share) for each in found().values()]
    assert shares == sorted(shares, reverse=True)
    assert len(found()) == 1 + 2 * 12 + 3
    longer = found()[LENGTH]
    assert longer.unit == "cm"
    assert str(longer).startswith(f"1 cm more {LENGTH} lowers the cost by ")
    assert str(replace(longer, share=1e-7)) == f"1 cm more {LENGTH} changes nothing"


def test_a_draft_has_none():
    with pytest.raises(llsrbm.InputError, match="is a draft"):
        llsrbm.sensitivity(replace(plan(), refinement=None))

"""Plans whose feet land where a request has them, by forward kinematics alone, and followed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import llsrbm
from llsrbm.mechanics import turns_about_z
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from tests.llsrbm.kinematics import foot_positions

ROBOT = load_robot("go2")
JUMP = llsrbm.Jump(robot="go2", twist=0.6, forward=0.1)
ASIDE = {"FL": (0.04, 0.02, 0.02), "RR": (-0.03, -0.04)}
OBEYED = 0.005  # m


@cache
def draft(stones=True):
    return llsrbm.plan(replace(JUMP, stones=ASIDE if stones else ()), draft=True)


@cache
def plan():
    return llsrbm.plan(replace(JUMP, stones=ASIDE))


def lands(found):
    """(L, 3) m: the feet at the end."""
    order = [found.joint_names.index(name) for name in ROBOT.joint_names]
    q = found.joint_position[-1:, order]
    return foot_positions(ROBOT, found.base_position[-1:], found.base_quat[-1:], q)[0]


def expected():
    place = ROBOT.feet.copy()
    for leg, away in ASIDE.items():
        place[ROBOT.leg_names.index(leg)] += (*away, 0.0)[:3]
    return place @ turns_about_z(JUMP.twist).T + [JUMP.forward, JUMP.lateral, JUMP.height]


@pytest.mark.parametrize("made", [draft, plan])
def test_feet_land_there(made):
    assert np.linalg.norm(lands(made()) - expected(), axis=1).max() < OBEYED
    np.testing.assert_allclose(lands(draft(stones=False))[1:3], expected()[1:3], atol=OBEYED)


def test_the_whole_bodys_plan_is_certified_and_followed():
    assert plan().certified
    rollout = llsrbm.simulate(plan())
    assert rollout.outcome.strict
    np.testing.assert_allclose(rollout.foot_position[-1], expected(), atol=0.03)


def test_a_foot_that_lands_higher_has_a_stone_under_it_and_another_beside_it_none():
    (stone,) = surroundings(ROBOT, plan(), Scenario()).blocks
    assert stone.name == "stone FL"
    low, high = stone.centre - stone.size / 2, stone.centre + stone.size / 2
    assert (low[2], high[2]) == pytest.approx((0.0, 0.02))
    off = (expected() - stone.centre) @ turns_about_z(JUMP.twist)
    inside = (np.abs(off[:, :2]) < stone.size[:2] / 2).all(axis=1)
    assert inside.tolist() == [True, False, False, False]


def test_its_file_has_it(tmp_path):
    plan().save(tmp_path / "plan.npz")
    assert llsrbm.load(tmp_path / "plan.npz").jump == plan().jump


def test_another_plan_begins_from_it_and_back():
    """As while a foot is dragged."""
    moved = llsrbm.plan(replace(JUMP, stones={"FL": (0.05, 0.02, 0.02)}), near=draft(), draft=True)
    assert moved.report.guess != draft().report.guess
    back = llsrbm.plan(JUMP, near=moved, draft=True)
    np.testing.assert_allclose(lands(back), lands(draft(stones=False)), atol=1e-6)

import math
from types import SimpleNamespace

import numpy as np
import pytest

from app.picture.foothold_handles import FootholdHandles, FootholdMoved
from llsrbm.mechanics import turns_about_z
from llsrbm.planning.problem.placement import place_task
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.picture.gizmo import Gizmo

ROBOT = load_robot("go2")
JUMP = Jump(robot="go2", twist=0.7, forward=0.2, lateral=-0.1, height=0.1)


class Feet:
    """Handles without a page."""

    def __init__(self):
        self.gizmos, self.moved, self.painted = [], [], []
        scene = SimpleNamespace(add_transform_controls=self._add)
        client = SimpleNamespace(scene=scene)
        self.handles = FootholdHandles(client, self.moved.append, self.painted.append)

    def _add(self, name, **options):
        self.gizmos.append(Gizmo(name=name, **options))
        return self.gizmos[-1]

    def draw(self, jump=JUMP, robot=ROBOT, *, visible=True):
        return self.handles.draw(jump, robot, visible=visible)

    def put(self, foot, away):
        """Drag a handle from where it stands, (3,) m in the world; where it was dragged to."""
        gizmo = self.gizmos[foot]
        gizmo.position = tuple(np.add(gizmo.position, away))
        gizmo.drag("update")
        return self.handles.read(self.moved[-1])

    def square(self, foot, scale=None):
        """The middle of a handle's square, as drei has it."""
        gizmo = self.gizmos[foot]
        heading = 2 * math.atan2(gizmo.wxyz[3], gizmo.wxyz[0])
        along = 1.7 / 7 * gizmo.scale
        return gizmo.position + turns_about_z(heading) @ [along, along, 0]


@pytest.fixture
def feet():
    feet = Feet()
    assert feet.draw()
    return feet


def test_each_stands_under_its_foot_as_it_lands(feet):
    lands = place_task(JUMP, ROBOT).places[-1].feet
    assert [gizmo.visible for gizmo in feet.gizmos] == [True] * 4
    for foot, at in enumerate(lands):
        assert feet.square(foot) == pytest.approx(at, abs=0.01)
    assert feet.painted == [gizmo.name for gizmo in feet.gizmos]
    assert not feet.draw()


def test_a_dragged_foot_lands_as_far_beside_as_the_robot_looks_then(feet):
    away = turns_about_z(JUMP.twist) @ [0.0404, -0.02, 0.3]
    dragged = feet.put(1, away)
    assert dragged.leg == "FR"
    assert (dragged.dx, dragged.dy) == pytest.approx((0.0404, -0.02))
    jump = dragged.applied_to(JUMP, ROBOT)
    assert jump.stones == (("FR", 0.04, -0.02, 0.0),)
    feet.draw(jump)
    lands = place_task(jump, ROBOT).places[-1].feet
    assert feet.square(0) == pytest.approx(lands[0], abs=0.01)
    feet.gizmos[1].drag("end")
    feet.handles.read(feet.moved[-1])
    feet.draw(jump)
    assert feet.square(1) == pytest.approx(lands[1], abs=0.01)


def test_the_one_that_is_held_stays_in_the_hand(feet):
    feet.gizmos[2].drag("start")
    feet.handles.read(feet.moved[-1])
    held = feet.put(2, (0.01, 0.0, 0.0))
    before = feet.gizmos[2].position
    others = feet.gizmos[0].position
    feet.draw(held.applied_to(Jump(robot="go2", forward=0.1), ROBOT))
    assert feet.gizmos[2].position == before
    assert feet.gizmos[0].position != others


def test_grips_are_numbered_and_ended(feet):
    said = []
    for phase in ("start", "update", "end", "start", "update", "end"):
        feet.gizmos[3].drag(phase)
        dragged = feet.handles.read(feet.moved[-1])
        said.append((dragged.grip, dragged.held))
    assert said == [(1, True), (1, True), (1, False), (2, True), (2, True), (2, False)]


def test_the_other_feet_and_the_height_of_a_stone_stay(feet):
    jump = Jump(robot="go2", stones={"FL": (0.01, 0.0, 0.02), "RR": (0.0, 0.03)})
    feet.draw(jump)
    moved = feet.put(0, (0.02, 0.01, 0.0)).applied_to(jump, ROBOT)
    assert moved.stones == (("FL", 0.03, 0.01, 0.02), ("RR", 0.0, 0.03, 0.0))


def test_a_foot_is_not_dragged_out_of_reach(feet):
    for away in np.random.default_rng(1).uniform(-3, 3, (20, 3)):
        jump = feet.put(0, away).applied_to(JUMP, ROBOT)
        (stone,) = jump.stones
        assert 0.02 < math.hypot(stone.dx, stone.dy) < 0.5
        feet.draw(JUMP)
        feet.gizmos[0].drag("end")
        feet.handles.read(feet.moved[-1])
        feet.draw(JUMP)


@pytest.mark.parametrize("nonsense", ["here", None, [], [1.0, 0.0], [math.nan] * 3, {}])
def test_what_is_no_place_changes_nothing(feet, nonsense):
    feet.gizmos[0].position = nonsense
    assert feet.handles.read(FootholdMoved(0, held=True)) is None


def test_they_are_hidden_where_there_is_no_target(feet):
    unknown = Jump(robot="go2", stones={"LF": (0.1, 0.0)})
    for jump, robot, visible in (
        (JUMP, ROBOT, False),
        (None, ROBOT, True),
        (JUMP, None, True),
        (unknown, ROBOT, True),
    ):
        feet.draw(JUMP)
        feet.draw(jump, robot, visible=visible)
        assert not any(gizmo.visible for gizmo in feet.gizmos)


def test_a_robot_with_fewer_legs_has_fewer(feet):
    feet.draw(Jump(robot="g1"), load_robot("g1"))
    assert [gizmo.visible for gizmo in feet.gizmos] == [True, True, False, False]
    assert 0.04 < 0.225 * feet.gizmos[0].scale < 0.1

"""What stands where: under the feet it is meant for, and in nobody's way."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from llsrbm.errors import InputError
from llsrbm.mechanics import turns_about_z
from llsrbm.motion.surroundings import check_board, ground_under, surroundings
from llsrbm.planning.problem.placement import place_task
from llsrbm.planning.problem.task import Edges
from llsrbm.request.jump import Jump
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.scenario import Scenario
from llsrbm.request.slopes import normals
from llsrbm.robots import load_robot
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan
from tests.llsrbm.schedules import in_a_row

ANYMAL = load_robot("anymal")
RADIUS = 0.031
MIDDLE = STAND + FLY / 2


def around(scenario=None, **jump):
    plan = synthetic_plan(Jump(**jump))
    return plan, surroundings(ANYMAL, plan, scenario or Scenario())


def overhang(block, points, radius=0.0):
    """(L,) m: how far each point is inside a block's footprint, less a radius; negative outside."""
    c, s = math.cos(block.yaw), math.sin(block.yaw)
    own = (points[:, :2] - block.centre[:2]) @ np.array([[c, -s], [s, c]])
    return (block.size[:2] / 2 - np.abs(own)).min(axis=1) - radius


def corners(block):
    """(4, 2) m: of a block's footprint."""
    c, s = math.cos(block.yaw), math.sin(block.yaw)
    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    return block.centre[:2] + (signs * block.size[:2] / 2) @ np.array([[c, s], [-s, c]])


def apart(one, other):
    """How far the hulls of two sets of points (C, 2) are from each other, m; negative inside.

    By separating axes: of all directions the one in which the gap is widest.
    """
    angles = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    directions = np.stack([np.cos(angles), np.sin(angles)])
    return ((other @ directions).min(axis=0) - (one @ directions).max(axis=0)).max()


def top(block):
    return block.centre[2] + block.size[2] / 2


def test_level_jumps_have_the_ground_alone():
    _, world = around(twist=1.0, forward=0.3)
    assert world.ground == 0
    assert world.blocks == ()


@pytest.mark.parametrize("forward", [0.0, 0.3])
@pytest.mark.parametrize(
    ("height", "moving"), [(0.2, "The box comes in mid"), (-0.15, "The block goes in mid")]
)
def test_a_block_in_which_the_robot_would_stand_moves_and_says_so(height, moving, forward):
    plan, world = around(height=height, forward=forward)
    (block,) = world.blocks
    start, goal = plan.foot_position[[0, -1]]
    assert overhang(block, goal if height > 0 else start).min() == pytest.approx(0.25)
    assert 0 < (block.from_s if height > 0 else block.until_s) == pytest.approx(MIDDLE, abs=0.05)
    assert world.in_mid_flight.startswith(moving)


def test_a_trunk_that_would_dip_into_the_box_has_it_come_in_mid_flight():
    plan, world = around(height=0.2, forward=1.0)
    assert world.in_mid_flight == ""
    low = replace(plan, base_position=plan.base_position - [0.0, 0.0, 0.45])
    assert "box" in surroundings(ANYMAL, low, Scenario()).in_mid_flight


@pytest.mark.parametrize("height", [0.2, -0.15])
@pytest.mark.parametrize("forward", [0.9, 0.95, 2.0])
def test_start_and_landing_apart_stand_all_the_time(height, forward):
    plan, world = around(height=height, forward=forward)
    (block,) = world.blocks
    assert world.in_mid_flight == ""
    start, goal = plan.foot_position[[0, -1]]
    on, beside = (goal, start) if height > 0 else (start, goal)
    assert overhang(block, on, RADIUS).min() >= -1e-9
    assert overhang(block, beside, -RADIUS).max() <= 1e-9
    margins = np.sort((block.size[:2] - np.ptp(on[:, :2], axis=0)) / 2)
    assert margins[1] == pytest.approx(0.25)


@settings(max_examples=60, deadline=None)
@example(twist=2.25, forward=0.0, lateral=0.75, height=0.05)  # a corner came between two feet
@given(
    twist=st.floats(-3.1, 3.1),
    forward=st.floats(-1.5, 1.5),
    lateral=st.floats(-1.5, 1.5),
    height=st.sampled_from([-0.2, -0.05, 0.05, 0.2]),
)
def test_nothing_stands_in_the_way(twist, forward, lateral, height):
    plan, world = around(twist=twist, forward=forward, lateral=lateral, height=height)
    start, goal = plan.foot_position[[0, -1]]
    on, beside = (goal, start) if height > 0 else (start, goal)
    (block,) = world.blocks
    assert overhang(block, on, RADIUS).min() >= -1e-9
    if (block.from_s, block.until_s) == (0, math.inf):
        assert overhang(block, beside, -RADIUS).max() <= 1e-9
        assert apart(corners(block), beside[:, :2]) >= RADIUS
    else:
        assert world.in_mid_flight


def test_a_board_on_the_ground_lies_under_all_feet_from_mid_flight_on():
    plan, world = around(Scenario(board=0.025), twist=0.5, forward=0.3)
    (board,) = world.blocks
    assert top(board) == pytest.approx(0.025)
    assert board.size == pytest.approx([2, 2, 0.025])
    assert board.from_s == pytest.approx(MIDDLE)
    assert board.until_s == math.inf
    assert overhang(board, plan.foot_position[-1]).min() > 0.4


@pytest.mark.parametrize("height", [0.0, 0.2, -0.2])
def test_half_a_board_lies_under_the_front_feet_alone(height):
    """Front in the heading of the landing, whatever that is."""
    plan, world = around(
        Scenario(board=0.025, half_board=True), twist=2.0, forward=0.2, height=height
    )
    (board,) = (block for block in world.blocks if block.name == "board")
    assert top(board) == pytest.approx(height + 0.025)
    inside = overhang(board, plan.foot_position[-1])
    assert (inside[:2] > 0.2).all()
    assert (inside[2:] < -0.2).all()


def test_on_a_slope_a_board_and_a_stone_rise_above_its_surface():
    """They lay at its height, inside the box, where no foot met them."""
    _, world = around(
        Scenario(board=0.025), slope=0.2, cross_slope=-0.1, stones={"LF": (0, 0, 0.03)}
    )
    blocks = {block.name: block for block in world.blocks}

    def surface(name):
        """m: of its upper face, above the world's origin."""
        block = blocks[name]
        tilt = np.array(block.tilt)
        point = block.centre + normals(tilt) * block.size[2] / 2
        return point[2] - point[:2] @ tilt

    assert surface("board") == pytest.approx(surface("box") + 0.025)
    assert surface("stone LF") == pytest.approx(surface("box") + 0.03)


@pytest.mark.parametrize("height", [0.0, 0.15, -0.15])
def test_the_thickest_board_passes_under_the_feet(height):
    plan = synthetic_plan(Jump(height=height))
    middle = np.argmin(np.abs(plan.time - MIDDLE))
    room = plan.foot_position[middle, :, 2].min() - height - 0.01
    assert plan.time[middle] == pytest.approx(MIDDLE)
    check_board(plan, 0.0)
    check_board(plan, room - 1e-3)
    for wrong in (room + 1e-3, 1.0, -0.01, float("nan")):
        with pytest.raises(InputError, match=r"^board: expected 0 to 0\.\d\d\d m") as caught:
            check_board(plan, wrong)
        largest = float(str(caught.value).split("expected 0 to ")[1].split()[0])
        assert room - 1e-3 <= largest <= room + 1e-12
        check_board(plan, largest)


def hops(*heights, forward=0.3, twist=0.0):
    """Jumps in a row with these differences of height."""
    return in_a_row(
        *(synthetic_plan(Jump(height=height, forward=forward, twist=twist)) for height in heights)
    )


def stood_on(plan, place):
    """(L, 3) m: the footholds of a place of a plan of jumps in a row."""
    return plan.foot_position[48 * place]


def test_hops_up_stairs_have_a_box_under_each_place():
    plan = hops(0.2, 0.15, forward=2.0)
    world = surroundings(ANYMAL, plan, Scenario())
    first, second = world.blocks
    assert world.ground == 0
    assert [block.name for block in world.blocks] == ["box 1", "box"]
    assert [top(first), top(second)] == pytest.approx([0.2, 0.35])
    assert overhang(first, stood_on(plan, 1)).min() > 0
    assert overhang(second, stood_on(plan, 2)).min() > 0


def test_hops_that_are_near_have_boxes_that_come_in_their_own_flights():
    plan = hops(0.2, 0.1)
    first, second = surroundings(ANYMAL, plan, Scenario()).blocks
    assert [first.from_s, second.from_s] == pytest.approx([MIDDLE, MIDDLE + plan.time[48]])


def test_the_ground_is_below_the_lowest_place():
    for heights in ((-0.1, 0.1), (0.1, -0.3), (0.1, 0.2)):
        plan = hops(*heights)
        around = surroundings(ANYMAL, plan, Scenario())
        assert ground_under(plan) == around.ground <= min(0.0, heights[0])


def test_hops_far_apart_have_boxes_that_stand_all_the_time():
    plan = hops(0.2, -0.2, forward=2.0, twist=0.7)
    (box,) = surroundings(ANYMAL, plan, Scenario()).blocks
    assert (box.name, box.from_s, box.until_s) == ("box 1", 0, math.inf)
    assert box.yaw == pytest.approx(0.7)
    assert overhang(box, stood_on(plan, 1)).min() == pytest.approx(0.25)
    for place in (0, 2):
        assert overhang(box, stood_on(plan, place), -RADIUS).max() < 0


@pytest.mark.parametrize("height", [0.2, 2.0])
def test_a_box_through_which_feet_swing_in_another_flight_goes_before(height):
    there = [synthetic_plan(Jump(height=up, forward=2.0)) for up in (height, -height)]
    back = synthetic_plan(Jump(forward=-4.0))
    plan = in_a_row(*there, back)
    (box,) = surroundings(ANYMAL, plan, Scenario()).blocks
    flies = plan.foot_position[plan.phase == plan.schedule.flights[-1]].reshape(-1, 3)
    through = (overhang(box, flies) > 0) & (flies[:, 2] < height)
    assert through.any() == (height == 2.0)
    assert (box.until_s < math.inf) == through.any()
    left, lands = plan.phase_start[[3, 4]]
    assert not through.any() or left <= box.until_s < lands


def test_the_board_of_hops_lies_under_the_last_landing_alone():
    plan = hops(0.1, 0.1)
    *_, board = surroundings(ANYMAL, plan, Scenario(board=0.02)).blocks
    assert board.name == "board"
    assert top(board) == pytest.approx(0.22)
    assert board.from_s == pytest.approx(MIDDLE + plan.time[48])
    assert overhang(board, stood_on(plan, 2)).min() > 0


class TestObstacles:
    @staticmethod
    def over(obstacle, **jump):
        plan = replace(synthetic_plan(Jump(**jump)), obstacle=obstacle)
        return plan, surroundings(ANYMAL, plan, Scenario())

    @staticmethod
    def ends(block):
        return block.centre - block.size / 2, block.centre + block.size / 2

    def test_a_hurdle_stands_on_the_ground_across_all_feet(self):
        plan, world = self.over(Obstacle(0.46, 0.56, 0.12), forward=0.45)
        (hurdle,) = world.blocks
        assert world.ground == 0
        assert (hurdle.name, hurdle.from_s, hurdle.until_s) == ("hurdle", 0, math.inf)
        low, high = self.ends(hurdle)
        assert [low[0], high[0]] == pytest.approx([0.46, 0.56])
        assert [low[2], high[2]] == pytest.approx([0, 0.12])
        aside = plan.foot_position[..., 1]
        assert low[1] < aside.min() < aside.max() < high[1]

    def test_a_gap_has_a_block_on_either_side(self):
        plan, world = self.over(Obstacle(0.46, 0.66, -0.3), forward=0.45)
        start, landing = world.blocks
        assert world.ground == pytest.approx(-0.3)
        assert [top(start), top(landing)] == pytest.approx([0, 0])
        for block in world.blocks:
            assert self.ends(block)[0][2] == pytest.approx(-0.3)
            assert (block.from_s, block.until_s) == (0, math.inf)
        assert self.ends(start)[1][0] == pytest.approx(0.46)
        assert self.ends(landing)[0][0] == pytest.approx(0.66)
        # Astride: all feet at the start and the hind ones at the end stand on the first block.
        feet = plan.foot_position
        assert overhang(start, np.concatenate([feet[0], feet[-1][2:]])).min() > RADIUS
        assert overhang(landing, feet[-1][:2]).min() > RADIUS
        assert overhang(landing, feet[-1][2:]).max() < 0

    @pytest.mark.parametrize("height", [0.2, -0.2])
    def test_beyond_a_gap_the_ground_may_be_higher_or_lower(self, height):
        _, world = self.over(Obstacle(0.45, 0.55, -0.5), forward=1.0, height=height)
        start, landing = world.blocks
        assert world.ground == pytest.approx(-0.5)
        assert [top(start), top(landing)] == pytest.approx([0, height])


@pytest.mark.parametrize(
    ("degrees", "forward", "lateral"),
    [(-160, 0.8, 0.7), (-100, 0.8, 0.7), (0, 0.9, 0.5), (35, 0.6, 0.8), (100, 0.6, 0.8)],
)
def test_a_box_ends_beyond_the_edge_that_each_foot_is_planned_to_cross(degrees, forward, lateral):
    """On diagonal jumps too, where feet are beside the box along both of its axes."""
    plan, found = around(twist=math.radians(degrees), forward=forward, lateral=lateral, height=0.2)
    (box,) = found.blocks
    assert box.from_s == 0
    start, goal = place_task(plan.jump, ANYMAL).places
    half = box.size[:2] / 2 * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    corners = half @ turns_about_z(box.yaw)[:2, :2].T + box.centre[:2]
    for foot, towards in zip(start.contacts, Edges.between(start, goal).towards, strict=True):
        assert towards.any()
        assert (corners @ towards).min() > foot[:2] @ towards

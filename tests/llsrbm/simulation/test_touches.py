"""Contacts in the world: of feet, on what is there, and of links that should touch nothing."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from llsrbm.request.jump import Jump
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.scenario import Scenario
from llsrbm.simulation.simulate import standing_state
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan
from tests.llsrbm.simulation.anymal_world import (
    ANYMAL,
    JOINTS,
    PLAN,
    TICK,
    lowest_points,
    springs,
    world_of,
)


def test_standing_carries_the_weight():
    world = world_of(trunk_mass_factor=1.05)
    q = standing_state(ANYMAL, PLAN)
    world.reset(q, np.zeros(18))
    for _ in range(400):
        result = world.advance(springs(world, q))
    weight = 9.81 * (ANYMAL.mass + 0.05 * ANYMAL.model.inertias[1].mass)
    assert result.contact.all()
    assert result.first_contact == pytest.approx(world.time - TICK)
    assert result.contact_force.sum(axis=0) == pytest.approx([0, 0, weight], abs=0.01 * weight)
    assert (result.contact_force[:, 2] > 0).all()
    assert result.torque_limit == pytest.approx(ANYMAL.file.limits.torque)


def test_first_contact_is_timed_to_a_step():
    """A limp fall, pitched onto the front feet: nothing turns until they touch."""
    world = world_of()
    q = standing_state(ANYMAL, PLAN)
    pitch = 0.1
    q[3:7] = [0, np.sin(pitch / 2), 0, np.cos(pitch / 2)]
    data = ANYMAL.model.createData()
    pin.framesForwardKinematics(ANYMAL.model, data, q)
    height = lowest_points(ANYMAL, data)[:, 2]
    q[2] += 0.05 - height.min()
    world.reset(q, np.zeros(18))
    found = np.full(4, np.nan)
    for _ in range(80):
        start = world.time
        result = world.advance(np.zeros(JOINTS))
        inside = result.first_contact[result.contact]
        assert (inside >= start).all()
        assert (inside < world.time).all()
        found = np.where(np.isnan(found), result.first_contact, found)
    step = 5e-4
    assert found / step == pytest.approx(np.round(found / step), abs=1e-6)
    # A step late, and the integrator's half step early.
    assert found[:2] == pytest.approx(np.sqrt(2 * 0.05 / 9.81), abs=1.01 * step)
    assert (found[2:] > found[:2].max() + 0.01).all()


def test_the_trunk_on_the_ground_is_told():
    world = world_of()
    q = ANYMAL.posture.copy()
    q[2:7] = 0.5, 1, 0, 0, 0  # on its back
    world.reset(q, np.zeros(18))
    results = [world.advance(np.zeros(JOINTS)) for _ in range(120)]
    assert not results[0].trunk_contact
    assert any(result.trunk_contact for result in results)
    assert not any(result.contact.any() for result in results)


def test_knees_on_the_ground_are_named_and_are_not_the_trunk():
    """It falls 1 cm on the ends of its thighs, the legs folded."""
    world = world_of()
    q = ANYMAL.posture.copy()
    q[2] = 0.205
    for leg in ANYMAL.legs:
        forward = np.sign(ANYMAL.posture[leg.q_index[1]])
        q[leg.q_index] = 0.0, forward * 1.0, -forward * 2.7
    world.reset(q, np.zeros(18))
    results = [world.advance(np.zeros(JOINTS)) for _ in range(24)]
    touches = [touch for result in results for touch, _ in result.touches]
    assert {touch.link for touch in touches} == {f"{leg.name}_THIGH" for leg in ANYMAL.legs}
    assert {touch.other for touch in touches} == {"the ground"}
    assert not any(result.trunk_contact for result in results)
    assert not results[0].touches


def test_legs_that_cross_touch_each_other():
    world = world_of()
    q = ANYMAL.posture.copy()
    q[2] += 1.0
    q[ANYMAL.legs[0].q_index[0]] -= 0.7
    q[ANYMAL.legs[1].q_index[0]] += 0.7
    world.reset(q, np.zeros(18))
    (touch, time), *_ = world.advance(np.zeros(JOINTS)).touches
    assert {touch.link[:2], touch.other[:2]} == {"LF", "RF"}
    assert not touch.trunk
    assert time == 0.0


@pytest.mark.parametrize(("near", "touches"), [(0.3, True), (0.6, False)])
def test_a_foot_on_a_hurdle_is_told(near, touches):
    """The front feet stand 0.37 m ahead."""
    world = world_of(replace(PLAN, obstacle=Obstacle(near, near + 0.1, 0.05)))
    q = ANYMAL.posture.copy()
    q[2] += 0.06
    world.reset(q, np.zeros(18))
    results = [world.advance(np.zeros(JOINTS)) for _ in range(60)]
    assert any(result.obstacle_contact for result in results) == touches
    assert not any(result.trunk_contact for result in results)
    assert any(result.contact.any() for result in results)


def drop_at_landing(scenario, jump):
    """Where the feet come to rest, held stiff at the landing place from mid-flight on."""
    plan = synthetic_plan(jump)
    world = world_of(plan, scenario=scenario)
    start = standing_state(ANYMAL, plan)
    q = start.copy()
    q[:3] += plan.com[-1] - plan.com[0]
    q[2] += 0.06
    world.reset(start, np.zeros(18))
    ticks = round((STAND + FLY / 2) / TICK)
    for _ in range(ticks):
        world.advance(springs(world, start))
    assert world.time == pytest.approx(STAND + FLY / 2)
    # Carried over in mid-flight, which only the simulator's own state allows.
    world._qpos[world.scene.q_order] = q
    world._qvel[:] = 0
    for _ in range(200):
        result = world.advance(springs(world, q))
    assert result.contact.all()
    data = ANYMAL.model.createData()
    pin.framesForwardKinematics(ANYMAL.model, data, world.state()[0])
    return lowest_points(ANYMAL, data)[:, 2]


@pytest.mark.parametrize(
    ("scenario", "jump", "expected"),
    [
        (Scenario(board=0.025, half_board=True), Jump(), [0.025, 0.025, 0, 0]),
        (Scenario(), Jump(height=-0.15), [-0.15] * 4),
        (Scenario(board=0.02), Jump(height=0.2, lateral=0.2), [0.22] * 4),
    ],
)
def test_feet_land_on_what_is_there(scenario, jump, expected):
    assert drop_at_landing(scenario, jump) == pytest.approx(expected, abs=2e-3)

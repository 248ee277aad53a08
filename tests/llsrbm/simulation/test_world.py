"""The world tick by tick: states, forces and momenta, against Pinocchio and by hand."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.simulate import standing_state
from llsrbm.simulation.world import Diverged, World
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.simulation.anymal_world import (
    ANYMAL,
    GRAVITY,
    JOINTS,
    PLAN,
    TICK,
    in_the_air,
    lowest_points,
    springs,
    world_of,
)
from tests.llsrbm.simulation.sliding_biped import sliding_biped

SHARED = world_of()


@settings(deadline=None)
@given(
    arrays(float, 18, elements=st.floats(-1.5, 1.5)), arrays(float, 18, elements=st.floats(-9, 9))
)
def test_mujocos_state_is_in_its_own_conventions(turn, v):
    q = pin.integrate(ANYMAL.model, ANYMAL.posture, turn)
    SHARED.reset(q, v)
    assert np.concatenate(SHARED.state()) == pytest.approx(np.concatenate([q, v]), abs=1e-12)
    R = pin.Quaternion(q[3:7]).toRotationMatrix()
    qpos, qvel = SHARED.qpos, SHARED.qvel
    assert qpos[:3] == pytest.approx(q[:3])
    assert qpos[3:7] == pytest.approx(np.roll(q[3:7], 1))
    assert qvel[:3] == pytest.approx(R @ v[:3])
    assert qvel[3:6] == pytest.approx(v[3:6])
    assert qpos[7:] == pytest.approx(q[7:][SHARED.joint_order])
    assert qvel[6:] == pytest.approx(v[6:][SHARED.joint_order])


def test_free_fall():
    world = world_of()
    q, v = in_the_air()
    v[:3] = 0.3, -0.2, 1.0
    world.reset(q, v)
    data = ANYMAL.model.createData()
    start = pin.centerOfMass(ANYMAL.model, data, q, v).copy()
    ticks = 160
    for _ in range(ticks):
        result = world.advance(np.zeros(JOINTS))
        assert not result.contact.any()
        assert np.isnan(result.first_contact).all()
        assert not result.contact_force.any()
    t = ticks * TICK
    com = pin.centerOfMass(ANYMAL.model, data, *world.state())
    assert com == pytest.approx(start + v[:3] * t + GRAVITY * t**2 / 2, abs=2e-3)
    assert data.vcom[0] == pytest.approx(v[:3] + GRAVITY * t, abs=2e-3)


def with_trunk(robot, factor):
    """Pinocchio's model of a robot whose trunk has so many times its mass and inertia."""
    model = robot.model.copy()
    trunk = model.inertias[1]
    model.inertias[1] = pin.Inertia(factor * trunk.mass, trunk.lever, factor * trunk.inertia)
    return model


class Pushed:
    """A dropped robot with random torques: momenta, CoM and feet at tick edges, forces between.

    Attributes:
        mass: kg; momentum: (T+1, 6) linear, angular; com: (T+1, 3); feet: (T+1, L, 3) lowest
        points; force: (T, L, 3); all by Pinocchio but the forces.
    """

    def __init__(self, robot, plan, factor, seed, ticks, stiffness=300.0, damping=8.0):
        rng = np.random.default_rng(seed)
        world = World(
            robot,
            surroundings(robot, plan, Scenario()),
            Disturbance(trunk_mass_factor=factor),
            TICK,
        )
        model = with_trunk(robot, factor)
        self._model, self._data, self._robot = model, model.createData(), robot
        q = standing_state(robot, plan)
        goal = q.copy()
        q[2] += 0.03
        world.reset(q, rng.normal(scale=0.2, size=model.nv))
        torque = np.zeros(len(robot.joint_names))
        rows, forces = [self._look(world)], []
        for _ in range(ticks):
            torque = 0.9 * torque + rng.normal(scale=2.0, size=len(torque))
            result = world.advance(springs(world, goal, stiffness, damping) + torque)
            assert not result.trunk_contact
            forces.append(result.contact_force)
            rows.append(self._look(world))
        self.momentum, self.com, self.feet = (np.array(row) for row in zip(*rows, strict=True))
        self.mass = sum(inertia.mass for inertia in model.inertias)
        self.force = np.array(forces)

    def _look(self, world):
        q, v = world.state()
        pin.ccrba(self._model, self._data, q, v)
        momentum, com = self._data.hg.vector.copy(), self._data.com[0].copy()
        pin.framesForwardKinematics(self._model, self._data, q)
        return momentum, com, lowest_points(self._robot, self._data)


@pytest.mark.parametrize(("factor", "seed"), [(1.0, 0), (0.92, 1)])
def test_recorded_forces_explain_the_momenta(factor, seed):
    check_momenta(Pushed(ANYMAL, PLAN, factor, seed, ticks=300))


def test_prismatic_joints(tmp_path):
    """Forces on a robot with slides; two feet hold it up for a while only."""
    robot = sliding_biped(tmp_path)
    plan = synthetic_plan(Jump(robot=str(robot.path)))
    check_momenta(Pushed(robot, plan, 1.0, 0, ticks=100, stiffness=2000.0, damping=60.0))


def check_momenta(run):
    assert (np.linalg.norm(run.force, axis=-1) > 0).any(axis=0).all()
    rate = np.diff(run.momentum, axis=0) / TICK
    linear = run.force.sum(axis=1) + run.mass * GRAVITY
    assert rms(rate[:, :3] - linear) < 0.01 * rms(rate[:, :3])
    middle = (run.com[1:] + run.com[:-1]) / 2
    arm = (run.feet[1:] + run.feet[:-1]) / 2 - middle[:, None]
    moment = np.cross(arm, run.force).sum(axis=1)
    assert rms(rate[:, 3:] - moment) < 0.01 * rms(rate[:, 3:])


def rms(values):
    return np.sqrt(np.mean(values**2))


def test_a_simulation_that_diverges_says_so(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    world = world_of(delay=0.0)
    q, v = in_the_air()
    v[8] = 1e12
    world.reset(q, v)
    with pytest.raises(Diverged, match=r"MuJoCo after 0\.0000 s: .*QVEL"):
        world.advance(np.zeros(JOINTS))
    world.reset(*in_the_air())
    world.advance(np.zeros(JOINTS))
    with pytest.raises(Diverged, match=r"MuJoCo after 0\.0025 s: .*CTRL"):
        world.advance(np.full(JOINTS, np.nan))
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")


def momenta(robot, factor, world):
    """Linear and angular momentum about the whole CoM, that CoM, and the trunk's; by Pinocchio."""
    model = with_trunk(robot, factor)
    data = model.createData()
    pin.ccrba(model, data, *world.state())
    pin.forwardKinematics(model, data, world.state()[0])
    return (
        data.hg.linear.copy(),
        data.hg.angular.copy(),
        data.com[0].copy(),
        data.oMi[1].act(model.inertias[1].lever),
    )


@pytest.mark.parametrize("name", ["anymal", "slider"])
@pytest.mark.parametrize("factor", [1.0, 1.1])
def test_an_impulse_on_the_trunk_changes_the_momenta_by_itself(name, factor):
    """In free flight, turned away from upright, against the same flight without it."""
    robot = load_robot(name)
    plan = synthetic_plan(Jump(robot=name))
    impulse, moment = np.array([3.0, -5.0, 2.0]), np.array([0.2, 0.1, -0.4])
    q = robot.posture.copy()
    q[2] += 3.0
    q[3:7] = pin.Quaternion(pin.rpy.rpyToMatrix(0.3, -0.5, 1.0)).coeffs()
    changed = []
    for pushed in (False, True):
        world = World(
            robot,
            surroundings(robot, plan, Scenario()),
            Disturbance(trunk_mass_factor=factor),
            TICK,
        )
        world.reset(q, np.zeros(robot.model.nv))
        _, _, com, trunk = momenta(robot, factor, world)
        if pushed:  # in two parts: wrenches add up
            world.push(impulse / TICK, np.zeros(3))
            world.push(np.zeros(3), moment / TICK)
        world.advance(np.zeros(len(robot.joint_names)))
        changed.append(momenta(robot, factor, world)[:2])
    (linear, angular), (pushed_linear, pushed_angular) = changed
    assert pushed_linear - linear == pytest.approx(impulse, abs=1.5e-3)
    expected = np.cross(trunk - com, impulse) + moment
    assert pushed_angular - angular == pytest.approx(expected, abs=1.5e-3)


def test_a_push_lasts_one_tick():
    world, other = world_of(), world_of()
    for each in (world, other):
        each.reset(*in_the_air())
    world.push(np.array([100.0, 0.0, 0.0]), np.zeros(3))
    for _ in range(3):
        for each in (world, other):
            each.advance(np.zeros(JOINTS))
    speeds = []
    for each in (world, other):
        data = ANYMAL.model.createData()
        pin.centerOfMass(ANYMAL.model, data, *each.state())
        speeds.append(data.vcom[0].copy())
    assert speeds[0] - speeds[1] == pytest.approx([100 * TICK / ANYMAL.mass, 0, 0], abs=1e-4)

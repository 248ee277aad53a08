"""The world tick by tick: states, forces, contacts and drives, against Pinocchio and by hand."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from llsrbm.motion.rollout import Disturbance
from llsrbm.request.jump import Jump
from llsrbm.request.obstacle import Obstacle
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.simulation.simulate import standing_state
from llsrbm.simulation.world import Diverged, Drives, World
from tests.app.synthetic_plan import FLY, STAND, synthetic_plan
from tests.llsrbm.simulation.sliding_biped import sliding_biped

TICK = 1 / 400
ANYMAL = load_robot("anymal")
GRAVITY = np.array([0.0, 0.0, -9.81])
JOINTS = len(ANYMAL.joint_names)
PLAN = synthetic_plan(Jump())


def world_of(plan=PLAN, robot=ANYMAL, scenario=None, **disturbance):
    return World(robot, plan, scenario or Scenario(), Disturbance(**disturbance), TICK)


SHARED = world_of()


def in_the_air(height=3.0):
    q = ANYMAL.posture.copy()
    q[2] += height
    return q, np.zeros(ANYMAL.model.nv)


def springs(world, goal, stiffness=300.0, damping=8.0):
    """Torques that hold a posture."""
    q, v = world.state()
    return stiffness * (goal[7:] - q[7:]) - damping * v[6:]


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


class Pushed:
    """A dropped robot with random torques: momenta, CoM and feet at tick edges, forces between.

    Attributes:
        mass: kg; momentum: (T+1, 6) linear, angular; com: (T+1, 3); feet: (T+1, L, 3) lowest
        points; force: (T, L, 3); all by Pinocchio but the forces.
    """

    def __init__(self, robot, plan, factor, seed, ticks, stiffness=300.0, damping=8.0):
        rng = np.random.default_rng(seed)
        world = World(robot, plan, Scenario(), Disturbance(trunk_mass_factor=factor), TICK)
        model = robot.model.copy()
        trunk = model.inertias[1]
        model.inertias[1] = pin.Inertia(factor * trunk.mass, trunk.lever, factor * trunk.inertia)
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


def lowest_points(robot, data):
    """(L, 3) m, of the feet's spheres."""
    return np.array(
        [
            data.oMf[leg.foot_frame_id].act(contact.centres[0]) - [0, 0, contact.radius]
            for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True)
        ]
    )


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


def test_torques_are_late_by_the_delay():
    commands = np.random.default_rng(2).normal(size=(20, JOINTS))
    late, prompt = world_of(torque_delay_ticks=1), world_of()
    late.reset(*in_the_air())
    applied = np.array([late.advance(command).torque for command in commands])
    assert applied[1:] == pytest.approx(commands[:-1], abs=1e-12)
    prompt.reset(*in_the_air())
    states = []
    for command in [commands[0], *commands[:-1]]:
        prompt.advance(command)
        states.append(prompt.state()[0])
    assert late.state()[0] == pytest.approx(states[-1], abs=1e-12)


def test_torques_act_on_the_joints_of_their_names():
    for j in range(JOINTS):
        world = world_of()
        world.reset(*in_the_air())
        torque = np.zeros(JOINTS)
        torque[j] = 1.0
        world.advance(torque)
        data = ANYMAL.model.createData()
        q, v = in_the_air()
        a = pin.aba(ANYMAL.model, data, q, v, np.concatenate([np.zeros(6), torque]))
        assert world.state()[1][6:] == pytest.approx(TICK * a[6:], abs=0.02 * TICK * abs(a).max())


@given(
    arrays(float, JOINTS, elements=st.floats(-120, 120)),
    arrays(float, JOINTS, elements=st.floats(-30, 30)),
)
def test_torques_are_limited_by_the_speed_that_they_drive(torque, speed):
    most, fastest = ANYMAL.file.limits.torque, ANYMAL.file.limits.joint_speed
    applied, limit = Drives(ANYMAL, 0).limited(torque, speed)
    left = most * np.clip((fastest - np.abs(speed)) / (0.3 * fastest), 0, 1)
    expected = np.where(torque * speed > 0, left, most)
    assert limit[torque != 0] == pytest.approx(expected[torque != 0], abs=1e-9)
    clipped = np.sign(torque) * np.minimum(np.abs(torque), expected)
    assert applied == pytest.approx(clipped, abs=1e-9)


def test_a_joint_is_not_driven_beyond_its_speed():
    """Each step counts the speed that it meets, not the tick's first."""
    world = world_of()
    world.reset(*in_the_air())
    push = np.zeros(JOINTS)
    push[2] = 100.0
    limits = ANYMAL.file.limits
    last = None
    for _ in range(8):
        speed = abs(world.state()[1][8])
        result = world.advance(push)
        after = abs(world.state()[1][8])
        assert result.torque[2] == pytest.approx(result.torque_limit[2])
        room = [
            min(1, max(0, (limits.joint_speed - w) / (0.3 * limits.joint_speed)))
            for w in (speed, after)
        ]
        assert limits.torque * room[1] - 1e-9 <= result.torque[2] <= limits.torque * room[0] + 1e-9
        last = after
    assert last < 1.02 * limits.joint_speed


def test_a_simulation_that_diverges_says_so(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    world = world_of()
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
        (Scenario(), Jump(height=0.2), [0.2] * 4),
        (Scenario(), Jump(height=-0.15), [-0.15] * 4),
        (Scenario(board=0.02), Jump(height=0.2, lateral=0.2), [0.22] * 4),
    ],
)
def test_feet_land_on_what_is_there(scenario, jump, expected):
    assert drop_at_landing(scenario, jump) == pytest.approx(expected, abs=2e-3)


def momenta(robot, factor, world):
    """Linear and angular momentum about the whole CoM, that CoM, and the trunk's; by Pinocchio."""
    model = robot.model.copy()
    trunk = model.inertias[1]
    model.inertias[1] = pin.Inertia(factor * trunk.mass, trunk.lever, factor * trunk.inertia)
    data = model.createData()
    pin.ccrba(model, data, *world.state())
    pin.forwardKinematics(model, data, world.state()[0])
    return (
        data.hg.linear.copy(),
        data.hg.angular.copy(),
        data.com[0].copy(),
        data.oMi[1].act(trunk.lever),
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
        world = World(robot, plan, Scenario(), Disturbance(trunk_mass_factor=factor), TICK)
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

"""Resampling against integration, SciPy's slerp and the geometry it promises."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation, Slerp

from llsrbm.errors import InputError
from llsrbm.motion.sampling import evenly, resample, with_events
from tests.llsrbm.synthetic import FLIGHT, GRAVITY, TWO_HOPS, TWO_HOPS_DURATIONS, synthetic_plan

CONTINUOUS = (
    "com", "com_velocity", "base_quat", "base_position", "angular_velocity", "linear_momentum",
    "angular_momentum", "inertia", "foot_position", "foot_quat", "contact_point", "leg_com",
    "joint_position", "joint_velocity",
)  # fmt: skip


@pytest.fixture(scope="module")
def plan():
    return synthetic_plan()


def random_times(plan, count=200):
    return np.sort(np.random.default_rng(1).uniform(plan.time[0], plan.time[-1], count))


def scipy_rotation(quat):
    return Rotation.from_quat(np.roll(quat, -1, axis=-1))


def test_knots_are_reproduced_exactly(plan):
    motion = resample(plan, plan.time)
    held = ("phase", "contact_force", "joint_torque", "joint_torque_limit")
    for name in (*CONTINUOUS, *held):
        got, expected = getattr(motion, name), getattr(plan, name)
        if name.endswith("quat"):
            np.testing.assert_allclose(got, expected, atol=1e-15)
        else:
            np.testing.assert_array_equal(got, expected, err_msg=name)
    assert motion.joint_names == plan.joint_names


def test_momenta_agree_with_an_integrator(plan):
    """Newton and Euler with the plan's forces, integrated numerically from each knot."""
    mass = plan.base_mass + plan.leg_mass.sum()
    for k in (0, 5, 15, 20, 31, 40, 47):
        times = np.linspace(plan.time[k], plan.time[k + 1], 7)[1:-1]
        force, points = plan.contact_force[k], plan.contact_point[k]

        def rates(_t, state, force=force, points=points):
            r, v = state[:3], state[3:6]
            moment = np.cross(points - r, force).sum(axis=0)
            return np.concatenate([v, force.sum(axis=0) / mass + GRAVITY, moment])

        start = np.concatenate([plan.com[k], plan.com_velocity[k], plan.angular_momentum[k]])
        truth = solve_ivp(
            rates, plan.time[[k, k + 1]], start, t_eval=times, rtol=1e-10, atol=1e-12
        ).y.T
        motion = resample(plan, times)
        np.testing.assert_allclose(motion.com, truth[:, :3], atol=1e-9)
        np.testing.assert_allclose(motion.com_velocity, truth[:, 3:6], atol=1e-9)
        np.testing.assert_allclose(motion.angular_momentum, truth[:, 6:], atol=1e-8)
        np.testing.assert_allclose(motion.linear_momentum, mass * truth[:, 3:6], atol=1e-8)


@settings(max_examples=10, deadline=None)
@given(twist=st.floats(-np.pi, np.pi), seed=st.integers(0, 1000))
def test_attitude_is_scipys_slerp_whatever_the_signs(twist, seed):
    plan = synthetic_plan(twist=twist)
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], len(plan.time))
    times = random_times(plan)
    motion = resample(replace(plan, base_quat=plan.base_quat * sign[:, None]), times)
    truth = Slerp(plan.time, scipy_rotation(plan.base_quat))(times)
    error = (scipy_rotation(motion.base_quat) * truth.inv()).magnitude()
    assert error.max() < 1e-7
    np.testing.assert_allclose(np.linalg.norm(motion.base_quat, axis=1), 1, atol=1e-12)
    assert (np.sum(motion.base_quat[1:] * motion.base_quat[:-1], axis=1) > 0).all()


def test_continuous_across_knots_and_phases(plan):
    step = 1e-7
    inner = plan.time[1:-1]
    before, after = resample(plan, inner - step), resample(plan, inner + step)
    for name in CONTINUOUS:
        jump = np.abs(getattr(after, name) - getattr(before, name)).max()
        assert jump < 1e-4, name


def test_feet_in_flight_are_straight_seen_from_the_com_in_base_axes(plan):
    """The synthetic plan's feet are one straight line over the whole flight, by construction."""
    start, end = plan.phase_start[1:3]
    times = np.linspace(start, end, 57)
    motion = resample(plan, times)
    R = scipy_rotation(motion.base_quat).as_matrix()
    seen = np.einsum("kji,klj->kli", R, motion.foot_position - motion.com[:, None])
    straight = seen[0] + np.linspace(0, 1, 57)[:, None, None] * (seen[-1] - seen[0])
    np.testing.assert_allclose(seen, straight, atol=1e-12)
    offset = np.einsum("kji,kj->ki", R, motion.base_position - motion.com)
    np.testing.assert_allclose(offset, np.tile([0.01, 0, 0.02], (57, 1)), atol=1e-12)


def test_a_foot_stands_or_flies_on_its_own():
    """The hind feet still push when the front feet have left, and land after them."""
    plan = synthetic_plan(schedule=TWO_HOPS, durations=TWO_HOPS_DURATIONS)
    times = np.sort(np.random.default_rng(4).uniform(0, plan.duration, 2000))
    motion = resample(plan, times)
    starts = plan.phase_start
    front_flies = [(starts[1], starts[3]), (starts[4], starts[5])]
    hind_flies = [(starts[2], starts[3]), (starts[4], starts[6])]
    R = scipy_rotation(motion.base_quat).as_matrix()
    seen = np.einsum("kji,klj->kli", R, motion.foot_position - motion.com[:, None])
    for leg, flights in ((0, front_flies), (3, hind_flies)):
        stands = np.ones(len(times), dtype=bool)
        for start, end in flights:
            flying = (times >= start) & (times < end)
            stands &= ~flying
            # One straight line in base axes, by construction.
            share = ((times[flying] - start) / (end - start))[:, None]
            at_ends = resample(plan, [start, end])
            turned = scipy_rotation(at_ends.base_quat).as_matrix()
            ends = at_ends.foot_position[:, leg] - at_ends.com
            first, last = np.einsum("kji,kj->ki", turned, ends)
            straight = first + share * (last - first)
            np.testing.assert_allclose(seen[flying, leg], straight, atol=1e-12)
        np.testing.assert_array_equal(motion.contact[:, leg], stands)
        still = np.diff(motion.foot_position[:, leg], axis=0)[stands[1:] & stands[:-1]]
        np.testing.assert_allclose(still, 0.0, atol=1e-12)


def test_forces_are_held_and_zero_in_flight(plan):
    times = random_times(plan)
    motion = resample(plan, times)
    for t, force, phase in zip(times, motion.contact_force, motion.phase, strict=True):
        k = max(i for i in range(len(plan.time)) if plan.time[i] <= t)
        np.testing.assert_array_equal(force, plan.contact_force[k])
        assert phase == plan.phase[k]
    knots = np.searchsorted(plan.time, times, side="right") - 1
    np.testing.assert_array_equal(motion.joint_torque, plan.joint_torque[knots])
    np.testing.assert_array_equal(motion.joint_torque_limit, plan.joint_torque_limit[knots])
    assert (motion.contact_force[motion.phase == FLIGHT] == 0).all()


def test_inertia_stays_an_inertia(plan):
    motion = resample(plan, random_times(plan))
    np.testing.assert_allclose(motion.inertia, np.swapaxes(motion.inertia, 1, 2), atol=1e-12)
    moments = np.linalg.eigvalsh(motion.inertia)
    assert (moments > 0).all()
    assert (moments[:, 0] + moments[:, 1] >= moments[:, 2]).all()
    # In base axes every entry lies between those of the two knots, whatever the twist.
    in_base = [
        np.einsum("kai,kab,kbj->kij", R, m.inertia, R)
        for m in (motion, plan)
        for R in [scipy_rotation(m.base_quat).as_matrix()]
    ]
    knot = np.searchsorted(plan.time, motion.time, side="right") - 1
    ends = np.stack([in_base[1][knot], in_base[1][knot + 1]])
    assert (in_base[0] > ends.min(axis=0) - 1e-9).all()
    assert (in_base[0] < ends.max(axis=0) + 1e-9).all()


def test_joint_speed_is_the_derivative_of_the_position(plan):
    times, step = random_times(plan)[5:-5], 1e-6
    ahead, behind = resample(plan, times + step), resample(plan, times - step)
    slope = (ahead.joint_position - behind.joint_position) / (2 * step)
    np.testing.assert_allclose(resample(plan, times).joint_velocity, slope, atol=1e-4)


def test_still_before_the_start_and_after_the_end(plan):
    motion = resample(plan, [-1.0, plan.time[-1] + 1])
    for i, knot in ((0, 0), (1, -1)):
        np.testing.assert_array_equal(motion.com[i], plan.com[knot])
        np.testing.assert_array_equal(motion.joint_position[i], plan.joint_position[knot])
        for name in ("com_velocity", "angular_velocity", "joint_velocity", "linear_momentum"):
            assert (getattr(motion, name)[i] == 0).all()
    np.testing.assert_array_equal(motion.time, [-1.0, plan.time[-1] + 1])


@pytest.mark.parametrize("times", [[np.nan], [[0.0, 1.0]]])
def test_times_that_are_no_list_of_numbers(plan, times):
    with pytest.raises(InputError, match="list of finite numbers"):
        resample(plan, times)


@given(fps=st.floats(0.5, 1000), durations=st.tuples(*[st.floats(0.05, 1)] * 3))
@settings(max_examples=30, deadline=None)
def test_instants_with_events(fps, durations):
    plan = synthetic_plan(durations=durations, intervals=2)
    times = with_events(plan, fps)
    assert times[0] == plan.time[0]
    assert times[-1] == plan.time[-1]
    steps = np.diff(times)
    assert (steps > 0).all()
    assert steps.max() <= 1 / fps + 1e-8
    assert set(plan.phase_start) <= set(times)


@given(fps=st.floats(0.5, 1000), pad=st.floats(0, 3))
@settings(max_examples=30, deadline=None)
def test_even_instants_hold_the_whole_motion(fps, pad):
    plan = synthetic_plan(intervals=2)
    times = evenly(plan, fps, pad)
    np.testing.assert_allclose(np.diff(times), 1 / fps, atol=1e-9)
    assert times[0] <= plan.time[0] - pad + 1e-8
    assert times[-1] >= plan.time[-1] + pad - 1e-6
    # No frame more than needed.
    assert times[0] > plan.time[0] - pad - 1 / fps
    assert times[-1] < plan.time[-1] + pad + 2 / fps
    np.testing.assert_allclose(np.min(np.abs(times - plan.time[0])), 0, atol=1e-9)


@pytest.mark.parametrize("pad", [-0.1, np.nan, np.inf, 1e4])
def test_pads_that_make_no_sense(plan, pad):
    with pytest.raises(InputError, match="pad: expected 0 to 60 s"):
        evenly(plan, 50, pad)


@pytest.mark.parametrize("fps", [0, -1, np.nan, np.inf, 1e9])
@pytest.mark.parametrize("instants", [evenly, with_events])
def test_frame_rates_that_make_no_sense(plan, instants, fps):
    with pytest.raises(InputError, match="0 < fps <= 10000"):
        instants(plan, fps)

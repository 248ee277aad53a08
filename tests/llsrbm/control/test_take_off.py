"""Feedback of take-offs, against forces at the plan's contacts and an integrator of its own."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from llsrbm.control import take_off
from llsrbm.control.reference import Reference
from llsrbm.control.take_off import TakeOff
from llsrbm.mechanics import GRAVITY
from llsrbm.motion.sampling import sampled
from llsrbm.robots import load_robot
from tests.llsrbm.planning.solved import solved

MASS = load_robot("anymal").mass
TICK = 1 / 400
LEFT = 0.3  # s until lift-off
ERRORS = (
    {"com_velocity": [0.03, 0.0, 0.0]},
    {"com": [0.01, 0.004, 0.0]},
    {"angular_momentum": [0.0, 0.3, 0.0]},
)


@pytest.fixture(scope="module")
def plan():
    """All feet push, then the hind ones alone."""
    return solved("llsrbm-plus", "rear-last").plan


@pytest.fixture(scope="module")
def reference(plan):
    return Reference(plan, MASS * GRAVITY)


def body_of(target, **errors):
    """A body at a target but for some errors."""
    names = ("com", "com_velocity", "angular_momentum", "R_world_base")
    state = {name: getattr(target, name) + np.asarray(errors.get(name, 0.0)) for name in names}
    return SimpleNamespace(**state)


def contacts(plan, time):
    """Of the contacts that push in a tick: arms from the CoM, and forces."""
    at = sampled(plan, [time + TICK / 2], ("com", "contact_point", "contact_force"))
    arms, force = at["contact_point"][0] - at["com"][0], at["contact_force"][0]
    loaded = force[:, 2] > 1e-3
    return arms[loaded], force[loaded]


def changes(plan, target, body, wanted, time):
    """(C, 3) N that make the corrected rates, and by how much they miss them."""
    arms, force = contacts(plan, time)
    moved = body.com - target.com
    total = np.tile(np.eye(3), len(arms)) / MASS
    rows = np.vstack([total, np.hstack([np.cross(arm, np.eye(3)).T for arm in arms])])
    acceleration = wanted.com_acceleration - target.com_acceleration
    rate = wanted.angular_momentum_rate - target.angular_momentum_rate
    asked = np.concatenate([acceleration, rate + np.cross(moved, force.sum(axis=0))])
    found, *_ = np.linalg.lstsq(rows, asked, rcond=None)
    return found.reshape(-1, 3), np.abs(rows @ found - asked).max()


@pytest.mark.parametrize("errors", ERRORS, ids=str)
def test_what_it_asks_for_the_feet_can_give(plan, reference, errors):
    feedback = TakeOff(plan, MASS, TICK)
    for time in np.round(np.linspace(0.1, plan.lift_off - 0.02, 7) / TICK) * TICK:
        target = reference.at(time)
        body = body_of(target, **errors)
        wanted = feedback.corrected(target, body, time)
        forces, miss = changes(plan, target, body, wanted, time)
        assert miss < 1e-6
        assert abs(forces[:, 2].sum()) < 1e-6 * MASS * GRAVITY
        np.testing.assert_array_equal(wanted.com[:2], body.com[:2])
        assert wanted.com[2] == target.com[2]


def landing(plan, com, velocity, turned, momentum):
    """How far off, m and rad, a flight with errors at lift-off lands."""
    T = plan.touchdown - plan.lift_off
    inside = (plan.time >= plan.lift_off - 1e-9) & (plan.time <= plan.touchdown + 1e-9)
    spin = np.linalg.inv(plan.inertia[inside]).mean(axis=0) @ momentum
    return np.linalg.norm((com + T * velocity)[:2]), np.linalg.norm(turned + T * spin)


def flown(plan, reference, feedback, **errors):
    """The same of errors before lift-off: the plan's forces, with or without feedback."""
    start = round((plan.lift_off - LEFT) / TICK)
    zero = {name: np.zeros(3) for name in ("com", "com_velocity", "angular_momentum")}
    e = zero | {name: np.array(value) for name, value in errors.items()}
    turned = np.zeros(3)
    for tick in range(start, int(plan.lift_off / TICK)):
        time = tick * TICK
        target = reference.at(time)
        body = body_of(target, **e)
        body.R_world_base = Rotation.from_rotvec(turned).as_matrix() @ target.R_world_base
        arms, force = contacts(plan, time)
        change = np.zeros_like(force)
        if feedback is not None:
            wanted = feedback.corrected(target, body, time)
            change, _ = changes(plan, target, body, wanted, time)
        own = np.cross(arms, force).sum(axis=0)
        real = np.cross(arms - e["com"], force + change).sum(axis=0)
        inertia = sampled(plan, [time], ("inertia",))["inertia"][0]
        e["com"] = e["com"] + TICK * e["com_velocity"]
        e["com_velocity"] = e["com_velocity"] + TICK * change.sum(axis=0) / MASS
        turned = turned + TICK * np.linalg.solve(inertia, e["angular_momentum"])
        e["angular_momentum"] = e["angular_momentum"] + TICK * (real - own)
    return landing(plan, e["com"], e["com_velocity"], turned, e["angular_momentum"])


@pytest.mark.parametrize("errors", ERRORS, ids=str)
def test_errors_in_a_take_off_land_less_far_off(plan, reference, errors):
    far, turned = flown(plan, reference, None, **errors)
    nearer, straighter = flown(plan, reference, TakeOff(plan, MASS, TICK), **errors)
    # As it weighs them: 2 cm as much as 0.05 rad.
    assert np.hypot(nearer / 0.02, straighter / 0.05) < 0.5 * np.hypot(far / 0.02, turned / 0.05)


def test_landing_and_flight_are_left_alone(plan, reference):
    feedback = TakeOff(plan, MASS, TICK)
    for time in (plan.lift_off + 0.01, plan.touchdown + 0.1):
        target = reference.at(time)
        assert feedback.corrected(target, body_of(target, com=0.1), time) is target


SHAPE = np.diag([0.17, 0.6, 0.68])  # kg m2, a Go2's in a flip: it turns about the middle one
SPIN = np.array([0.0, -4.3, 0.0])  # kg m2/s
FLIGHT = 0.5  # s


def legs_stretched(time):
    return SHAPE * (1 + 0.4 * time)


def tumbled(R, momentum, steps=500):
    """(steps + 1) attitudes in a flight with this angular momentum, by the midpoint rule."""
    dt, found = FLIGHT / steps, [R]

    def rate(R, time):
        return R.apply(np.linalg.solve(legs_stretched(time), R.inv().apply(momentum)))

    for k in range(steps):
        half = Rotation.from_rotvec(dt / 2 * rate(found[-1], k * dt)) * found[-1]
        found.append(Rotation.from_rotvec(dt * rate(half, (k + 0.5) * dt)) * found[-1])
    return found


def test_errors_in_the_turn_grow_in_flight_as_those_of_a_body_that_tumbles(monkeypatch):
    """A roll at lift-off is several at touchdown; seen by an integrator of its own."""
    attitudes = tumbled(Rotation.identity(), SPIN)
    between = Slerp(np.linspace(0.0, FLIGHT, len(attitudes)), Rotation.concatenate(attitudes))

    def flown(_, times, names):
        R = between(times).as_matrix()
        inertia = np.array([legs_stretched(time) for time in times])
        return {
            "inertia": R @ inertia @ np.swapaxes(R, 1, 2),
            "angular_momentum": np.tile(SPIN, (len(times), 1)),
        }

    monkeypatch.setattr(take_off, "sampled", flown)
    plan = SimpleNamespace(phase_start=np.array([0.0, FLIGHT]))
    by_turn, by_momentum = take_off.turn_in_flight(plan, 0)
    turn, gained = np.array([4e-4, 2e-4, -2e-4]), np.array([2e-3, -4e-3, 3e-3])
    off = tumbled(Rotation.from_rotvec(turn), SPIN + gained)[-1]
    real = (off * attitudes[-1].inv()).as_rotvec()
    assert np.linalg.norm(by_turn @ [0.0, 0.0, 1.0]) > 2.0
    found = by_turn @ turn + by_momentum @ gained
    np.testing.assert_allclose(found, real, atol=0.03 * np.linalg.norm(real))

"""A rollout made by hand to fit a plan: one jump in closed form at 400 Hz, no simulator, no QP."""

from dataclasses import replace

import numpy as np
from scipy.interpolate import BPoly

from llsrbm.motion.outcome import Outcome
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Disturbance, Mode, Rollout
from llsrbm.motion.sampling import resample
from llsrbm.request.scenario import Scenario
from tests.llsrbm.synthetic import GRAVITY, quat_about_z, rotation_about_z, synthetic_plan

RATE = 400.0  # Hz
STANDING = 1.0  # s, after the plan's end
EARLY_TICKS, LATENCY_TICKS = 4, 2  # touchdown before the plan's, and until it is detected
FORCE_PHASE = 0.2  # s
TORQUE_LIMIT = 40.0
THRESHOLD = 0.08
RISE = 0.1  # m, CoM at lift-off and touchdown above standing
YAW_SHORTFALL = 0.05  # rad of yaw missing at touchdown


def synthetic_rollout(
    plan: Plan | None = None, *, fell_at: float | None = None, seed: int | None = None
) -> Rollout:
    """What a robot might have made of a plan.

    The CoM and the yaw are quintics in stance and ballistic in flight, momenta are theirs, and the
    recorded forces are those that change them so: forces exactly, their moments to the order of a
    tick. All feet touch at once, four ticks early, seen two ticks later. Joints are the plan's, so
    their forward kinematics misses `foot_position`.

    Args:
        plan: default: `tests.llsrbm.synthetic.synthetic_plan`. Names of joints begin with their
            leg's; the rollout has them leg after leg, as MuJoCo does, whatever the plan's order.
        fell_at: s; the rollout ends there with status "fell".
        seed: of the disturbance that it claims to have had.
    """
    plan = plan or synthetic_plan()
    legs = list(plan.robot_parameters["legs"])
    order = sorted(
        range(len(plan.joint_names)),
        key=lambda j: next(i for i, leg in enumerate(legs) if plan.joint_names[j].startswith(leg)),
    )
    dt = 1 / RATE
    ticks = np.arange(round((plan.duration + STANDING) * RATE) + 1)
    lift_off, planned, landed = np.round(plan.phase_start[1:] * RATE).astype(int)
    touchdown = planned - EARLY_TICKS
    detected = touchdown + LATENCY_TICKS

    arrays = _arrays(plan, order, ticks, (lift_off, touchdown, detected, landed))
    if fell_at is not None:
        arrays = {key: values[ticks * dt <= fell_at] for key, values in arrays.items()}
    return Rollout(
        jump=plan.jump,
        robot_parameters=plan.robot_parameters,
        scenario=Scenario(seed=seed),
        disturbance=Disturbance()
        if seed is None
        else Disturbance(1.05, 0.7, 0.01, 1, 1.12, 1.4, 0.01, 0.02),
        outcome=_outcome(plan, len(legs), touchdown * dt, detected * dt, fell_at),
        joint_names=tuple(plan.joint_names[j] for j in order),
        detection_threshold=THRESHOLD,
        plan=plan,
        control_parameters={
            "control": {"rate": RATE, "force_phase": FORCE_PHASE},
            "uncertainty": {"trunk_mass": 0.1},
        },
        **arrays,
    )


def _arrays(plan, order, ticks, instants):
    """Name -> array of the rollout; `instants`: (ticks) of lift-off, touchdown, its detection and
    the end of the landing.
    """
    lift_off, touchdown, detected, landed = instants
    mass, dt, end = plan.robot_parameters["mass"], 1 / RATE, plan.duration + STANDING
    com, velocity, _ = _com(plan, lift_off * dt, touchdown * dt, landed * dt, end)(ticks * dt)
    yaw, yaw_rate, _ = _yaw(plan, lift_off * dt, touchdown * dt, landed * dt, end)(ticks * dt)
    yaw, yaw_rate = yaw[:, 0], yaw_rate[:, 0]
    omega = yaw_rate[:, None] * np.array([0.0, 0.0, 1.0])
    R = rotation_about_z(yaw)
    inertia = np.einsum("kia,ab,kjb->kij", R, plan.inertia[0], R)
    momentum, spin = mass * velocity, np.einsum("kij,kj->ki", inertia, omega)
    arm = np.einsum("kij,j->ki", R, plan.base_position[0] - plan.com[0])

    flying = (ticks >= lift_off) & (ticks < touchdown)
    share = np.clip((ticks - lift_off) / (touchdown - lift_off), 0, 1)[:, None, None]
    foot = (1 - share) * plan.foot_position[0] + share * plan.foot_position[-1]
    foot[..., 2] += 0.32 * share[..., 0] * (1 - share[..., 0])
    force = _forces(momentum, spin, com, foot, flying, mass, dt)

    reference, joints = _of_joints(plan, order, ticks)
    signal, mode = _signals(flying, touchdown, detected)
    phase = np.select([ticks < lift_off, ticks < detected], [0, 1], 2)
    return {
        "time": ticks * dt,
        "qpos": np.hstack([com + arm, quat_about_z(yaw), joints["joint_position"]]),
        "qvel": np.hstack([velocity + np.cross(omega, arm), omega, joints["joint_velocity"]]),
        "torque": joints["torque"],
        "torque_limit": joints["torque_limit"],
        "com": com,
        "base_quat": quat_about_z(yaw),
        "base_position": com + arm,
        "linear_momentum": momentum,
        "angular_momentum": spin,
        "inertia": inertia,
        "foot_position": foot,
        "contact": np.repeat(~flying[:, None], len(plan.leg_mass), axis=1).astype(np.int64),
        "contact_force": force,
        "average_spatial_velocity_norm": np.hypot(np.linalg.norm(velocity, axis=1), yaw_rate),
        "detection_signal": signal,
        "mode": mode,
        "phase": phase.astype(np.int64),
        **{
            f"reference_{name}": getattr(reference, name)
            for name in ("com", "base_quat", "foot_position", "angular_momentum")
        },
    }


def _signals(flying, touchdown, detected):
    """The detector's signal, the controller's mode and its phase, (T,) each."""
    ticks = np.arange(len(flying))
    signal = np.zeros(len(ticks))
    signal[flying] = 0.01 * (1 + np.sin(ticks[flying]))
    signal[touchdown : detected + 1] = 0.05 * (1 + ticks[touchdown : detected + 1] - touchdown)
    lasts = (ticks >= detected) & (ticks / RATE < detected / RATE + FORCE_PHASE)
    return signal, np.where(lasts, Mode.FORCE, 0).astype(np.int64)


def _of_joints(plan, order, ticks):
    """The plan at the ticks, and name -> (T, J) array of what the joints do."""
    at = resample(plan, ticks / RATE)
    speed = at.joint_velocity[:, order]
    return at, {
        "joint_position": at.joint_position[:, order],
        "joint_velocity": speed,
        "torque": 30 * np.sin(ticks[:, None] / RATE * 9 + np.arange(len(order))),
        "torque_limit": TORQUE_LIMIT * np.clip(2 - np.abs(speed) / 7.5, 0.2, 1.0),
    }


def followed(plan: Plan) -> Rollout:
    """A rollout of a plan of any schedule whose robot is where the plan has it.

    A foot touches four ticks before it should, which the controller sees two ticks later when the
    robot flies. The other arrays are those of another jump of the same length.
    """
    start, end = 0.3 * plan.duration, 0.7 * plan.duration
    other = synthetic_rollout(synthetic_plan(durations=(start, end - start, start)))
    sampled = resample(plan, other.time)
    early = resample(plan, other.time + EARLY_TICKS / RATE)
    late = resample(plan, other.time + (EARLY_TICKS - LATENCY_TICKS) / RATE)
    flying = np.isin(sampled.phase, plan.schedule.flights)
    return replace(
        other,
        jump=plan.jump,
        plan=plan,
        com=sampled.com,
        base_quat=sampled.base_quat,
        base_position=sampled.base_position,
        foot_position=sampled.foot_position,
        contact=(sampled.contact | early.contact).astype(np.int64),
        phase=np.where(flying, late.phase, sampled.phase),
    )


def _through(breaks, knots):
    """Quintics through (value, slope, second slope) at each break: t -> those three, (T, n)."""
    curve = BPoly.from_derivatives(breaks, knots, extrapolate=True)
    return lambda t: (curve(t), curve(t, 1), curve(t, 2))


def _com(plan, lift_off, touchdown, landed, end):
    still = np.zeros(3)
    flight = touchdown - lift_off
    start, goal = plan.com[0], plan.com[-1]
    leave = start + 0.2 * (goal - start) * [1, 1, 0] + [0, 0, RISE]
    arrive = goal - 0.2 * (goal - start) * [1, 1, 0] + [0, 0, RISE]
    up = (arrive - leave) / flight - GRAVITY * flight / 2
    return _through(
        [0, lift_off, touchdown, landed, end],
        [
            [start, still, still],
            [leave, up, GRAVITY],
            [arrive, up + GRAVITY * flight, GRAVITY],
            [goal, still, still],
            [goal, still, still],
        ],
    )


def _yaw(plan, lift_off, touchdown, landed, end):
    """Even in flight, a little short of where it should be, put right in stance."""
    even = plan.jump.twist / (lift_off / 2 + (touchdown - lift_off) + (landed - touchdown) / 2)
    leave = even * lift_off / 2
    arrive = leave + even * (touchdown - lift_off) - np.sign(plan.jump.twist) * YAW_SHORTFALL
    rate = (arrive - leave) / (touchdown - lift_off)
    rows = [(0, 0), (leave, rate), (arrive, rate), (plan.jump.twist, 0), (plan.jump.twist, 0)]
    return _through(
        [0, lift_off, touchdown, landed, end], [[[value], [slope], [0]] for value, slope in rows]
    )


def _forces(momentum, spin, com, foot, flying, mass, dt):
    """(T, L, 3): the smallest forces at the feet that change both momenta so, tick by tick."""
    count, legs = foot.shape[:2]
    force = np.zeros((count, legs, 3))
    total = np.diff(momentum, axis=0) / dt - mass * GRAVITY
    moment = np.diff(spin, axis=0) / dt
    for k in range(count - 1):
        if flying[k]:
            continue
        arms = foot[k] - (com[k] + com[k + 1]) / 2
        grasp = np.zeros((6, 3 * legs))
        for i, (x, y, z) in enumerate(arms):
            grasp[:3, 3 * i : 3 * i + 3] = np.eye(3)
            grasp[3:, 3 * i : 3 * i + 3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
        wrench = np.concatenate([total[k], moment[k]])
        force[k] = np.linalg.lstsq(grasp, wrench, rcond=None)[0].reshape(legs, 3)
    force[-1] = force[-2]
    return force


def _outcome(plan, legs, touchdown, detected, fell_at):
    fell = fell_at is not None
    return Outcome(
        status="fell" if fell else "landed",
        reason=f"the base touched the ground at {fell_at:.2f} s" if fell else "",
        fell_at_s=fell_at,
        strict=not fell,
        final_yaw_error=0.9 if fell else 0.001,
        final_position_error=0.3 if fell else 0.004,
        final_tilt=1.2 if fell else 0.002,
        final_speed=3.0 if fell else 0.01,
        touchdown_planned_s=float(plan.phase_start[2]),
        touchdown_true_s=touchdown,
        touchdown_detected_s=detected,
        foot_touchdown_s=(touchdown,) * legs,
        false_touchdowns=0,
        yaw_error_at_touchdown=-YAW_SHORTFALL,
        foot_error_at_touchdown=0.012,
        foot_error=0.013,
        peak_tilt=0.05,
        second_flight_s=0.0,
        trunk_touched=fell,
        peak_torque_ratio=0.75,
        peak_speed_ratio=0.9,
        takeoff_joint_speed=12.6,
        saturated_fraction=0.004,
        unsolved_ticks=0,
        tick_median_s=2.1e-4,
        tick_p99_s=4.8e-4,
        real_time_factor=4.2,
        control_rate_hz=RATE,
        landing_strategy="scaled",
        recovered=not fell,
    )

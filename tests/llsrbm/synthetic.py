"""A plan made by hand: physics in closed form, no planner, no URDF."""

from itertools import pairwise
from typing import Any

import numpy as np

from llsrbm.motion.plan import Plan
from llsrbm.motion.solve_report import SolveReport, Violation
from llsrbm.request.jump import Jump
from llsrbm.request.schedule import Phase, Schedule, together

GRAVITY = np.array([0.0, 0.0, -9.81])
LEGS = ("LF", "RF", "LH", "RH")
JOINT_NAMES = tuple(f"{leg}_{part}" for leg in LEGS for part in "ABC")
HALF_STANCE = np.array([[0.35, 0.2, 0], [0.35, -0.2, 0], [-0.35, 0.2, 0], [-0.35, -0.2, 0]])
TRUNK_INERTIA = np.diag([0.9, 2.0, 2.2])
MASS = 30.0  # kg
LEG_MASS = 2.0  # kg, a point half way down the leg


TAKE_OFF, FLIGHT, LANDING = range(3)  # phases of the schedule `together`

# The front feet leave first; the landing of one jump is the take-off of the next.
TWO_HOPS = Schedule(
    LEGS,
    (
        Phase("take-off", LEGS, "takeoff"),
        Phase("rear push", ("LH", "RH"), (0.05, 0.4)),
        Phase("flight", (), "flight"),
        Phase("rebound", LEGS, (0.3, 1.0), place=1),
        Phase("flight", (), "flight", place=1),
        Phase("front first", ("LF", "RF"), (0.05, 0.4), place=2),
        Phase("landing", LEGS, "landing", place=2),
    ),
)
TWO_HOPS_DURATIONS = (0.5, 0.1, 0.3, 0.4, 0.35, 0.15, 0.6)


# Of every such plan: its robot, and what is told of how it was made.
_ABOUT: dict[str, Any] = {
    "robot_parameters": {
        "name": "anymal",
        "legs": {leg: {"foot": f"{leg}_FOOT"} for leg in LEGS},
        "mass": MASS,
    },
    "report": SolveReport("solved", "fatrop", 14, 1, 0.08, 0.1, 0.0, 12.5),
    "violations": {
        "friction": Violation(2e-5, "N", "landing", 1.1),
        "reach": Violation(0.0, "m", "take-off", 0.0),
    },
}


def quat_about_z(angle: Any) -> np.ndarray:
    angle = np.asarray(angle)
    zero = np.zeros_like(angle)
    return np.stack([np.cos(angle / 2), zero, zero, np.sin(angle / 2)], axis=-1)


def rotation_about_z(angle: Any) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros((*np.shape(angle), 3, 3))
    R[..., 0, 0], R[..., 0, 1], R[..., 1, 0], R[..., 1, 1], R[..., 2, 2] = c, -s, s, c, 1
    return R


def synthetic_plan(
    twist: float = 1.57,
    forward: float = 0.3,
    height: float = 0.0,
    intervals: int = 16,
    durations: tuple[float, ...] = (0.5, 0.4, 0.6),
    quat_sign: float = 1.0,
    schedule: Schedule | None = None,
) -> Plan:
    """A jump of a 30 kg quadruped with `intervals` a phase; without a schedule, `together`.

    The CoM and the angular momentum obey piecewise-constant contact forces exactly; the base
    turns about z only and feet move on straight lines in the turning frame, as in a planner's
    plan. Nothing is optimal and the forces may pull.
    """
    edges = np.concatenate([[0.0], np.cumsum(durations)])
    time = np.concatenate(
        [np.linspace(a, b, intervals, endpoint=False) for a, b in pairwise(edges)] + [edges[-1:]]
    )
    schedule = schedule or together(LEGS)
    phase = np.append(np.repeat(np.arange(len(schedule)), intervals), len(schedule) - 1)
    stands = schedule.stands[phase]
    knots = len(time)

    yaw = twist * (time / edges[-1]) ** 2 * (3 - 2 * time / edges[-1])
    foot = _footholds(schedule, twist, [forward, 0, height])[phase]
    force = _forces(stands, MASS)
    com, velocity, momentum = _motion(time, foot, force, MASS)

    R = rotation_about_z(yaw)
    in_base = np.einsum("kji,klj->kli", R, foot - com[:, None])
    _swing_straight(in_base, time, stands)
    foot = com[:, None] + np.einsum("kij,klj->kli", R, in_base)

    leg_com_in_base = 0.5 * in_base
    yaw_rate = twist / edges[-1] * 6 * (time / edges[-1]) * (1 - time / edges[-1])
    return Plan(
        jump=Jump(twist=twist, forward=forward, height=height),
        **_ABOUT,
        time=time,
        phase=phase.astype(np.int64),
        com=com,
        com_velocity=velocity,
        base_quat=quat_sign * quat_about_z(yaw),
        base_position=com + np.einsum("kij,j->ki", R, [0.01, 0.0, 0.02]),
        angular_velocity=yaw_rate[:, None] * np.array([0.0, 0.0, 1.0]),
        linear_momentum=MASS * velocity,
        angular_momentum=momentum,
        inertia=np.einsum("kia,kab,kjb->kij", R, _inertia(leg_com_in_base), R),
        foot_position=foot,
        foot_quat=np.tile([1.0, 0, 0, 0], (knots, len(LEGS), 1)),
        contact_point=foot.copy(),
        contact_force=force,
        leg_mass=np.full(len(LEGS), LEG_MASS),
        base_mass=MASS - len(LEGS) * LEG_MASS,
        leg_com=com[:, None] + np.einsum("kij,klj->kli", R, leg_com_in_base),
        schedule=schedule,
        **_joints(time),
        foot_in_hip=in_base - HALF_STANCE,
    )


def _footholds(schedule: Schedule, twist: float, displacement: list[float]) -> np.ndarray:
    """(P, L, 3) m, where feet stand in each phase, or stood last."""
    places = np.array(
        [
            share * np.array(displacement) + HALF_STANCE @ rotation_about_z(share * twist).T
            for share in np.arange(schedule.places + 1) / schedule.places
        ]
    )
    return places[[each.place for each in schedule]]


def _forces(stands: np.ndarray, mass: float) -> np.ndarray:
    """(T, L, 3) N: a share of the weight each, and some noise."""
    rng = np.random.default_rng(7)
    force = np.zeros((*stands.shape, 3))
    stance = stands.any(axis=1)
    force[stance, :, 2] = mass * 9.81 / stands[stance].sum(axis=1, keepdims=True)
    force[stance] += rng.normal(scale=15.0, size=(stance.sum(), stands.shape[1], 3))
    force[~stands] = 0.0
    force[-1] = force[-2]
    return force


def _motion(
    time: np.ndarray, foot: np.ndarray, force: np.ndarray, mass: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """CoM, its velocity and the angular momentum, (T, 3) each, that follow from forces."""
    com, velocity, momentum = (np.zeros((len(time), 3)) for _ in range(3))
    com[0] = [0, 0, 0.5]
    for k, dt in enumerate(np.diff(time)):
        total = force[k].sum(axis=0)
        acceleration = total / mass + GRAVITY
        com[k + 1] = com[k] + velocity[k] * dt + acceleration * dt**2 / 2
        velocity[k + 1] = velocity[k] + acceleration * dt
        moment = np.cross(foot[k], force[k]).sum(axis=0)
        # The integral of r(t) x F with r quadratic.
        mean = com[k] + velocity[k] * dt / 2 + acceleration * dt**2 / 6
        momentum[k + 1] = momentum[k] + dt * (moment - np.cross(mean, total))
    return com, velocity, momentum


def _swing_straight(in_base: np.ndarray, time: np.ndarray, stands: np.ndarray) -> None:
    """Have feet that swing move on straight lines, in base axes."""
    for leg in range(in_base.shape[1]):
        changes = np.flatnonzero(np.diff(stands[:, leg].astype(int))) + 1
        for first, last in changes.reshape(-1, 2):
            share = ((time - time[first]) / (time[last] - time[first]))[first:last, None]
            start, end = in_base[first, leg], in_base[last, leg]
            in_base[first:last, leg] = (1 - share) * start + share * end


def _inertia(leg_com: np.ndarray) -> np.ndarray:
    """(T, 3, 3) kg m2 of the trunk and of legs that are points, in base axes."""
    inertia = np.repeat(TRUNK_INERTIA[None], len(leg_com), axis=0)
    for k, legs in enumerate(leg_com):
        for d in legs:
            inertia[k] += LEG_MASS * (d @ d * np.eye(3) - np.outer(d, d))
    return inertia


def _joints(time: np.ndarray) -> dict[str, Any]:
    """Joints that swing, and torques that have nothing to do with that."""
    phase = np.arange(len(JOINT_NAMES))
    return {
        "joint_position": 0.4 * np.sin(time[:, None] * 3 + phase),
        "joint_velocity": 1.2 * np.cos(time[:, None] * 3 + phase),
        "joint_torque": 30.0 * np.sin(time[:, None] * 5 + phase),
        "joint_torque_limit": np.full((len(time), len(phase)), 40.0),
        "joint_names": JOINT_NAMES,
    }

"""Numbers for a robot file: proportions of the robots that are tuned here, times its size."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

from llsrbm.arrays import Array
from llsrbm.errors import RobotFileError
from llsrbm.mechanics import GRAVITY
from llsrbm.robots.draft import arm_posture, drives, turning
from llsrbm.robots.draft.anatomy import Anatomy
from llsrbm.robots.draft.turning import metres

# Shares of the longest distance from a hip to its foot, as ANYmal's, Go2's and SLIDER's files have.
_STANDING = 0.74
_TALLEST, _TALLER = 0.86, 0.03  # where stops let no leg bend so far, in such steps
_NEAREST, _FARTHEST = 0.42, 0.91
_OF_STROKE = (0.1, 0.4, 0.65)  # of legs that slide: nearest, standing, farthest
_FORWARD, _SIDEWAYS = 0.38, 0.32
_LOWEST, _HIGHEST = 0.95, 0.35
_CLEARANCE, _APART = 0.13, 0.2
_JUMPS = {"forward": (-0.5, 1.0), "lateral": (-0.5, 0.5), "height": (-0.3, 0.4)}
# Of legs so long, m, the gains here are right, of point feet and of soles; times go with the root.
_TUNED_LENGTH = (0.5, 0.9)
# Longest distance of a foot from the resting hip, in lengths of the leg stretched in its plane: as
# much as hips of robots that are tuned gain by turning aside, whose stops are narrow.
_ASIDE = 1.08
# s, of robots that are tuned; the shortest of those whose joints need more of their speed to catch
# a fall, as ANYmal C's.
_FLIGHT, _SHORT_FLIGHT, _QUICK = (0.3, 0.6), 0.2, 0.8
_SAMPLES = 4000  # postures of a leg by which its length is measured
_LEVEL = 0.1  # m that a turn of a sole by 1 rad counts
_LEANS = 5e-3  # rad against the vertical up to which a sole stands level
_AT_STOP = 1e-3  # rad or m
_STRAIGHT = 1e-3  # how much a joint that is turned counts, so that those that need not are not
_MIRRORED = 1e-3  # m by which places of masses tell a mirrored leg from one like the front leg


@dataclass(frozen=True, eq=False)
class Proposal:
    """Content of a robot file, rounded.

    Attributes:
        values: key, with dots -> value; guessed: key -> made from what.
        sources: key -> where its number is from, or by what it is assumed.
        left_out: table -> why it is not proposed.
    """

    values: dict[str, Any]
    guessed: dict[str, str]
    sources: dict[str, str]
    left_out: dict[str, str] = field(default_factory=dict)


def propose(anatomy: Anatomy) -> Proposal:
    """Posture, reach, limits, timing, range and gains of a robot; `RobotFileError`: none stands."""
    shortest, length = _distances(anatomy)
    near, standing, far = _NEAREST * length, _STANDING * length, _FARTHEST * length
    tallest = _TALLEST * length
    basis = f"{length:.3f} m of leg"
    if anatomy.chains.prismatic.any():  # as much of the stroke to push off with as to land on
        near, standing, far = (shortest + share * (length - shortest) for share in _OF_STROKE)
        basis = f"a stroke of {length - shortest:.3f} m"
        length, tallest = far / _FARTHEST, standing  # of a leg that bends and reaches as far
    arms = np.zeros((0, 0))
    standing, angles, seen = _standing(anatomy, standing, tallest, arms)
    if anatomy.arms:  # clear of the legs, above whose soles the CoM with the arms then is
        arms = arm_posture.hang(anatomy, _joined(anatomy, angles, arms))
        standing, angles, seen = _standing(anatomy, standing, tallest, arms)
    outward = np.where(anatomy.hip_position[:, 1] < 0, -1.0, 1.0)
    side = float(np.mean(outward * seen[:, 1]))
    ahead = float(np.mean(seen[:, 0])) if anatomy.has_soles else 0.0
    values: dict[str, Any] = {
        f"posture.{name}": _radians(angles[k]) for k, name in enumerate(anatomy.names)
    }
    values |= _arms(anatomy, _joined(anatomy, angles, arms))
    values["reach.distance"] = metres(near, far)
    values |= _by_length(anatomy, length, ahead, side)
    guessed = {
        "posture": f"hips {standing:.2f} m above the feet, from {basis}",
        "reach": f"shares of {basis}",
        "limits": "friction, clearance and the feet's distance by the legs' length",
        "timing": "as of robots that are tuned",
        "task": "by the legs' length",
    }
    if anatomy.arms:
        guessed["arms"] = "what hangs in a mirrored pair, up to the elbow"
        guessed["arm_reach"] = "to the stops, or to where an arm that hangs meets the trunk"
    drives.limits(anatomy, length, values, guessed)
    if not anatomy.has_soles and _catching(anatomy, angles, values) > _QUICK:
        values["timing.flight"] = [_SHORT_FLIGHT, _FLIGHT[1]]
        guessed["timing"] += ", flights shorter as the legs are slow to catch a fall"
    sources = drives.table(anatomy, values)
    if anatomy.radius is not None:
        values["foot.radius"] = anatomy.radius
        guessed["foot.radius"] = "from the foot's collision geometry, which has no sphere"
    if anatomy.has_soles:
        values["foot.corners"] = [list(corner) for corner in anatomy.corners]
        values["foot.yaw"] = [-0.5, 0.5]
        guessed["foot"] = "corners from the foot's collision geometry; how far it may turn"
    _gains(anatomy, length, values, guessed)
    left_out = _turning(anatomy, length, side, values, guessed)
    return Proposal(values, guessed, sources, {"turning": left_out} if left_out else {})


def _by_length(anatomy: Anatomy, length: float, ahead: float, side: float) -> dict[str, Any]:
    """Numbers by the legs' length (m), of feet that stand so far ahead of and beside the hips."""
    return {
        "reach.lower": metres(
            ahead - _FORWARD * length, side - _SIDEWAYS * length, -_LOWEST * length
        ),
        "reach.upper": metres(
            ahead + _FORWARD * length, side + _SIDEWAYS * length, -_HIGHEST * length
        ),
        "limits.friction": 0.5,
        "limits.foot_speed": 5.0,
        "limits.clearance": round(_CLEARANCE * length, 2),
        "limits.feet_apart": _apart(anatomy, length),
        "timing.takeoff": [0.3 if anatomy.has_soles else 0.4, 0.8],
        "timing.flight": list(_FLIGHT),
        "timing.landing": [0.3 if anatomy.has_soles else 0.5, 0.8],
        "task.twist": [-3.1416, 3.1416],
        **{f"task.{name}": metres(*np.multiply(share, length)) for name, share in _JUMPS.items()},
        "example.twist": 0.7854,
    }


def _distances(anatomy: Anatomy) -> tuple[float, float]:
    """Shortest and longest from the first hip at rest to its foot, m, within the joints' limits.

    Hips that turn far aside leave the place where they rest: what they gain so does not count.
    """
    distance = _reached(anatomy)
    longest = float(distance.max(axis=0).min())
    return float(distance.min()), min(longest, _ASIDE * _stretch(anatomy))


def _catching(anatomy: Anatomy, angles: Array, values: dict[str, Any]) -> float:
    """Share of its speed that a joint needs to stop the fall of the shortest flight, standing."""
    fall = np.array([0.0, 0.0, GRAVITY * _FLIGHT[0] / 2])
    lift = np.linalg.pinv(anatomy.chains.motion(angles).foot_jacobian) @ fall
    return float((np.abs(lift) / np.array(values["limits.joint_speed"])).max())


def _stretch(anatomy: Anatomy) -> float:
    """Longest distance from the first hip to its foot, m, with the joints before the hip at zero.

    They move the hip away from where reach is measured from.
    """
    names = [anatomy.model.names[joint] for joint in anatomy.joint_ids[0]]
    return float(_reached(anatomy, names.index(anatomy.hips[0])).max(axis=0).min())


def _reached(anatomy: Anatomy, held: int = 0) -> Array:
    """(S, L) m from hips to feet in postures anywhere within the stops; `held` joints at zero."""
    lower, upper = anatomy.lower, anatomy.upper
    q = np.random.default_rng(0).uniform(lower, upper, (_SAMPLES, *lower.shape))
    # The straight leg is likely at zero or at a stop, which samples only come near.
    q[0], q[1], q[2] = np.clip(0.0, lower, upper), lower, upper
    q[..., :held] = 0.0
    return np.linalg.norm(anatomy.chains.motion(q).foot - anatomy.hip_position, axis=-1)


def _arms(anatomy: Anatomy, posture: Array) -> dict[str, Any]:
    """How the arms hang, from a posture (nq,), and how far they may move."""
    values: dict[str, Any] = {
        f"posture.{arm.name}": _radians(posture[anatomy.index(arm.joint_ids)])
        for arm in anatomy.arms
    }
    if anatomy.arms:
        lower, upper = arm_posture.ends(anatomy, posture)
        values["arm_reach.lower"], values["arm_reach.upper"] = _radians(lower), _radians(upper)
    return values


def _standing(
    anatomy: Anatomy, lowest: float, tallest: float, arms: Array
) -> tuple[float, Array, Array]:
    """Height (m) of the hips, from `lowest` up to `tallest`, where there is a `_posture`, and that.

    Raises `RobotFileError` of the lowest: there is none.
    """
    try:
        return lowest, *_posture(anatomy, lowest, arms)
    except RobotFileError:
        step = _TALLER * lowest / _STANDING
        for height in np.arange(lowest + step, tallest + step / 2, step):
            with contextlib.suppress(RobotFileError):
                return float(height), *_posture(anatomy, float(height), arms)
        raise


def _posture(anatomy: Anatomy, standing: float, arms: Array) -> tuple[Array, Array]:
    """Joint angles (L, n) with hips so high, m, above their feet; and these (L, 3) m from there.

    arms: (A, n) angles, of which the CoM depends too; none: as they are at zero.
    """
    shift, forward = 0.0, [_mirrors_a_front_leg(anatomy, k) for k in range(len(anatomy.names))]
    for _ in range(8 if anatomy.has_soles else 1):  # until the CoM is above the soles
        angles = np.array(
            [
                _leg_posture(anatomy, leg, np.array([shift, 0.0, -standing]), forward=forward[leg])
                for leg in range(len(anatomy.names))
            ]
        )
        foot = anatomy.chains.motion(angles).foot
        q = _joined(anatomy, angles, arms)
        off = pin.centerOfMass(anatomy.model, anatomy.model.createData(), q)[0] - foot[:, 0].mean()
        shift += off
    return angles, foot - anatomy.hip_position


def _leg_posture(anatomy: Anatomy, leg: int, foot_from_hip: Array, *, forward: bool) -> Array:
    """Joint angles (n,) with a foot there, seen from its hip, level if it is a sole.

    Sideways it is wherever the leg hangs down straight. Where the limits allow both ways to bend,
    the knee goes forward or backward, as `forward` says.
    """
    lower, upper = anatomy.lower[leg], anatomy.upper[leg]
    model, hip, joints = anatomy.model, anatomy.hip_position[leg], anatomy.joint_ids[leg]
    frame, data, posture = anatomy.chains.foot_ids[leg], model.createData(), pin.neutral(model)
    index = anatomy.index(joints)

    def pose(q: Array) -> tuple[Array, Array]:
        posture[index] = q
        pin.forwardKinematics(model, data, posture)
        foot = pin.updateFramePlacement(model, data, frame)
        return foot.translation - hip, foot.rotation

    def knee() -> float:
        """Distance (m) of the joints after the hip in front of the line from hip to foot."""
        ahead = np.array([data.oMi[j].translation[0] for j in joints])
        ahead -= hip[0] + pose(posture[index])[0][0] / 2
        return float(ahead.max(initial=0.0) + ahead.min(initial=0.0))

    rest = np.clip(0.0, lower, upper)
    sideways, _ = pose(rest)
    goal = foot_from_hip + np.array([0.0, sideways[1], 0.0])

    def residual(q: Array) -> Array:
        foot, rotation = pose(q)
        turn = _LEVEL * (rotation - np.eye(3)).ravel()
        return np.concatenate(
            [foot - goal, turn if anatomy.has_soles else np.zeros(0), _STRAIGHT * (q - rest)]
        )

    found, missed = [], []
    generator = np.random.default_rng(0)
    for _ in range(24):
        start = generator.uniform(lower, upper)
        result = least_squares(residual, start, bounds=(lower - 1e-9, upper + 1e-9))
        foot, rotation = pose(result.x)
        level = not anatomy.has_soles or np.linalg.norm(rotation[:2, 2]) < _LEANS
        if level and np.linalg.norm(foot - goal) < 0.01:
            found.append((float(result.cost), knee() > 0, result.x + 0.0))
        missed.append((float(result.cost), [*result.x]))
    if not found:
        name, sole = anatomy.names[leg], " and its sole level" if anatomy.has_soles else ""
        stops = [
            f"{model.names[joint]} at {q:.3g} {'m' if slides else 'rad'}"
            for joint, q, slides, low, high in zip(
                joints, min(missed)[1], anatomy.chains.prismatic, lower, upper, strict=True
            )
            if min(q - low, high - q) < _AT_STOP
        ]
        nearest = f"; in the nearest one a limit stops {', '.join(stops)}" if stops else ""
        raise RobotFileError(
            f"{anatomy.urdf}: leg {name} finds no posture with its foot {-foot_from_hip[2]:.2f} m "
            f"below {anatomy.hips[leg]}{sole}{nearest}; expected joint limits that allow one"
        )
    return min(found, key=lambda entry: (entry[1] != forward, entry[0]))[2]


def _mirrors_a_front_leg(anatomy: Anatomy, leg: int) -> bool:
    """True if a hind leg is the front leg of its side seen in a mirror, so that it bends forward.

    The links' CoMs tell, seen from the hip with all joints at zero: those from the hip outwards,
    or, where these are alike both ways, those between base and hip.
    """
    hip = anatomy.hip_position
    partners = np.flatnonzero((hip[:, 1] * hip[leg, 1] > 0) & (hip[:, 0] > 0))
    if hip[leg, 0] > 0 or not len(partners):
        return False
    own, other = (_link_places(anatomy, k) for k in (leg, int(partners[0])))
    first = [anatomy.model.names[j] for j in anatomy.joint_ids[leg]].index(anatomy.hips[leg])
    for links in (slice(first, None), slice(first)):
        alike = np.linalg.norm(own[links] - other[links])
        mirrored = np.linalg.norm(own[links] - other[links] * [-1, 1, 1])
        if abs(alike - mirrored) > _MIRRORED:
            return bool(mirrored < alike)
    return False


def _link_places(anatomy: Anatomy, leg: int) -> Array:
    """(n, 3) m: CoMs of a leg's links from its hip, all joints at zero, base axes."""
    model, data = anatomy.model, anatomy.model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    joints = anatomy.joint_ids[leg]
    places = [data.oMi[j].act(model.inertias[j].lever) for j in joints]
    return np.array(places) - anatomy.hip_position[leg]


def _joined(anatomy: Anatomy, legs: Array, arms: Array) -> Array:
    """Posture (nq,) from the angles of legs and arms, the base level at the origin."""
    q = pin.neutral(anatomy.model)
    limbs = [*anatomy.joint_ids, *(arm.joint_ids for arm in anatomy.arms[: len(arms)])]
    for joints, angles in zip(limbs, [*legs, *arms], strict=True):
        q[anatomy.index(joints)] = angles
    return q


def _apart(anatomy: Anatomy, length: float) -> float:
    if not anatomy.has_soles:
        return round(_APART * length, 2)
    return round(2 * float(np.linalg.norm(anatomy.corners, axis=1).max()), 2)


def _turning(
    anatomy: Anatomy, length: float, side: float, values: dict[str, Any], guessed: dict[str, str]
) -> str:
    """[turning] of quadrupeds on point feet, or why there is none; empty of other robots."""
    point_feet = not (anatomy.has_soles or anatomy.chains.prismatic.any())
    if not point_feet or anatomy.arms or len(anatomy.names) != turning.LEGS:
        return ""
    if missing := [key for key in ("limits.torque", "limits.joint_speed") if key in guessed]:
        are = "is" if len(missing) == 1 else "are"
        return f"the URDF lacks drives that can be meant, {' and '.join(missing)} {are} guessed"
    no_arms = np.zeros((0, 0))
    nearest = _NEAREST * length
    try:
        tucked, _ = _posture(anatomy, nearest, no_arms)
    except RobotFileError:
        return f"stops let no leg fold until its foot is {nearest:.2f} m below its hip, as flips do"
    model, data = anatomy.model, anatomy.model.createData()
    pin.ccrba(model, data, _joined(anatomy, tucked, no_arms), np.zeros(model.nv))
    limits = (np.array(values[key]) for key in ("limits.torque", "limits.joint_speed"))
    flip = turning.estimate(anatomy.mass, float(data.Ig.inertia[1, 1]), length, *limits)
    if why := turning.left_out(flip):
        return why
    stretch = _stretch(anatomy)
    for key, value in turning.turning_table(stretch, side).items():
        inner = value if isinstance(value, dict) else {None: value}
        values |= {f"turning.{key}" + (f".{k}" if k else ""): v for k, v in inner.items()}
    guessed["turning"] = (
        f"a flip takes {flip.energy:.0f} J, its drives' torque does {flip.work:.0f} J on the way up"
    )
    guessed["turning.reach"] = f"shares of {stretch:.3f} m, the leg stretched in its plane"
    return ""


def _gains(
    anatomy: Anatomy, length: float, values: dict[str, Any], guessed: dict[str, str]
) -> None:
    """The controller's: quicker for short legs; bipeds as SLIDER has them."""
    quicker = float(np.clip(np.sqrt(_TUNED_LENGTH[anatomy.has_soles] / length), 0.8, 1.5))
    if anatomy.has_soles:
        values["control.rate"] = 1000.0
        values["control.force_phase"] = 0.0
        tasks = {"com": (100.0, 20.0), "orientation": (150.0, 24.0), "swing": (600.0, 49.0)}
        values["control.weights.com"] = 10.0
    elif quicker > 1.1:
        values["control.rate"] = 800.0
        tasks = {"com": (300.0, 35.0), "orientation": (150.0, 20.0), "swing": (500.0, 40.0)}
    else:
        return
    for task, (stiffness, damping) in tasks.items():
        values[f"control.gains.{task}"] = [
            round(stiffness * quicker**2, 0),
            round(damping * quicker, 1),
        ]
    guessed["control"] = f"gains for legs of {length:.2f} m"


def _radians(angles: Array) -> list[float]:
    return [round(float(angle), 4) + 0.0 for angle in angles]

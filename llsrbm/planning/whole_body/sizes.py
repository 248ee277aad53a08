"""Names and sizes of the variables, parameters and rows of the whole-body problem."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.mechanics import GRAVITY
from llsrbm.planning.whole_body.apart import PAIRS
from llsrbm.planning.whole_body.grid import Knot
from llsrbm.planning.whole_body.limbs import LINK, LimbKind, limbs_of, trunk_numbers
from llsrbm.request.jump import COMPONENTS
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

NODES = (0.25, 0.75)  # of an interval
LIMITS = ("torque_share", "speed_share", "friction")  # which a request may change
# What each cost counts. Nearness is that to the first stage, a little; the base is to be level, the
# joints as in the default posture. `steep` is what differs between the nodes: the equations of
# motion hold at these, and elsewhere the less the straighter all moves.
WEIGHTS = {
    "near": 0.1,
    "level": 0.3,
    "turning": 0.1,
    "joint_speed": 0.1,
    "posture": 0.3,
    "time": 1.0,
    "acceleration": 0.3,
    "joint_acceleration": 4.0,
    "force": 0.1,
    "torque": 1.0,
    "steep_joints": 4.0,
    "steep_base": 1.0,
    "steep_force": 1.0,
}
# The units of variables that are not of about 1.
UNITS = {
    "joint_velocity": 5.0,
    "acceleration": 10.0,
    "omega_rate": 30.0,
    "joint_acceleration": 100.0,
}
EQUALITIES = frozenset({"start", "rest", "landing", "goal", "dynamics"})


@dataclass(frozen=True)
class Sizes:
    """Numbers of a robot's joints, limbs and contact points, and what its variables are scaled by.

    Equal ones have the same expressions, whatever their robots weigh.

    Attributes:
        limbs: legs in their order, then arms; limb_joints: the places of their joints.
        phases: of the schedule, whose durations are variables.
        pairs: of legs beside each other, or one behind the other.
        weight: N of the robot.
    """

    limbs: tuple[LimbKind, ...]
    limb_joints: tuple[tuple[int, ...], ...]
    phases: int
    pairs: tuple[tuple[int, int], ...]
    weight: float = field(compare=False)

    @classmethod
    def of(cls, robot: Robot, phases: int) -> Sizes:
        """A robot's, in a schedule of so many phases."""
        hips, limbs = np.sign(robot.hips[:, :2]), limbs_of(robot)
        legs = len(robot.legs)
        return cls(
            limbs=tuple(limb.kind for limb in limbs),
            limb_joints=tuple(limb.joints for limb in limbs),
            phases=phases,
            pairs=tuple(
                (i, j)
                for i, j in combinations(range(legs), 2)
                if legs == 2 or (hips[i] == hips[j]).sum() == 1
            ),
            weight=robot.mass * GRAVITY,
        )

    @property
    def joints(self) -> int:
        """Number of joints."""
        return sum(map(len, self.limb_joints))

    @property
    def legs(self) -> int:
        """Number of legs."""
        return sum(limb.corners > 0 for limb in self.limbs)

    @property
    def corners(self) -> int:
        """Contact points of a foot."""
        return self.limbs[0].corners

    @property
    def knees(self) -> bool:
        """Whether legs have some."""
        return self.limbs[0].knee is not None

    @property
    def slides(self) -> NDArray[np.bool_]:
        """(J,) which joints do."""
        found = np.zeros(self.joints, dtype=bool)
        for limb, places in zip(self.limbs, self.limb_joints, strict=True):
            found[list(places)] = [joint.slides for joint in limb.joints]
        return found

    @property
    def robot(self) -> dict[str, int]:
        """Parameters of the whole problem: the robot in numbers, as `robot_numbers` gives them."""
        limbs = {f"limb {i}": sum(kind.numbers.values()) for i, kind in enumerate(self.limbs)}
        each = dict.fromkeys(("torque_limit", "speed_limit", "posture"), self.joints)
        return {"weight": 1, "trunk": sum(LINK.values()), **limbs, **each}

    @property
    def unit_force(self) -> float:
        """N: each contact point's share of the weight."""
        return self.weight / (self.legs * self.corners)

    @property
    def moving(self) -> dict[str, int]:
        """Base: place and velocity in the world, attitude, and rate in its axes; joints."""
        return moving(self.joints)

    @property
    def state(self) -> dict[str, int]:
        """States: what moves, and what stays as it is: the durations of all phases, and by how much
        more is done of each component than the stages' numbers are of.
        """
        return {**self.moving, "durations": self.phases, "offset": len(COMPONENTS)}

    @property
    def motion(self) -> dict[str, int]:
        """Accelerations at a node."""
        return accelerations(self.joints)

    def node(self, legs: int) -> dict[str, int]:
        """Controls at a node at which so many legs stand."""
        return {**self.motion, "force": 3 * self.corners * legs}

    @property
    def states(self) -> int:
        """Number of states."""
        return sum(self.state.values())

    def controls(self, knot: Knot) -> int:
        """Number of controls."""
        per_node = sum(self.node(len(knot.standing)).values())
        return 0 if knot.last else len(NODES) * per_node

    def unit(self, knot: Knot) -> Array:
        """(n,) what one of each of a stage's variables is in SI units."""
        of_node = units(self.node(len(knot.standing)), self.unit_force)
        nodes = 0 if knot.last else len(NODES)
        return np.concatenate([units(self.state, 1.0), *([of_node] * nodes)])

    @property
    def own(self) -> dict[str, int]:
        """Parameters of a stage: what its states are near to, times, weights, limits, places of the
        feet, where they look, how the ground rises there and its normals, how a base leans that is
        level to it, directions across edges, how far links are apart, and of an offset which
        components it may have, what is wanted, its price, about what it turns, and what goes with
        it: `moves` marks legs that stand where the motion ends, `rises` are shares of what feet
        clear, `edges` marks ones that move.

        `step` is the interval's share of its `phase`, which is marked by a one.
        """
        return {
            **self.moving,
            "step": 1,
            "phase": self.phases,
            "weights": len(WEIGHTS),
            "limits": len(LIMITS),
            "place": 3 * self.legs,
            "heading": 2 * self.legs,
            "tilt": 2 * self.legs,
            "normal": 3 * self.legs,
            "level": 2,
            "towards": 2 * self.legs,
            "apart": self.near * self.posture,
            "apart_in_middle": self.near * self.posture,
            "free": len(COMPONENTS),
            "wanted": len(COMPONENTS),
            "price": len(COMPONENTS),
            "pivot": 3,
            "moves": self.legs,
            "rises": self.legs * self.heights,
            "rises_in_middle": self.legs * self.heights,
            "edges": 1,
        }

    @property
    def near(self) -> int:
        """Pairs of links, or of a link and a box, that are kept apart."""
        return PAIRS * len(self.limbs)

    @property
    def posture(self) -> int:
        """Numbers of the base's place, its turn and the joints."""
        return 6 + self.joints

    @property
    def foot(self) -> int:
        """Coordinates of a foot's pose: soles have three more."""
        return 3 if self.corners == 1 else 6

    @property
    def heights(self) -> int:
        """Heights of a foot that are looked at: of its balls, and of a sole's middle."""
        return 1 if self.corners == 1 else 1 + self.corners

    def pairs_with(self, standing: tuple[int, ...]) -> list[tuple[int, int]]:
        """Pairs of legs beside each other of which one swings while these stand."""
        return [pair for pair in self.pairs if not set(pair) <= set(standing)]

    def rows(self, knot: Knot) -> dict[str, int]:
        """Names and sizes of a knot's rows, in order; `interval_rows` follow."""
        if knot.first:
            still = {"durations": self.phases, "offset": len(COMPONENTS)}
            return {"start": sum(self.moving.values()), **still}
        rows = {
            **self._of_posture(knot.resting),
            "landing": self.foot * len(knot.landing),
            "goal": 12 if knot.last else 0,
        }
        if knot.last:
            del rows["speed"]
        return {name: size for name, size in rows.items() if size}

    def interval_rows(self, knot: Knot) -> list[tuple[str, float, int]]:
        """Names, shares of the interval and sizes of the rows over the interval after a knot.

        The equations of motion hold at the nodes; what a knot's posture keeps to is kept to in the
        middle, too; lines are within their limits where they are at both ends.
        """
        contacts = self.corners * len(knot.standing)
        dynamics = [("dynamics", share, 6) for share in NODES]
        middle = {**self._of_posture(knot.standing), "drive": self.joints}
        in_middle = [(name, 0.5, size) for name, size in middle.items() if size]
        at_ends = {"torque": self.joints, "drive": self.joints, "friction": 4 * contacts}
        lines = [(name, end, size) for end in (0.0, 1.0) for name, size in at_ends.items() if size]
        return [*dynamics, *in_middle, *lines]

    def _of_posture(self, standing: tuple[int, ...]) -> dict[str, int]:
        """Rows of a posture and its rates, where the feet of these legs stand."""
        swinging = self.legs - len(standing)
        return {
            "stop": self.joints,
            "speed": self.joints,
            "rest": self.foot * len(standing),
            "clearance": swinging * self.heights,
            "edge": swinging * self.corners,
            "shanks": (1 + self.knees) * len(self.pairs_with(standing)),
            "knees": self.knees * len(standing),
            "apart": self.near,
        }


def moving(joints: int) -> dict[str, int]:
    """Base: place and velocity in the world, attitude, and rate in its axes; joints."""
    base = {"position": 3, "quat": 4, "joint_position": joints}
    return base | {"velocity": 3, "omega": 3, "joint_velocity": joints}


def accelerations(joints: int) -> dict[str, int]:
    """Accelerations of the base, in the world, of its rate, in its axes, and of the joints."""
    return {"acceleration": 3, "omega_rate": 3, "joint_acceleration": joints}


def robot_numbers(robot: Robot) -> Array:
    """`Sizes.robot` of a robot."""
    each = robot.torque_limit, robot.speed_limit, robot.posture[7:]
    limbs = (limb.numbers for limb in limbs_of(robot))
    weight = np.array([robot.mass * GRAVITY])
    return np.concatenate([weight, trunk_numbers(robot), *limbs, *each])


def units(sizes: Mapping[str, int], unit_force: float) -> Array:
    """(n,) of variables in these parts."""
    known = UNITS | {"force": unit_force}
    return np.concatenate([np.full(size, known.get(name, 1.0)) for name, size in sizes.items()])


def parts(values: Any, sizes: Mapping[str, int]) -> dict[str, Any]:
    """A vector, or the last axis of an array, cut into named parts."""
    ends = np.cumsum(list(sizes.values())).tolist()
    starts = [0, *ends[:-1]]
    along = (Ellipsis,) if isinstance(values, np.ndarray) else ()
    return {
        name: values[(*along, slice(start, end))] if along else values[start:end]
        for name, start, end in zip(sizes, starts, ends, strict=True)
    }


def line(share: Any) -> Array:
    """(3, 2, ...): of a line by its values at the nodes, what each counts at shares (...) of the
    interval: the line itself, its integral and its second integral, in units of the interval.
    """
    first, second = NODES
    value = np.array([second - share, share - first])
    once = np.array([second * share - share**2 / 2, share**2 / 2 - first * share])
    twice = np.array([second * share**2 / 2 - share**3 / 6, share**3 / 6 - first * share**2 / 2])
    return np.stack([value, once, twice]) / (second - first)

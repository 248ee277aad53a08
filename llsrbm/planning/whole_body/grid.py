"""Knots of the second stage, and of which numbers its variables, parameters and rows consist.

An interval holds two of the plan's: accelerations, forces and torques are straight lines over it,
given by their values in the middles of its halves (`NODES`), where the equations of motion hold. So
a plan with a knot at each half has in the middle of each of its intervals exactly these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from llsrbm.mechanics import GRAVITY
from llsrbm.motion.plan import Plan
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

NODES = (0.25, 0.75)  # of an interval
LIMITS = ("torque_share", "speed_share", "friction")  # which a request may change
SAME_INSTANT = 1e-9  # s
# From 0, even intervals, to 1. Between the nodes the equations of motion miss least from 0.6 to
# 0.75: a fifth to two fifths of what they miss with even ones; of SLIDER's fewer are solved there.
DENSER = 0.65
FEWEST = 2  # intervals of a phase


@dataclass(frozen=True)
class Knot:
    """A knot's place in the schedule.

    Attributes:
        standing: legs whose feet stand over the interval from there; none at the end.
        resting: legs whose feet stand before or after; landing: those that meet the ground there.
    """

    standing: tuple[int, ...]
    resting: tuple[int, ...]
    landing: tuple[int, ...]
    first: bool
    last: bool


@dataclass(frozen=True)
class Grid:
    """Phases in order: the legs whose feet stand, and the number of intervals."""

    phases: tuple[tuple[tuple[int, ...], int], ...]

    @classmethod
    def of(cls, plan: Plan) -> Grid:
        """The grid that a plan is refined on."""
        counts = np.bincount(plan.phase[:-1], minlength=len(plan.schedule))
        stands = [tuple(np.flatnonzero(legs).tolist()) for legs in plan.schedule.stands]
        intervals = [max(FEWEST, (int(count) + 1) // 2) for count in counts]
        return cls(tuple(zip(stands, intervals, strict=True)))

    @property
    def intervals(self) -> int:
        """Intervals of all phases."""
        return sum(count for _, count in self.phases)

    @cached_property
    def phase(self) -> NDArray[np.int64]:
        """(N,) the phase of each interval."""
        return np.repeat(np.arange(len(self.phases)), [count for _, count in self.phases])

    @cached_property
    def knots(self) -> tuple[Knot, ...]:
        """(N+1,) in order."""
        found: list[Knot] = []
        for number, (standing, count) in enumerate(self.phases):
            before = self.phases[number - 1][0] if number else standing
            for k in range(count):
                beside = before if k == 0 else standing
                found.append(
                    Knot(
                        standing=standing,
                        resting=tuple(sorted({*standing, *beside})),
                        landing=tuple(leg for leg in standing if leg not in beside),
                        first=not found,
                        last=False,
                    )
                )
        return (*found, Knot((), self.phases[-1][0], (), first=False, last=True))

    def times(self, plan: Plan) -> Array:
        """(2 N + 1,) s: the knots and the middles between them, by a plan's phases.

        Intervals are shorter beside the phases' edges, where legs start and stop.
        """
        parts = []
        for number, (_, count) in enumerate(self.phases):
            start, end = plan.phase_start[number], plan.phase_start[number + 1]
            # A quarter of a wave where the motion begins or ends at rest, else half of one.
            first, last = number > 0, number + 1 < len(self.phases)
            wave = np.cos(
                np.pi * np.linspace(0.0 if first else 0.5, 1.0 if last else 0.5, count + 1)
            )
            even = np.linspace(0.0, 1.0, count + 1)
            dense = (wave - wave[0]) / (wave[-1] - wave[0]) if first or last else even
            knots = start + (end - start) * ((1 - DENSER) * even + DENSER * dense)
            middles = (knots[1:] + knots[:-1]) / 2
            parts.append(np.column_stack([knots[:-1], middles]).ravel())
        return np.append(np.concatenate(parts), plan.phase_start[-1])

    @property
    def name(self) -> str:
        """For the cache."""
        return "-".join(
            f"{''.join(map(str, legs)) or 'air'}x{count}" for legs, count in self.phases
        )


@dataclass(frozen=True, eq=False)
class Sizes:
    """Numbers of a robot's joints, limbs and contact points, and what its variables are scaled by.

    Attributes:
        weight: N of the robot; unit_force: N, of a contact point's force.
    """

    joints: int
    legs: int
    arms: int
    corners: int
    weight: float

    @classmethod
    def of(cls, robot: Robot) -> Sizes:
        """A robot's."""
        limbs = len(robot.legs), len(robot.arms)
        return cls(len(robot.joint_names), *limbs, len(robot.corners), robot.mass * GRAVITY)

    @property
    def unit_force(self) -> float:
        """N: each contact point's share of the weight."""
        return self.weight / (self.legs * self.corners)

    @property
    def state(self) -> dict[str, int]:
        """Base: place and velocity in the world, attitude, and rate in its axes; joints."""
        return {
            "position": 3,
            "quat": 4,
            "joint_position": self.joints,
            "velocity": 3,
            "omega": 3,
            "joint_velocity": self.joints,
        }

    @property
    def motion(self) -> dict[str, int]:
        """Accelerations at a node."""
        return {"acceleration": 3, "omega_rate": 3, "joint_acceleration": self.joints}

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

    @property
    def own(self) -> dict[str, int]:
        """Parameters of a stage: what its variables are near to, the feet's places and headings."""
        nodes = {
            f"{name}_{node}": size
            for node in range(len(NODES))
            for name, size in (*self.motion.items(), ("force", 3 * self.corners * self.legs))
        }
        return {
            **self.state,
            **nodes,
            "step": 1,
            "place": 3 * self.legs,
            "heading": 2 * self.legs,
            "limits": 3,
            "apart": self.near * self.posture,
            "apart_in_middle": self.near * self.posture,
        }

    @property
    def near(self) -> int:
        """Pairs of links, or of a link and a box, that are kept apart: the soonest."""
        return self.legs + self.arms

    @property
    def posture(self) -> int:
        """Numbers of the base's place, its turn and the joints."""
        return 6 + self.joints

    @property
    def foot(self) -> int:
        """Coordinates of a foot's pose: soles have three more."""
        return 3 if self.corners == 1 else 6

    def rows(self, knot: Knot) -> dict[str, int]:
        """Names and sizes of a knot's rows, in order; `interval_rows` follow."""
        if knot.first:
            return {"start": self.states}
        swinging = self.legs - len(knot.resting)
        rows = {
            "stop": self.joints,
            "speed": 0 if knot.last else self.joints,
            "rest": self.foot * len(knot.resting),
            "landing": self.foot * len(knot.landing),
            "clearance": swinging * (1 if self.corners == 1 else 1 + self.corners),
            "apart": self.near,
            "goal": 12 if knot.last else 0,
        }
        return {name: size for name, size in rows.items() if size}

    def interval_rows(self, knot: Knot) -> list[tuple[str, float, int]]:
        """Names, shares of the interval and sizes of the rows over the interval after a knot.

        The equations of motion hold at the nodes, stops in the middle, too, where standing feet are
        at rest as at the knots; lines are within their limits where they are at both ends.
        """
        contacts = self.corners * len(knot.standing)
        dynamics = [("dynamics", share, 6) for share in NODES]
        at_ends = {"torque": self.joints, "drive": self.joints, "friction": 4 * contacts}
        lines = [(name, end, size) for end in (0.0, 1.0) for name, size in at_ends.items() if size]
        middle = {
            "stop": self.joints,
            "speed": self.joints,
            "drive": self.joints,
            "rest": self.foot * len(knot.standing),
            "apart": self.near,
        }
        in_middle = [(name, 0.5, size) for name, size in middle.items() if size]
        return [*dynamics, *in_middle, *lines]


# The units of variables that are not of about 1.
UNITS = {
    "joint_velocity": 5.0,
    "acceleration": 10.0,
    "omega_rate": 30.0,
    "joint_acceleration": 100.0,
}
EQUALITIES = frozenset({"start", "rest", "landing", "goal", "dynamics"})


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

"""The same task elsewhere: the world turned about the vertical, its origin moved, or mirrored.

What a motion is does not depend on where the world's axes are, and of a robot whose left and right
sides are alike not on which of them is which. So variables that are moved with the task have to
solve it alike: the tests that know no other answer.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.layout import SHIFT, TURNED, Layout
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.problem.task import Task
from llsrbm.planning.replan.under_way import State
from llsrbm.request.jump import Jump
from llsrbm.request.stones import Stone
from llsrbm.robots.robot import Robot

_VECTORS = {"position", "velocity", "force", "force_step", "next_force", SHIFT}
_AXIAL = {"momentum"}  # and of the base's own axes
_AXIAL_OF_BASE = {"rotation_rate", TURNED}


@dataclass(frozen=True)
class Elsewhere:
    """By `heading` (rad) about the vertical, then by `origin` (m); or the mirror image about y."""

    heading: float = 0.0
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirrored: bool = False

    @property
    def _matrix(self) -> np.ndarray:
        turn = Rotation.from_euler("z", self.heading).as_matrix()
        return turn @ np.diag([1.0, -1.0 if self.mirrored else 1.0, 1.0])

    def vectors(self, values: np.ndarray) -> np.ndarray:
        """(..., 3) or horizontal (..., 2), such as velocities and forces."""
        size = np.shape(values)[-1]
        return values @ self._matrix[:size, :size].T

    def points(self, values: np.ndarray) -> np.ndarray:
        """(..., 3) m."""
        return self.vectors(values) + self.origin

    def axial(self, values: np.ndarray) -> np.ndarray:
        """(..., 3) such as angular momentum: a mirror turns the other way."""
        return self.vectors(values) * (-1.0 if self.mirrored else 1.0)

    def quats(self, values: np.ndarray) -> np.ndarray:
        """(..., 4) w, x, y, z, signs as they are."""
        w, x, y, z = np.moveaxis(values * ([1, -1, 1, -1] if self.mirrored else 1), -1, 0)
        c, s = np.cos(self.heading / 2), np.sin(self.heading / 2)
        return np.stack([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w], axis=-1)

    def task(self, task: Task) -> Task:
        """One without an obstacle; of the mirror image the mirrored request's."""
        if self.mirrored:
            jump = replace(
                task.jump,
                twist=-task.jump.twist,
                lateral=-task.jump.lateral,
                stones=mirrored_stones(task.jump, task.robot),
            )
            task = make_task(jump, task.robot, task.tuning.weights, task.tuning.limits)
            return replace(self, mirrored=False).task(task)
        soles = self.heading * (not task.foot.is_point)
        places = tuple(
            replace(
                place,
                feet=self.points(place.feet),
                yaw=place.yaw + soles,
                contacts=self.points(place.contacts),
                heading=place.heading + self.heading,
                origin=self.points(place.origin),
            )
            for place in task.places
        )
        motion = task.motion and replace(
            task.motion,
            momentum=self.vectors(task.motion.momentum),
            heights=task.motion.heights + self.origin[2],
        )
        return replace(
            task,
            places=places,
            start_position=self.points(task.start_position),
            goal_position=self.points(task.goal_position),
            start_quat=self.quats(task.start_quat),
            goal_quat=self.quats(task.goal_quat),
            start_velocity=self.vectors(task.start_velocity),
            goal_velocity=self.vectors(task.goal_velocity),
            motion=motion,
        )

    def plan(self, plan: Plan) -> Plan:
        """A plan; not mirrored."""
        moved = {
            self.points: ("com", "base_position", "foot_position", "contact_point", "leg_com"),
            self.vectors: ("com_velocity", "angular_velocity", "angular_momentum", "contact_force"),
            self.quats: ("base_quat",),
        }
        return replace(
            plan,
            **{name: move(getattr(plan, name)) for move, names in moved.items() for name in names},
        )

    def state(self, state: State) -> State:
        """A state under way, of a robot with point feet; not mirrored."""
        moved = {
            self.points: ("com", "foot_position"),
            self.vectors: (
                "com_velocity",
                "angular_velocity",
                "angular_momentum",
                "foot_velocity",
            ),
            self.quats: ("base_quat",),
        }
        return self._moved(state, moved)

    @staticmethod
    def _moved(of: Any, moved: dict[Any, tuple[str, ...]]) -> Any:
        return replace(
            of,
            **{name: move(getattr(of, name)) for move, names in moved.items() for name in names},
        )

    def variables(self, robot: Robot, layout: Layout, w: np.ndarray) -> np.ndarray:
        """All variables; of the mirror image those of legs side by side change places."""
        out = w.copy()
        for knot in range(layout.knots):
            for name, place in layout.variables(knot).items():
                out[place] = self._variable(robot, layout, knot, name, w[place])
        return out

    def states(self, robot: Robot, layout: Layout, knot: int, x: np.ndarray) -> np.ndarray:
        """The states of a knot alone."""
        start = layout.stage(knot).start
        places = layout.variables(knot)
        parts = [
            self._variable(robot, layout, knot, name, x[place.start - start : place.stop - start])
            for name, place in places.items()
            if name in layout.states(layout.roles[knot])
        ]
        return np.concatenate(parts)

    def _variable(
        self, robot: Robot, layout: Layout, knot: int, name: str, values: np.ndarray
    ) -> np.ndarray:
        legs = layout.legs_of(name, layout.roles[knot])
        if legs and self.mirrored:
            each = values.reshape(len(legs), -1)
            values = np.array([each[legs.index(other_side(robot)[leg])] for leg in legs])
            if "force" in name:
                values = values.reshape(len(legs), layout.corners, 3)[:, _corners(robot)]
        if name == "position":
            return self.points(values)
        if name in _VECTORS:
            return self.vectors(values.reshape(-1, min(3, values.size))).ravel()
        if name in _AXIAL:
            return self.axial(values)
        if name in _AXIAL_OF_BASE:
            return replace(self, heading=0.0).axial(values)
        if name == "quat":
            return self.quats(values)
        return values.ravel()


def mirrored_stones(jump: Jump, robot: Robot) -> tuple[Stone, ...]:
    """The stones of a jump's mirror image."""
    names, other = robot.leg_names, other_side(robot)
    return tuple(
        Stone(names[other[names.index(leg)]], dx, -dy, dz) for leg, dx, dy, dz in jump.stones
    )


def other_side(robot: Robot) -> list[int]:
    """Of each leg the one whose hip is its hip's mirror image."""
    off = np.abs(robot.hips[:, None] * [1, -1, 1] - robot.hips).max(axis=-1)
    return off.argmin(axis=1).tolist()


def _corners(robot: Robot) -> list[int]:
    corners = np.array(robot.corners)
    off = np.abs(corners[:, None] * [1, -1, 1] - corners).max(axis=-1)
    return off.argmin(axis=1).tolist()

"""What there is to plot of planned and simulated motions, in groups of charts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from app.motion import colours
from app.motion.colours import Rgb
from app.motion.foreign_motion import ForeignMotion
from app.motion.planned_motion import PlannedMotion
from app.plots.signals import (
    Signals,
    principal_moments,
    signals_of,
    simulated_signals,
    whole_body_inertia,
)
from llsrbm.analysis.peak_loads import torque_share
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.rotation import rotation_matrices, yaw
from llsrbm.robots import Robot

Array = NDArray[np.float64]

LIMIT: Rgb = colours.FOOT

ALL_JOINTS = "all"
TORQUES, LANDING = "Joint torques and speeds", "Landing"

_INERTIAS = 400  # at most, of a motion; they change slowly, and eigenvalues take their time
_POWER = 10.0  # W, in view at least
_SHARE_SHOWN = 2.0  # of a limit
_SIGNAL_SHOWN = 3.0  # thresholds; how far an impact goes beyond matters no more


@dataclass(frozen=True, eq=False)
class Layer:
    """A motion to be plotted: one line in each chart.

    Attributes:
        title: what it is called in the legend.
        colour: of its lines.
        motion: a plan, or a motion from a file.
        rollout: what is plotted instead of the plan, if there is one.
        pinned: whether it is there for comparison: marks and time axis are the others'.
    """

    title: str
    colour: Rgb
    motion: PlannedMotion | ForeignMotion
    rollout: Rollout | None
    pinned: bool

    @property
    def replay(self) -> PlannedMotion | None:
        """The plan; None of a motion from a file."""
        return self.motion if isinstance(self.motion, PlannedMotion) else None

    @cached_property
    def course(self) -> Signals:
        """What is plotted."""
        if self.rollout is not None:
            return simulated_signals(self.rollout)
        return signals_of(self.motion.motion)


def shown_layers(replay: PlannedMotion, rollout: Rollout | None) -> tuple[Layer, ...]:
    """The design that is shown: its plan and, if there is one, its simulation."""
    plan = Layer("plan", colours.PLANNED, replay, None, pinned=False)
    if rollout is None:
        return (plan,)
    return (plan, Layer("simulation", colours.SIMULATED, replay, rollout, pinned=False))


@dataclass(frozen=True, eq=False)
class Line:
    """One curve of a chart.

    Attributes:
        title: the layer's, or what is special about it.
        colour: of the line; dashed: whether it is.
        time: (K,) s, increasing; values: (K,) in the unit of the chart's title.
    """

    title: str
    colour: Rgb
    dashed: bool
    time: Array
    values: Array


@dataclass(frozen=True, eq=False)
class Chart:
    """One quantity of all layers that have it.

    Attributes:
        title: quantity and unit.
        lines: what is drawn, first things first.
        least: values from -least to least are in view, however small what is drawn: a tenth of a
            degree shall not look like a fall. 0: nothing but what is drawn.
    """

    title: str
    lines: tuple[Line, ...]
    least: float = 0.0


def charts(group: str, layers: Sequence[Layer], joints: str = ALL_JOINTS) -> tuple[Chart, ...]:
    """The charts of a group, one of `GROUPS`; none of what no layer has.

    Args:
        group: what of the motions.
        layers: in the order in which they are drawn.
        joints: one of `joint_kinds`, for the group `TORQUES`.
    """
    drawn = GROUPS[group]([(layer, layer.course) for layer in layers], joints)
    return tuple(chart for chart in drawn if chart.lines)


def joint_kinds(robot: Robot) -> tuple[str, ...]:
    """What can be chosen of a robot's joints: all of them, or those at one place of its legs."""
    kinds = [_kind(leg.name, joint) for leg in robot.legs for joint in leg.joints]
    return (ALL_JOINTS, *dict.fromkeys(kinds))


def _kind(leg: str, joint: str) -> str:
    return joint.removeprefix(leg).strip("_").removesuffix("_joint")


# ---- groups

_Pairs = Sequence[tuple[Layer, Signals]]
_Quantity = Callable[[Signals], Array | None]
_Group = Callable[[_Pairs, str], list[Chart]]


def _line(layer: Layer, course: Signals, values: Array) -> Line:
    return Line(layer.title, layer.colour, False, course.time, values)


def _chart(title: str, pairs: _Pairs, quantity: _Quantity, least: float = 0.0) -> Chart:
    known = [(layer, course, quantity(course)) for layer, course in pairs]
    lines = [_line(layer, course, values) for layer, course, values in known if values is not None]
    return Chart(title, tuple(lines), least)


def _limited(chart: Chart, limit: float, title: str = "limit") -> Chart:
    """The chart with a dashed line across it."""
    if not chart.lines:
        return chart
    span = np.array([[line.time[0], line.time[-1]] for line in chart.lines])
    across = np.array([span[:, 0].min(), span[:, 1].max()])
    level = Line(title, LIMIT, True, across, np.full(2, limit))
    return replace(chart, lines=(level, *chart.lines))


@dataclass(frozen=True)
class _Plain:
    """A quantity that every motion of every robot has; `least` as in `Chart`."""

    title: str
    of: _Quantity
    least: float = 0.0


def _each(*quantities: _Plain) -> _Group:
    def group(pairs: _Pairs, _joints: str) -> list[Chart]:
        return [_chart(plain.title, pairs, plain.of, plain.least) for plain in quantities]

    return group


def _axes(title: str, attribute: str, least: tuple[float, float, float]) -> _Group:
    """A group of a vector's components; `{}` in the title is the axis."""

    def component(axis: int) -> _Quantity:
        return lambda course: np.asarray(getattr(course, attribute)[:, axis], dtype=np.float64)

    return _each(*(_Plain(title.format("xyz"[i]), component(i), least[i]) for i in range(3)))


def _yaw(course: Signals) -> Array:
    return np.degrees(yaw(course.base_quat))


def _pitch(course: Signals) -> Array:
    return np.degrees(-np.arcsin(np.clip(rotation_matrices(course.base_quat)[:, 2, 0], -1, 1)))


def _roll(course: Signals) -> Array:
    R = rotation_matrices(course.base_quat)
    return np.degrees(np.unwrap(np.arctan2(R[:, 2, 1], R[:, 2, 2])))


def _vertical_force(course: Signals) -> Array | None:
    if course.foot_force is None:
        return None
    total: Array = course.foot_force[..., 2].sum(axis=1)
    return total


def _inertias(pairs: _Pairs, _joints: str) -> list[Chart]:
    """Principal moments; of a plan, the model's and those of the whole body in its postures."""
    lines: list[list[Line]] = [[], [], []]
    for layer, course in pairs:
        kept = slice(None, None, 1 + len(course.time) // _INERTIAS)
        moments = principal_moments(course.robot, course.inertia[kept], course.base_quat[kept])
        for axis, values in zip(lines, moments.T, strict=True):
            axis.append(Line(layer.title, layer.colour, False, course.time[kept], values))
        if layer.rollout is None and not layer.pinned:
            time, inertia, quat = whole_body_inertia(layer.motion.motion)
            moments = principal_moments(course.robot, inertia, quat)
            for axis, values in zip(lines, moments.T, strict=True):
                axis.append(Line("whole body as planned", layer.colour, True, time, values))
    titles = ("roll", "pitch", "yaw")
    return [
        Chart(f"Inertia, {title} [kg m²]", tuple(axis))
        for title, axis in zip(titles, lines, strict=True)
    ]


def _forces(pairs: _Pairs, _joints: str) -> list[Chart]:
    """Vertical forces: all feet together, and each foot; robots may differ in their legs."""
    names = dict.fromkeys(leg.name for _, course in pairs for leg in course.robot.legs)

    def of_leg(name: str) -> _Quantity:
        def force(course: Signals) -> Array | None:
            legs = [leg.name for leg in course.robot.legs]
            if course.foot_force is None or name not in legs:
                return None
            return course.foot_force[:, legs.index(name), 2]

        return force

    total = _chart("Vertical force, all feet [N]", pairs, _vertical_force)
    return [total, *(_chart(f"Vertical force, {name} [N]", pairs, of_leg(name)) for name in names)]


def _joint_loads(pairs: _Pairs, joints: str) -> list[Chart]:
    """Largest shares of limits over the chosen joints, and their power together."""

    def chosen(robot: Robot) -> NDArray[np.int64]:
        columns = [
            robot.joint_names.index(joint)
            for leg in robot.legs
            for joint in leg.joints
            if joints in (ALL_JOINTS, _kind(leg.name, joint))
        ]
        return np.array(columns, dtype=np.int64)

    def largest(values: Array, limit: Array, robot: Robot) -> Array | None:
        columns = chosen(robot)
        if not len(columns):
            return None
        limits = np.broadcast_to(limit, values.shape)[:, columns]
        # A plan that failed may ask for torque where there is none.
        return np.minimum(torque_share(values[:, columns], limits).max(axis=1), _SHARE_SHOWN)

    def torque(course: Signals) -> Array | None:
        if course.torque is None:
            return None
        return largest(course.torque, course.robot.torque_limit, course.robot)

    def saturation(course: Signals) -> Array | None:
        if course.torque is None or course.torque_limit is None:
            return None
        return largest(course.torque, course.torque_limit, course.robot)

    def speed(course: Signals) -> Array | None:
        return largest(course.joint_speed, course.robot.speed_limit, course.robot)

    def power(course: Signals) -> Array | None:
        columns = chosen(course.robot)
        if course.torque is None or not len(columns):
            return None
        total: Array = (course.torque * course.joint_speed)[:, columns].sum(axis=1)
        return total

    of = f", {joints}" if joints != ALL_JOINTS else ""
    titles = ("Torque / limit", "Torque / limit at its speed", "Joint speed / limit")
    shares = [
        _limited(_chart(f"{title}{of}", pairs, quantity), 1.0)
        for title, quantity in zip(titles, (torque, saturation, speed), strict=True)
    ]
    return [*shares, _chart(f"Power of the drives{of} [W]", pairs, power, _POWER)]


def _landing(pairs: _Pairs, _joints: str) -> list[Chart]:
    """What tells a touchdown, and how far the yaw is off there."""
    signals, yaws = [], []
    level = 1.0
    for layer, course in pairs:
        rollout = layer.rollout
        if rollout is None:
            continue
        signal = rollout.detection_signal / abs(rollout.detection_threshold)
        level = float(np.sign(rollout.detection_threshold))
        signals.append(_line(layer, course, np.clip(signal, -_SIGNAL_SHOWN, _SIGNAL_SHOWN)))
        plan = signals_of(layer.motion.motion)
        off = _yaw(course) - np.interp(course.time, plan.time, _yaw(plan))
        yaws.append(_line(layer, course, off))
    return [
        _chart("Spatial velocity ‖v_G‖", pairs, lambda t: t.average_spatial_velocity_norm),
        _limited(Chart("Detection signal / |threshold|", tuple(signals)), level, "threshold"),
        Chart("Yaw − planned yaw [°]", tuple(yaws), least=1.0),
    ]


GROUPS: dict[str, _Group] = {
    "Overview": _each(
        _Plain("Base yaw [°]", _yaw, 2.0),
        _Plain("Base yaw rate [rad/s]", lambda course: course.angular_velocity[:, 2], 0.2),
        _Plain("CoM height [m]", lambda course: course.com[:, 2]),
        _Plain("Vertical force, all feet [N]", _vertical_force),
    ),
    "Base angles": _each(
        _Plain("Yaw [°]", _yaw, 2.0),
        _Plain("Pitch [°]", _pitch, 2.0),
        _Plain("Roll [°]", _roll, 2.0),
    ),
    "Base rates": _axes("Base rate about {} [rad/s]", "angular_velocity", (0.2, 0.2, 0.2)),
    "CoM position": _axes("CoM {} [m]", "com", (0.02, 0.02, 0.0)),
    "CoM velocity": _axes("CoM velocity {} [m/s]", "com_velocity", (0.1, 0.1, 0.1)),
    "Linear momentum": _axes("Linear momentum {} [kg m/s]", "linear_momentum", (2.0, 2.0, 2.0)),
    "Angular momentum": _axes("Angular momentum {} [kg m²/s]", "angular_momentum", (0.2, 0.2, 0.2)),
    "Principal inertias": _inertias,
    "Contact forces": _forces,
    TORQUES: _joint_loads,
    LANDING: _landing,
}
"""What can be chosen, and how its charts are made of layers with their courses."""

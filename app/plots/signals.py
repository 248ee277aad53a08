"""Everything that can be plotted over time: the quantities that plans and rollouts declare, and
angles, moments of inertia and shares of limits that follow from them. `SIGNALS` is the one list.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from app.plots.choice import ALL_JOINTS
from app.plots.time_series import TimeSeries, principal_moments, recorded_name, whole_body_inertia
from llsrbm.arrays import Array
from llsrbm.body.peak_loads import torque_share
from llsrbm.files.quantity import (
    CONTACT,
    JOINT,
    LEG,
    PARTS,
    TENSOR,
    TIME,
    Kind,
    Quantity,
    derived,
    entries,
    quantities,
)
from llsrbm.mechanics import rotation_matrices, yaw
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.robots import Robot
from llsrbm.robots.drives.windings import Windings


@dataclass(frozen=True)
class Component:
    """One number of a quantity."""

    name: str  # "x", "LF z", a joint's; "" of a quantity that is one number
    unit: str  # SI, or degrees
    # names of sets that it belongs to, besides its own: "LF", "z", a kind of joints
    tags: tuple[str, ...] = ()

    def is_one_of(self, names: tuple[str, ...]) -> bool:
        """True if its name or one of its tags is among `names`, or if these are empty."""
        return not names or self.name in names or not set(self.tags).isdisjoint(names)


@dataclass(frozen=True, eq=False)
class Samples:
    """A signal of one motion: time (K,) s, increasing; n components; values (K, n)."""

    time: Array
    components: tuple[Component, ...]
    values: Array


@dataclass(frozen=True)
class Signal:
    """One quantity of motions over time."""

    key: str  # by which choices name it
    title: str  # in menus and above charts
    # samples of a motion, or None if it has no such quantity
    of: Callable[[TimeSeries], Samples | None]
    # values from -least to least are in view, however small the drawn ones are: a tenth of a degree
    # shall not look like a fall. 0: the drawn ones alone
    least: float = 0.0
    most: float = np.inf  # values beyond ±most are drawn there; files have them as they are
    # level, level_title: value of a limit or threshold for one motion; its name in the legend
    level: Callable[[TimeSeries], float | None] | None = None
    level_title: str = ""
    # also, also_title: a second curve of plans that are not pinned, drawn dashed; its name
    also: Callable[[TimeSeries], Samples] | None = None
    also_title: str = ""


# ---- joints


def joint_kinds(robot: Robot) -> tuple[str, ...]:
    """Sets of a robot's joints: all of them, and those at one place of its legs."""
    kinds = [_kind(leg.name, joint) for leg in robot.legs for joint in leg.joints]
    return (ALL_JOINTS, *dict.fromkeys(kinds))


def _kind(leg: str, joint: str) -> str:
    return joint.removeprefix(leg).strip("_").removesuffix("_joint")


def _joint_tags(robot: Robot) -> dict[str, tuple[str, ...]]:
    """Joint, in the robot's order -> its kind and its leg."""
    tags = {joint: (_kind(leg.name, joint), leg.name) for leg in robot.legs for joint in leg.joints}
    return {name: tags.get(name, ()) for name in robot.joint_names}


# ---- declared quantities

_WORDS = {"com": "CoM", "quat": "quaternion", "reference": "tracked:"}

# In view at least; a still robot's noise shall not fill a chart.
_LEAST = {
    "angular_velocity": 0.2,
    "com_velocity": 0.1,
    "base_velocity": 0.1,
    "linear_momentum": 2.0,
    "angular_momentum": 0.2,
    "joint_velocity": 0.2,
}


def _declared() -> Iterator[Signal]:
    found: dict[str, Quantity] = {}
    for of in (Plan, Rollout):
        for name, quantity in (quantities(of) | derived(of)).items():
            if quantity.listed and quantity.kind is not Kind.TEXT and quantity.axes[:1] == (TIME,):
                found.setdefault(_key(of, name), quantity)
    found.pop("time")
    for key, quantity in found.items():
        yield Signal(key, _title(key), _tabled(key, quantity), _LEAST.get(key, 0.0))


def _title(key: str) -> str:
    """Such as "Foot position"; the CoM's own quantity is its position."""
    words = f"{key}_position" if key.endswith("com") else key
    title = " ".join(_WORDS.get(word, word) for word in words.split("_"))
    return title[:1].upper() + title[1:]


def _key(of: type, name: str) -> str:
    # A plan's forces are those of contacts, of which a sole has four; a rollout's those of feet.
    if of is Rollout and name == "contact_force":
        return "foot_force"
    return recorded_name(name) if of is Rollout else name


def _tabled(key: str, quantity: Quantity) -> Callable[[TimeSeries], Samples | None]:
    def samples(series: TimeSeries) -> Samples | None:
        values = series.quantity(key)
        if values is None:
            return None
        if quantity.axes[-1] == TENSOR:
            values = entries(values)
        values = values.reshape(len(values), -1)
        components = _components(series.robot, quantity, values.shape[1])
        return Samples(series.time, tuple(components), values)

    return samples


def _components(robot: Robot, quantity: Quantity, count: int) -> Iterator[Component]:
    unit = quantity.unit.replace("m2", "m²")
    unit = unit or ", ".join(f"{i} {code}" for i, code in enumerate(quantity.codes))
    axes = quantity.axes[1:]
    if not axes:
        yield Component("", unit)
    elif axes == (JOINT,):
        for name, tags in _joint_tags(robot).items():
            yield Component(name, quantity.unit_of(name, robot.sliding_joints), tags)
    elif axes[0] in (LEG, CONTACT):
        parts = PARTS.get(axes[1], ()) if len(axes) > 1 else ()
        places = count // max(1, len(parts))
        corners = places // len(robot.legs)
        for place in range(places):
            leg = robot.legs[place // corners].name
            name = leg if corners == 1 else f"{leg} {place % corners + 1}"
            for part in parts or ("",):
                yield Component(f"{name} {part}".strip(), unit, (leg, part) if part else (leg,))
    else:
        for part in PARTS[axes[0]]:
            yield Component(part, unit)


# ---- derived quantities

_INERTIAS = 400  # at most, of a motion; they change slowly, and eigenvalues take their time
_MOMENTS = tuple(Component(name, "kg m²") for name in ("roll", "pitch", "yaw"))

_Values = Callable[[TimeSeries], Array | None]
_Columns = Callable[[TimeSeries, Array], tuple[list[Component], Array]]


def _sampled(of: _Values, columns: _Columns) -> Callable[[TimeSeries], Samples | None]:
    def samples(series: TimeSeries) -> Samples | None:
        values = of(series)
        if values is None:
            return None
        components, arranged = columns(series, values)
        return Samples(series.time, tuple(components), arranged)

    return samples


def _single(unit: str) -> _Columns:
    """(K,) as one component."""
    return lambda _, values: ([Component("", unit)], values[:, None])


def _each_joint(unit: str) -> _Columns:
    def columns(series: TimeSeries, values: Array) -> tuple[list[Component], Array]:
        tags = _joint_tags(series.robot).items()
        return [Component(name, unit, tags_of) for name, tags_of in tags], values

    return columns


def _each_kind(unit: str, together: Callable[..., Array]) -> _Columns:
    """(K, J) as a component for each kind of joints: their largest value, or their sum."""

    def columns(series: TimeSeries, values: Array) -> tuple[list[Component], Array]:
        tags = [*_joint_tags(series.robot).values()]
        kinds = joint_kinds(series.robot)
        found = [
            together(values[:, [kind == ALL_JOINTS or kind in of for of in tags]], axis=1)
            for kind in kinds
        ]
        return [Component(kind, unit) for kind in kinds], np.column_stack(found)

    return columns


def _base_angles(series: TimeSeries) -> Samples:
    R = rotation_matrices(series.motion.base_quat)
    angles = {
        "yaw": yaw(series.motion.base_quat),
        "pitch": -np.arcsin(np.clip(R[:, 2, 0], -1, 1)),
        "roll": np.unwrap(np.arctan2(R[:, 2, 1], R[:, 2, 2])),
    }
    components = tuple(Component(name, "°") for name in angles)
    return Samples(series.time, components, np.degrees(np.column_stack([*angles.values()])))


def _turned(series: TimeSeries) -> Samples:
    """The angle turned about each of the world's axes so far, which knows no half turn."""
    motion = series.motion
    rate, step = motion.angular_velocity, np.diff(motion.time)[:, None]
    angle = np.zeros_like(rate)
    angle[1:] = np.cumsum(0.5 * (rate[1:] + rate[:-1]) * step, axis=0)
    components = tuple(Component(axis, "°") for axis in "xyz")
    return Samples(motion.time, components, np.degrees(angle))


def _vertical_force(series: TimeSeries) -> Array | None:
    force = series.motion.foot_force
    return None if force is None else np.asarray(force[..., 2].sum(axis=1))


def _moments(series: TimeSeries) -> Samples:
    motion = series.motion
    kept = slice(None, None, 1 + len(motion.time) // _INERTIAS)
    moments = principal_moments(motion.robot, motion.inertia[kept], motion.base_quat[kept])
    return Samples(motion.time[kept], _MOMENTS, moments)


def _whole_body_moments(series: TimeSeries) -> Samples:
    time, inertia, quat = whole_body_inertia(series.motion)
    return Samples(time, _MOMENTS, principal_moments(series.robot, inertia, quat))


def _detection(series: TimeSeries) -> Array | None:
    rollout = series.rollout
    return None if rollout is None else rollout.detection_signal / abs(rollout.detection_threshold)


def _threshold(series: TimeSeries) -> float | None:
    rollout = series.rollout
    return None if rollout is None else float(np.sign(rollout.detection_threshold))


def _yaw_error(series: TimeSeries) -> Array | None:
    plan = series.planned
    if plan is None:
        return None
    followed = np.interp(series.time, plan.time, yaw(plan.base_quat))
    return np.degrees(yaw(series.motion.base_quat) - followed)


def _torque_share(series: TimeSeries) -> Array | None:
    torque = series.motion.joint_torque
    if torque is None:
        return None
    return torque_share(torque, np.broadcast_to(series.robot.torque_limit, torque.shape))


def _saturation(series: TimeSeries) -> Array | None:
    torque, limit = series.motion.joint_torque, series.motion.joint_torque_limit
    return None if torque is None or limit is None else torque_share(torque, limit)


def _speed_share(series: TimeSeries) -> Array | None:
    speed = series.motion.joint_velocity
    return torque_share(speed, np.broadcast_to(series.robot.speed_limit, speed.shape))


def _joint_power(series: TimeSeries) -> Array | None:
    torque = series.motion.joint_torque
    return None if torque is None else torque * series.motion.joint_velocity


def _electrical_power(series: TimeSeries) -> Array | None:
    power, windings = _joint_power(series), Windings.of(series.robot)
    if power is None or windings is None or series.motion.joint_torque is None:
        return None
    return power + windings.heating(series.motion.joint_torque)


_SHARES: Mapping[str, tuple[str, _Values]] = {
    "torque_share": ("Torque / limit", _torque_share),
    "saturation": ("Torque / limit at its speed", _saturation),
    "speed_share": ("Joint speed / limit", _speed_share),
}


def _share(key: str, title: str, of: _Values, columns: _Columns) -> Signal:
    # Twice a limit is shown: a plan that failed may need torque where there is none.
    samples = _sampled(of, columns)
    return Signal(key, title, samples, most=2.0, level=lambda _: 1.0, level_title="limit")


_DERIVED = (
    Signal("base_angle", "Base angle", _base_angles, least=2.0),
    Signal("turned", "Angle turned about", _turned, least=2.0),
    Signal("vertical_force", "Vertical force, all feet", _sampled(_vertical_force, _single("N"))),
    Signal(
        "principal_inertia",
        "Principal inertia",
        _moments,
        also=_whole_body_moments,
        also_title="whole body as planned",
    ),
    *(
        _share(
            f"largest_{key}", f"Largest {title[:1].lower()}{title[1:]}", of, _each_kind("", np.max)
        )
        for key, (title, of) in _SHARES.items()
    ),
    Signal(
        "power",
        "Power of the drives",
        _sampled(_joint_power, _each_kind("W", np.sum)),
        least=10.0,
    ),
    Signal(
        "electrical_power",
        "Power from the battery",
        _sampled(_electrical_power, _each_kind("W", np.sum)),
        least=10.0,
    ),
    *(_share(key, title, of, _each_joint("")) for key, (title, of) in _SHARES.items()),
    Signal("joint_power", "Joint power", _sampled(_joint_power, _each_joint("W"))),
    Signal(
        "average_spatial_velocity_norm",
        "Spatial velocity ‖v_G‖",
        _sampled(lambda series: series.average_spatial_velocity_norm, _single("")),
    ),
    Signal(
        "detection",
        "Detection signal / |threshold|",
        _sampled(_detection, _single("")),
        most=3.0,  # how far an impact goes beyond matters no more
        level=_threshold,
        level_title="threshold",
    ),
    Signal("yaw_error", "Yaw − planned yaw", _sampled(_yaw_error, _single("°")), least=1.0),
)

SIGNALS: Mapping[str, Signal] = {signal.key: signal for signal in (*_declared(), *_DERIVED)}
"""Key -> signal, in the order of menus; a derived one replaces a declared one of the same key."""

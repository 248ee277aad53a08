"""The limits that a request may change: where a task has each, in words and in range.

A constraint names its own (`limits_called`); their values are the robot file's.
"""

from dataclasses import dataclass, replace
from typing import Any

from pydantic import BaseModel

from llsrbm.planning.problem.task import Task


@dataclass(frozen=True)
class Limit:
    """A number in the bounds of a constraint that a request may change.

    Attributes:
        name: as in requests and files.
        title: the same in words.
        unit: SI; angles in rad.
        effect: what raising it does.
        lowest, highest: what is accepted; shares of the robot's own value if `relative`.
        place: where a `Task` has it: names of attributes, the index in a tuple.
        relative: see `lowest`; `llsrbm.planning.problem.limits.limits_of` has them in `unit`.
        lower_bound: whether raising it forbids more, instead of allowing more.
        states: whether it says how the robot is, not what a plan may use of it; no explanation
            asks for more of it.
    """

    name: str
    title: str
    unit: str
    effect: str
    lowest: float
    highest: float
    place: tuple[str | int, ...]
    relative: bool = False
    lower_bound: bool = False
    states: bool = False

    @property
    def loosest(self) -> float:
        """The end of the range that allows most."""
        return self.lowest if self.lower_bound else self.highest

    def of(self, task: Task) -> float:
        """The value that holds in a task."""
        value: Any = task
        for key in self.place:
            value = value[key] if isinstance(key, int) else getattr(value, key)
        return float(value)

    def put(self, task: Task, value: float) -> Task:
        """The task with another value."""
        return _put(task, self.place, value)


def _put(whole: Any, place: tuple[str | int, ...], value: float) -> Any:
    if not place:
        return value
    key, rest = place[0], place[1:]
    if isinstance(key, int):
        return (*whole[:key], _put(whole[key], rest, value), *whole[key + 1 :])
    part = _put(getattr(whole, key), rest, value)
    if isinstance(whole, BaseModel):
        return whole.model_copy(update={key: part})
    return replace(whole, **{key: part})


# fmt: off
_LIMITS = {limit.name: limit for limit in (
    Limit("friction", "coefficient of friction", "1",
          "feet may push sideways harder for the load they carry",
          0.1, 1.5, ("limits", "friction")),
    Limit("takeoff_min", "shortest take-off", "s",
          "take-off takes at least this long",
          0.1, 1.0, ("timing", "takeoff", 0), lower_bound=True),
    Limit("takeoff_max", "longest take-off", "s",
          "take-off may take longer", 0.15, 1.5, ("timing", "takeoff", 1)),
    Limit("flight_min", "shortest flight", "s",
          "flight takes at least this long", 0.1, 1.0, ("timing", "flight", 0), lower_bound=True),
    Limit("flight_max", "longest flight", "s",
          "flight may take longer", 0.15, 1.5, ("timing", "flight", 1)),
    Limit("landing_min", "shortest landing", "s",
          "landing takes at least this long", 0.1, 1.0, ("timing", "landing", 0), lower_bound=True),
    Limit("landing_max", "longest landing", "s",
          "landing may take longer", 0.15, 1.5, ("timing", "landing", 1)),
    Limit("apex_min", "lowest apex", "m",
          "the centre of mass flies at least so high above the ground at the start",
          0.0, 3.0, ("apex", 0), lower_bound=True),
    Limit("apex_max", "highest apex", "m",
          "the centre of mass may fly higher above the ground at the start",
          0.1, 5.0, ("apex", 1)),
    # Ranges of the box and of the distance stay near the robot file's: the maps of the legs are
    # fitted there, and the closed forms of the legs' drives hold there.
    Limit("reach_min", "shortest leg, hip to foot", "m",
          "legs fold less", 0.8, 1.4, ("reach", "distance", 0), relative=True, lower_bound=True),
    Limit("reach_max", "longest leg, hip to foot", "m",
          "legs may stretch further: knees get faster near the straight leg",
          0.75, 1.08, ("reach", "distance", 1), relative=True),
    Limit("reach_standing", "lowest hips above standing feet", "1",
          "robots crouch less before they jump and when they land; a share of standing upright",
          0.3, 0.95, ("reach", "standing"), lower_bound=True),
    Limit("reach_x_min", "lowest x of a foot from its hip", "m",
          "feet come less far behind their hips (mirrored hind legs: ahead)",
          0.4, 1.25, ("reach", "lower", 0), relative=True, lower_bound=True),
    Limit("reach_x_max", "highest x of a foot from its hip", "m",
          "feet may come further ahead of their hips (those: behind)",
          0.4, 1.25, ("reach", "upper", 0), relative=True),
    Limit("reach_y_min", "lowest y of a foot from its hip", "m",
          "feet come less far inward of their hips",
          0.4, 1.25, ("reach", "lower", 1), relative=True, lower_bound=True),
    Limit("reach_y_max", "highest y of a foot from its hip", "m",
          "feet may come further outward of their hips",
          0.4, 1.25, ("reach", "upper", 1), relative=True),
    Limit("reach_z_min", "lowest z of a foot from its hip", "m",
          "feet come less far below their hips",
          0.4, 1.25, ("reach", "lower", 2), relative=True, lower_bound=True),
    Limit("reach_z_max", "highest z of a foot from its hip", "m",
          "feet may come further up towards their hips",
          0.4, 1.25, ("reach", "upper", 2), relative=True),
    Limit("clearance", "clearance of the feet", "m",
          "feet are lifted higher in mid-flight",
          0.0, 0.3, ("limits", "clearance"), lower_bound=True),
    Limit("body_margin", "margin over obstacles", "m",
          "trunk, knees and feet pass higher over what they clear",
          0.0, 0.2, ("body_margin",), lower_bound=True),
    Limit("knee_margin", "margin of knees over the ground", "m",
          "knees of standing legs keep higher above the ground and what is landed on",
          0.0, 0.1, ("limits", "knee_margin"), lower_bound=True),
    Limit("legs_apart", "distance that legs side by side keep", "m",
          "legs stay further from each other in flight",
          0.0, 0.2, ("limits", "legs_apart"), lower_bound=True),
    Limit("feet_apart", "distance that feet keep", "m",
          "feet stay further from each other in flight: less of a twist comes from the inertia",
          0.0, 0.5, ("limits", "feet_apart"), lower_bound=True),
    Limit("foot_speed", "foot speed over the ground", "m/s",
          "feet may fly faster over the ground", 0.2, 3.0, ("limits", "foot_speed"), relative=True),
    Limit("foot_yaw_min", "furthest turn of a foot inward", "rad",
          "feet may turn inward less far",
          0.0, 1.25, ("foot", "yaw", 0), relative=True, lower_bound=True),
    Limit("foot_yaw_max", "furthest turn of a foot outward", "rad",
          "feet may turn outward further", 0.0, 1.25, ("foot", "yaw", 1), relative=True),
    Limit("foot_turn_speed", "turning speed of a foot", "rad/s",
          "feet may turn faster in flight", 0.2, 2.0, ("foot", "turn_speed"), relative=True),
    Limit("stop_margin", "margin to the joints' stops", "1",
          "joints keep further from their stops; a share of what lies between them",
          0.0, 0.2, ("limits", "stop_margin"), lower_bound=True),
    Limit("torque_share", "share of the drives' torque", "1",
          "plans may use more of the drives' torque; less of it is left for feedback",
          0.2, 3.0, ("limits", "torque_share")),
    Limit("speed_share", "share of the drives' speed", "1",
          "joints may turn faster; less is left for feedback", 0.2, 3.0, ("limits", "speed_share")),
    Limit("drive_strength", "strength of the drives", "1",
          "drives give more torque; a share of what the robot's file says",
          0.3, 1.5, ("drive_strength",), states=True),
    Limit("battery", "speed that the battery allows", "1",
          "drives turn faster before their torque falls; a share of what the robot's file says",
          0.5, 1.2, ("battery",), states=True),
)}
# fmt: on


def limits_called(*names: str) -> tuple[Limit, ...]:
    """The limits of these names."""
    return tuple(_LIMITS[name] for name in names)

"""From a request to a `Task`: checked, and placed in the world."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import InputError
from llsrbm.mechanics import quaternion_product, turns_about_z
from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.clearance_profile import check_footing
from llsrbm.planning.problem.costs import default_weights
from llsrbm.planning.problem.limits import Limit, check_limits, limits_in, put_limits
from llsrbm.planning.problem.passing import obstacle_of, passing
from llsrbm.planning.problem.stones import body_over, check_stones, offsets
from llsrbm.planning.problem.task import Footholds, Task, contact_points
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import Displacement, JumpType, load_type
from llsrbm.request.jump_types import names as jump_types
from llsrbm.request.route import FURTHEST, Landing, waypoints
from llsrbm.request.slopes import gradient, leaning, slopes_of
from llsrbm.request.tuning import Tuning
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import read_robot_file, robot_files

Array = NDArray[np.float64]

FASTEST = 1.5  # m/s at the start and at the end: a brisk walk of the largest robot


def limits_of(robot: Robot) -> dict[str, tuple[Limit, float]]:
    """Limit name -> the limit and the robot's own value; `lowest` and `highest` in its unit."""
    return limits_in(place_task(Jump(robot=robot.name), robot))


def make_task(
    jump: Jump,
    robot: Robot,
    weights: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
) -> Task:
    """Check the request and place it in the world.

    Whether the robot can jump so far is not asked here: a limit of the robot says so, when it is
    planned.

    Raises:
        InputError: a value beyond `FURTHEST`, a weight or a limit that is none, a jump type that is
            none or not for this robot, a gap or a bar that the type does not pass over, a foot
            where its leg does not reach.
    """
    _check_amounts(jump)
    for name in ("speed", "end_speed"):
        value = getattr(jump, name)
        if not 0 <= value <= FASTEST:
            raise InputError(f"{name} {value:g} m/s is out of range; expected 0 to {FASTEST:g} m/s")
    kind = load_type(jump.type)
    for where, given in (
        (f"{robot.path}: planning: ", robot.file.planning),
        (f"jump type {jump.type}: weights: ", kind.weights),
        ("", weights or {}),
    ):
        for name, weight in given.items():
            if name not in default_weights():
                valid = ", ".join(default_weights())
                raise InputError(f"{where}unknown weight {name!r}; the weights are {valid}")
            if not (np.isfinite(weight) and weight >= 0):
                raise InputError(
                    f"{where}weight {name}: expected a number of at least 0, got {weight}"
                )
    own = place_task(replace(jump, twist=0.0, forward=0.0, lateral=0.0, height=0.0), robot)
    if kind.limits:
        check_limits(kind.limits, own, robot.name)
    if limits:
        check_limits(limits, own, robot.name)
    task = place_task(jump, robot, Tuning(weights or {}, limits or {}))
    check_stones(task)
    check_footing(task)
    return task


def task_of(plan: Plan, robot: Robot) -> Task:
    """The task of a plan, under the weights and limits that it was planned under.

    Raises:
        InputError: see `make_task`.
    """
    return make_task(plan.jump, robot, plan.tuning.weights, plan.limits)


def _check_amounts(jump: Jump) -> None:
    for name, most in FURTHEST.items():
        unit, scale = ("deg", np.degrees(1.0)) if name == "twist" else ("m", 1.0)
        value = scale * getattr(jump, name)
        if not abs(value) <= scale * most + 1e-6:
            ends = f"{-scale * most:g} to {scale * most:g} {unit}"
            here = " (in Python and in files in rad)" if unit == "deg" else ""
            raise InputError(f"{name} {value:g} {unit} is out of range; expected {ends}{here}")


def check_turns(jump: Jump, robot: Robot) -> None:
    """Check that the robot makes the whole turns of a request, and that its type is one of them.

    Raises:
        InputError: it makes none about that axis, or the type asks for none.
    """
    axes, parameters = robot.file.turning_axes, load_type(jump.type).parameters
    for axis in ("roll", "pitch"):
        if not getattr(jump, axis):
            continue
        if axis not in axes:
            files = robot_files().values()
            others = [f.name for f in map(read_robot_file, files) if axis in f.turning_axes]
            raise InputError(
                f"{axis}: the file of {robot.name} allows {' and '.join(axes)} alone "
                f'("axes" of [turning]); robots that {axis}: {", ".join(others) or "none"}'
            )
        if axis not in parameters:
            types = [name for name, kind in jump_types().items() if axis in kind.parameters]
            raise InputError(
                f"{axis}: jumps of type {jump.type} do not turn so; expected the type "
                f'{" or ".join(types)}, or {axis} among "asks" in its file'
            )


def place_task(jump: Jump, robot: Robot, tuning: Tuning | None = None) -> Task:
    """Place the request in the world; its numbers are not checked.

    Raises:
        InputError: a jump type that is none, or not for this robot, or a stone of no leg of it.
    """
    tuning = tuning or Tuning()
    if jump.turns:
        robot = robot.turning
    kind = load_type(jump.type)
    schedule = kind.schedule(robot, jump)
    start = _start(jump, robot)
    obstacle = obstacle_of(jump, kind, start, robot)
    if kind.passes:
        assert obstacle is not None  # by `JumpType`
        own = passing(jump, obstacle, schedule.places, start, robot)
    else:
        own = kind.displacement
    displacement = _displacement(jump, kind, own, schedule.places)
    places = _places(jump, displacement, start, robot, schedule.places)
    end = places[-1]
    Rz = turns_about_z(end.heading)
    turns = round((jump.roll + jump.pitch) / (2 * np.pi))
    half = end.heading / 2
    quat = np.array([np.cos(half), 0.0, 0.0, np.sin(half)])
    start_quat = np.array([1.0, 0.0, 0.0, 0.0])
    start_quat, quat = (
        quaternion_product(leaning(place.lean), q)
        for place, q in ((places[0], start_quat), (end, quat))
    )
    task = Task(
        jump=jump,
        schedule=schedule,
        mass=float(robot.mass),
        places=places,
        start_position=np.array(robot.com),
        goal_position=Rz @ robot.com + end.origin + end.aside,
        start_quat=start_quat,
        goal_quat=-quat if turns % 2 else quat,
        start_velocity=np.array([jump.speed, 0.0, 0.0]),
        goal_velocity=Rz @ [jump.end_speed, 0.0, 0.0],
        corners=np.array(robot.corners),
        limits=robot.file.limits,
        reach=robot.file.reach,
        timing=robot.file.timing,
        foot=robot.file.foot,
        robot=robot,
        weights=default_weights() | robot.file.planning | kind.weights | dict(tuning.weights),
        tuning=tuning,
        obstacle=obstacle,
        clears=kind.clears,
        displacement=displacement,
    )
    return put_limits(put_limits(task, kind.limits), tuning.limits)


def _displacement(
    jump: Jump, kind: JumpType, own: tuple[Displacement, ...], count: int
) -> tuple[Displacement, ...] | tuple[Landing, ...]:
    """Where each of several jumps leads if the request as such does not say: `count`, or ().

    `own`: where the type says that they lead.
    """
    if own and jump.route:
        raise InputError(
            f'route: jump type "{kind.title}" says itself where its jumps lead; expected a route '
            "with a type that does not"
        )
    found = jump.route or own
    if found and len(found) != count:
        where = "route" if jump.route else f'jump type "{kind.title}"'
        raise InputError(
            f"{where}: {len(found)} displacements for {count} landings; expected {count}, or none"
        )
    return found


def _start(jump: Jump, robot: Robot) -> Footholds:
    """Where the feet stand at the start."""
    tilt = gradient(jump.takeoff_slope, jump.takeoff_cross_slope, 0.0)
    return _footholds(robot, np.array(robot.feet), _headings(robot), 0.0, np.zeros(3), tilt)


def _places(
    jump: Jump,
    displacement: Sequence[Displacement | Landing],
    start: Footholds,
    robot: Robot,
    count: int,
) -> tuple[Footholds, ...]:
    """Where the feet stand after each displacement; each along the heading after the one before.

    The request's stones are of the last one, at which every foot lands.
    """
    turning = robot.foot_coordinates > 3
    slopes = slopes_of(jump, count)
    places = [start]
    heading, shift = 0.0, np.zeros(3)
    for k in range(count):
        own = displacement[k] if displacement else None

        def moved(name: str, own: object = own) -> float:
            value = getattr(own, name, None)
            return float(getattr(jump, name) if value is None else value)

        step = [moved("forward"), moved("lateral"), moved("height")]
        shift = shift + turns_about_z(heading) @ step
        heading += moved("twist")
        stance = robot.feet
        if jump.stones and k == count - 1:
            stance = stance + offsets(jump.stones, robot)
        feet = stance @ turns_about_z(heading).T + shift
        tilt = gradient(*slopes[k + 1], heading)
        yaw = start.yaw + heading * turning
        places.append(_footholds(robot, feet, yaw, heading, shift, tilt))
    aside, by_feet = body_over(jump.stones, robot)
    last, Rz = places[-1], turns_about_z(heading)
    places[-1] = replace(last, aside=Rz @ aside, lean=last.lean + Rz[:2, :2] @ by_feet)
    return tuple(places)


def _footholds(
    robot: Robot, feet: Array, yaw: Array, heading: float, origin: Array, tilt: Array
) -> Footholds:
    """On a surface with a gradient `tilt` (2,) that goes through `origin`."""
    feet = feet.copy()
    feet[:, 2] += (feet - origin)[:, :2] @ tilt
    each = np.tile(tilt, (len(feet), 1))
    contacts = contact_points(feet, yaw, np.array(robot.corners), each)
    lean = tilt if robot.file.foot.is_point else np.zeros(2)  # on soles a body stands upright
    return Footholds(feet, yaw, contacts, each, heading, origin, lean=lean)


def _headings(robot: Robot) -> Array:
    """(L,) rad: where the feet look in the default posture."""
    if robot.foot_coordinates == 3:
        return np.zeros(len(robot.legs))
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.posture)
    ahead = np.array([data.oMf[leg.foot_frame_id].rotation[:, 0] for leg in robot.legs])
    headings: Array = np.arctan2(ahead[:, 1], ahead[:, 0])
    return headings


def describe(jump: Jump) -> str:
    """A request in words, for messages."""
    if jump.route:
        end = waypoints(jump.route)[-1]
        return (
            f"a route of {len(jump.route)} landings to ({end.x:.2f}, {end.y:.2f}, {end.z:.2f}) m, "
            f"{np.degrees(end.heading):.0f} deg, {jump.model}"
        )
    return (
        f"twist {np.degrees(jump.twist):g} deg, forward {jump.forward:g} m, "
        f"lateral {jump.lateral:g} m, height {jump.height:g} m, {jump.model}"
    )


def retargeted(task: Task, jump: Jump) -> Task:
    """The task of another jump, under the same limits; what it was asked for is kept."""
    return replace(
        place_task(jump, task.robot, task.tuning),
        limits=task.limits,
        reach=task.reach,
        timing=task.timing,
        foot=task.foot,
        body_margin=task.body_margin,
        apex=task.apex,
        correction=task.correction,
        agreed_bounds=task.agreed_bounds,
        requested=task.requested or task.jump,
        penalty=task.penalty,
    )

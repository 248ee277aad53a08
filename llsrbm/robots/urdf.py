"""A robot file's URDF: found, as Pinocchio's model, and held against what the file says of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin

from llsrbm.errors import RobotFileError, printable
from llsrbm.request.messages import choices
from llsrbm.request.tables import LARGEST
from llsrbm.robots.description import Description, installed_shares
from llsrbm.robots.description.changes import STOP
from llsrbm.robots.description.mesh_paths import LONGEST_PATH, is_there
from llsrbm.robots.drives.table import Motor
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import RobotFile

BASE_JOINT = 1  # Pinocchio's index of the free flyer; 0 is the universe.
ROUNDED = 1e-9  # of a flat body's largest moment, by which rounded ones exceed their sum
_LEAST_LIMIT = 1e-6  # Nm, N, rad/s or m/s: a joint of less does not move
_LIGHTEST, _SLIMMEST = 1e-12, 1e-15  # kg and kg m2 of what can be simulated


def find_urdf(file: RobotFile, path: Path) -> Path:
    """The URDF a robot file names."""
    source = file.urdf
    if source.file is not None:
        urdf = path.parent / source.file
        if not is_there(urdf):
            raise RobotFileError(
                f"{path}: urdf.file: no such file: {printable(str(urdf), LONGEST_PATH)}"
            )
        return urdf
    package, inner = source.installed()
    robots = package_share(package, path) / package / "robots"
    urdf = robots / inner
    if not is_there(urdf):
        present = sorted(p.relative_to(robots).as_posix() for p in robots.rglob("*.urdf"))
        raise RobotFileError(
            f'{path}: urdf.path: package {package} has no "{printable(inner, LONGEST_PATH)}"; '
            f"{choices(inner, present)}"
        )
    return urdf


def package_share(package: str, robot_file: Path) -> Path:
    """The folder `share` of an installed package of robot data; robots are in `share/<package>`."""
    for share in installed_shares():
        if (share / package / "robots").is_dir():
            return share
    raise RobotFileError(
        f'{robot_file}: urdf.package: no robot data of a package "{package}" is installed; '
        f"expected a folder share/{package}/robots, as `pip install example-robot-data` makes it"
    )


def pinocchio_model(robot: Description, where: str) -> pin.Model:
    """Pinocchio's model of a URDF, on a free flyer. Raises `RobotFileError`: Pinocchio refuses it,
    or no joint of it moves.
    """
    try:
        model = pin.buildModelFromXML(robot.skeleton, pin.JointModelFreeFlyer())
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise RobotFileError(f"{where} is refused by Pinocchio: {reason}") from error
    moving = {name for name, joint in robot.joints.items() if joint.moves}
    if set(model.names[BASE_JOINT + 1 :]) != moving or not moving:
        raise RobotFileError(f"{where} is not the URDF of a robot with legs: no joint moves")
    return model


def check_moving(robot: Description, model: pin.Model, where: str) -> None:
    """Raise `RobotFileError` unless joints move freely, and bodies have inertias that can be."""
    for name, joint in robot.joints.items():
        if not joint.moves:
            continue
        limit, of_joint = joint.limit, f'{where}: joint "{name}"'
        if joint.mimic is not None:
            raise RobotFileError(
                f"{of_joint} mimics {joint.mimic.joint}: no joint can follow another; expected it "
                'without <mimic>, type="fixed", or both held in [urdf.held]'
            )
        if joint.kind != "continuous" and (limit is None or limit.lower == limit.upper):
            given = "no <limit>" if limit is None else f"lower = upper = {limit.lower:g}"
            raise RobotFileError(
                f'{of_joint} has {given}; expected <limit lower="..." upper="...">, '
                'type="continuous", or it held in [urdf.held]'
            )
        lower, upper = (0.0, 0.0) if limit is None else (limit.lower, limit.upper)
        if joint.kind != "continuous" and max(-lower, upper) > LARGEST:
            raise RobotFileError(
                f"{of_joint} has lower = {lower:g} and upper = {upper:g} {joint.unit}; expected "
                f'numbers up to {LARGEST:g} either way, or type="continuous"'
            )
    for body in range(BASE_JOINT, model.njoints):
        fault = _impossible(model.inertias[body])
        if fault:
            links = [frame.name for frame in bodies_on(model, body)]
            shown = f'link "{links[0]}"'
            if len(links) > 1:
                more = f" and {len(links) - 4} more" if len(links) > 4 else ""
                shown += f" with what is fixed to it ({', '.join(links[1:4])}{more})"
            raise RobotFileError(f"{where}: {shown} {fault}")


def check_limits(robot: Robot, where: str) -> None:
    """Raise `RobotFileError` unless every joint has a torque and a speed."""
    legs = {joint for leg in robot.legs for joint in leg.joints}
    for limit, key, values in (
        ("effort", "torque", robot.torque_limit),
        ("velocity", "joint_speed", robot.speed_limit),
    ):
        for name, value in zip(robot.joint_names, values, strict=True):
            if _LEAST_LIMIT <= value <= LARGEST:
                continue
            if name in legs and getattr(robot.file.limits, key) is not None:
                raise RobotFileError(
                    f"{robot.path}: limits.{key}: expected {_LEAST_LIMIT:g} to {LARGEST:g}, got "
                    f"{value:g} for {name}"
                )
            other = f"limits.{key} in the robot file" if name in legs else "the joint held"
            raise RobotFileError(
                f'{where}: joint "{name}": <limit {limit}="{value:g}">: expected more than 0 '
                f"and at most {LARGEST:g}, or {other}"
            )


def check_posture(robot: Robot) -> None:
    """Raise `RobotFileError` unless the default posture is within the URDF's stops."""
    lower, upper = robot.joint_stops
    for limb in (*robot.legs, *robot.arms):
        for joint in limb.joints:
            k = robot.joint_names.index(joint)
            angle, unit = robot.posture[7 + k], "m" if joint in robot.sliding_joints else "rad"
            if not lower[k] - STOP <= angle <= upper[k] + STOP:
                raise RobotFileError(
                    f"{robot.path}: posture.{limb.name}: expected {lower[k]:g} to {upper[k]:g} "
                    f"{unit} for {joint}, as the URDF limits it, got {angle:g}"
                )


def check_drives(robot: Robot) -> None:
    """Raise `RobotFileError` unless [drives] fits the joints of legs and arms."""
    drives, electrical = robot.file.drives, robot.file.drives.electrical
    losses, motor = ("armature", "friction", "damping"), tuple(Motor.model_fields)
    for table, numbers, names, limbs in (
        ("drives", drives, losses, robot.legs),
        ("drives.arms", drives.arms, losses, robot.arms),
        ("drives.electrical", electrical, motor, robot.legs),
        ("drives.electrical.arms", electrical and electrical.arms, motor, robot.arms),
    ):
        for name in names:
            given = getattr(numbers, name, None)
            if given is not None and not limbs:
                raise RobotFileError(
                    f"{robot.path}: {table}.{name}: the robot has no arms; expected none"
                )
            if isinstance(given, tuple) and len(given) != len(limbs[0].joints):
                raise RobotFileError(
                    f"{robot.path}: {table}.{name}: expected one number, or "
                    f"{len(limbs[0].joints)}, one a joint ({', '.join(limbs[0].joints)}), got "
                    f"{len(given)}"
                )
    if electrical is not None and electrical.arms is None and robot.arms:
        for name in motor:
            if isinstance(getattr(electrical, name), tuple):
                raise RobotFileError(
                    f"{robot.path}: drives.electrical.{name}: is of the legs' joints; expected one "
                    "number, or drives.electrical.arms beside it"
                )
    for name, friction, torque in zip(
        robot.joint_names, robot.friction, robot.rated_torque, strict=True
    ):
        if friction >= torque:
            raise RobotFileError(
                f"{robot.path}: drives.friction: expected less than the torque of {name}, "
                f"{torque:g}, got {friction:g}"
            )
    for joint in drives.joints:
        if joint not in robot.joint_names:
            raise RobotFileError(
                f"{robot.path}: drives.joints.{joint}: no such joint; "
                f"{choices(joint, robot.joint_names)}"
            )


def _impossible(body: pin.Inertia) -> str:
    """Why a body with this inertia cannot move; empty if it can."""
    if body.mass <= _LIGHTEST:
        return f"has {body.mass:g} kg and moves; expected a mass"
    a, b, c = np.linalg.eigvalsh(body.inertia)
    moments = f"has the principal inertias {a:.3g}, {b:.3g} and {c:.3g} kg m2"
    if a <= _SLIMMEST:
        return f"{moments} and moves; expected more than 0"
    if a + b < c * (1 - ROUNDED):
        return f"{moments}, which no body has; expected none above the sum of the other two"
    return ""


def bodies_on(model: pin.Model, joint: int) -> list[pin.Frame]:
    """Frames of the links that a joint moves, in the order of the URDF."""
    body = pin.FrameType.BODY
    return [each for each in model.frames if each.parentJoint == joint and each.type == body]


def frame_id(model: pin.Model, name: str) -> int:
    """Index of the frame; a joint of the same name may come before the body that is meant."""
    if model.existFrame(name, pin.FrameType.BODY):
        return int(model.getFrameId(name, pin.FrameType.BODY))
    return int(model.getFrameId(name))


def joint_chain(model: pin.Model, file: RobotFile, path: Path, limb: str) -> list[int]:
    """Joint indices of a leg or an arm, base outwards.

    Raises `RobotFileError` where the file does not fit.
    """
    leg = file.legs.get(limb)
    end = file.arms[limb].hand if leg is None else leg.foot
    key = f"arms.{limb}.hand" if leg is None else f"legs.{limb}.foot"
    if not any(frame.name == end for frame in model.frames):
        # The first two are the world and the free flyer, which Pinocchio adds to the URDF.
        frames = dict.fromkeys(frame.name for frame in list(model.frames)[2:])
        raise RobotFileError(
            f'{path}: {key}: the URDF has no frame "{end}"; {choices(end, frames)}'
        )
    chain: list[int] = []
    joint = model.frames[frame_id(model, end)].parentJoint
    while joint > BASE_JOINT:
        chain.insert(0, joint)
        joint = model.parents[joint]
    names = [model.names[j] for j in chain]
    if not names:
        raise RobotFileError(
            f'{path}: {key}: no joint moves frame "{end}" against the base; '
            f"expected a frame at the end of {'an arm' if leg is None else 'a leg'}"
        )
    if leg is not None and leg.hip not in names:
        raise RobotFileError(
            f'{path}: legs.{limb}.hip: no joint "{leg.hip}" lies between the base and '
            f'"{end}"; {choices(leg.hip, names)}'
        )
    for joint, name in zip(chain, names, strict=True):
        if model.joints[joint].nq != 1:
            raise RobotFileError(
                f'{path}: {key}: joint "{name}" is neither revolute nor prismatic '
                f"({model.joints[joint].shortname()})"
            )
    angles = file.posture[limb]
    if len(angles) != len(chain):
        raise RobotFileError(
            f"{path}: posture.{limb}: expected {len(chain)} joint angles ({', '.join(names)}), "
            f"got {len(angles)}"
        )
    for limit in ("torque", "joint_speed") if leg is not None else ():
        given = getattr(file.limits, limit)
        if isinstance(given, tuple) and len(given) != len(chain):
            raise RobotFileError(
                f"{path}: limits.{limit}: expected one number, or {len(chain)}, one a joint of a "
                f"leg ({', '.join(names)}), got {len(given)}"
            )
    return chain


def check_joints(
    model: pin.Model, file: RobotFile, path: Path, chains: dict[str, list[int]]
) -> None:
    """Raise `RobotFileError` unless a joint belongs to one limb, and legs and arms are alike."""
    owner: dict[int, str] = {}
    for limb, chain in chains.items():
        for joint in chain:
            if joint in owner:
                table, kind = ("legs", "leg") if limb in file.legs else ("arms", "limb")
                name = model.names[joint]
                raise RobotFileError(
                    f'{path}: {table}.{limb}: joint "{name}" also belongs to {kind} '
                    f"{owner[joint]}; expected each {kind} to have joints of its own, or {name} "
                    "held in [urdf.held] if it moves all feet"
                )
            owner[joint] = limb
    free = [model.names[j] for j in range(BASE_JOINT + 1, model.njoints) if j not in owner]
    if free:
        raise RobotFileError(
            f"{path}: legs: joints {', '.join(free)} of {file.urdf.path or file.urdf.file} belong "
            f"to no leg; expected every joint to move a foot or a hand, or to be held at an angle: "
            f"{free[0]} = 0.0 in [urdf.held]"
        )
    kinds = {
        leg: tuple(model.joints[j].shortname().startswith("JointModelP") for j in chain)
        for leg, chain in chains.items()
    }
    for table, limbs in (("leg", file.legs), ("arm", file.arms)):
        first = next(iter(limbs), "")
        for limb in limbs:
            if kinds[limb] != kinds[first]:
                raise RobotFileError(
                    f"{path}: {table}s.{limb}: its joints differ in number or kind from those of "
                    f"{table} {first}; expected all {table}s alike"
                )

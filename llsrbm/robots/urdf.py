"""A robot file's URDF: found, read, and held against what the file says about it."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pinocchio as pin

from llsrbm.errors import RobotFileError
from llsrbm.request.messages import choices
from llsrbm.robots.schema import RobotFile

BASE_JOINT = 1  # Pinocchio's index of the free flyer; 0 is the universe.


def find_urdf(file: RobotFile, path: Path) -> tuple[Path, tuple[Path, ...]]:
    """The URDF a robot file names, and where its `package://` names are looked up."""
    source = file.urdf
    if source.file is not None:
        urdf = path.parent / source.file
        if not urdf.is_file():
            raise RobotFileError(f"{path}: urdf.file: no such file: {urdf}")
        return urdf, (path.parent, path.parent.parent)
    package, inner = source.installed()
    share = package_share(package, path)
    robots = share / package / "robots"
    urdf = robots / inner
    if not urdf.is_file():
        present = sorted(p.relative_to(robots).as_posix() for p in robots.rglob("*.urdf"))
        raise RobotFileError(
            f'{path}: urdf.path: package {package} has no "{inner}"; {choices(inner, present)}'
        )
    return urdf, (share,)


def package_share(package: str, robot_file: Path) -> Path:
    """The folder `share` of an installed package of robot data; robots are in `share/<package>`."""
    roots = [Path(entry) for entry in sys.path if entry]
    roots = [*(root / "cmeel.prefix" for root in roots), Path(sys.prefix)]
    for root in roots:
        if (root / "share" / package / "robots").is_dir():
            return root / "share"
    raise RobotFileError(
        f'{robot_file}: urdf.package: no robot data of a package "{package}" is installed; '
        f"expected a folder share/{package}/robots, as `pip install example-robot-data` makes it"
    )


def load_model(urdf_path: Path, path: Path) -> pin.Model:
    """Pinocchio's model of a URDF, on a free flyer."""
    try:
        model = pin.buildModelFromUrdf(str(urdf_path), pin.JointModelFreeFlyer())
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise RobotFileError(f"{path}: urdf: {urdf_path} is not a URDF: {reason}") from error
    if model.njoints <= BASE_JOINT + 1:
        # The parser reports some mistakes on stderr only and returns an empty robot.
        raise RobotFileError(
            f"{path}: urdf: {urdf_path} is not the URDF of a robot with legs: no joint was read"
        )
    return model


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
                raise RobotFileError(
                    f'{path}: {table}.{limb}: joint "{model.names[joint]}" also belongs to {kind} '
                    f"{owner[joint]}; expected each {kind} to have joints of its own"
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


def collision_geometry(
    model: pin.Model, urdf_path: Path, package_dirs: tuple[Path, ...], path: Path
) -> list[pin.GeometryObject]:
    """A URDF's collision geometry, placed in the frames of the model's joints."""
    return _geometry(model, urdf_path, package_dirs, path, pin.GeometryType.COLLISION)


def visual_geometry(
    model: pin.Model, urdf_path: Path, package_dirs: tuple[Path, ...], path: Path
) -> list[pin.GeometryObject]:
    """A URDF's visual geometry, in the same way."""
    return _geometry(model, urdf_path, package_dirs, path, pin.GeometryType.VISUAL)


def _geometry(
    model: pin.Model,
    urdf_path: Path,
    package_dirs: tuple[Path, ...],
    path: Path,
    kind: pin.GeometryType,
) -> list[pin.GeometryObject]:
    folders = [str(directory) for directory in package_dirs]
    try:
        geometry = pin.buildGeomFromUrdf(model, str(urdf_path), kind, package_dirs=folders)
    except (ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise RobotFileError(
            f"{path}: urdf: the {kind.name.lower()} geometry of {urdf_path} cannot be read: "
            f"{reason}"
        ) from error
    return list(geometry.geometryObjects)


def mesh_files(urdf_path: Path) -> list[str]:
    """Names of the meshes in a URDF."""
    urdf = urdf_path.read_text(encoding="utf-8")
    return re.findall(r'filename\s*=\s*["\']([^"\']+)["\']', urdf)


def mesh_path(urdf_path: Path, package_dirs: tuple[Path, ...], name: str) -> Path | None:
    """The file of a mesh; None if it is missing."""
    relative = name.removeprefix("package://").removeprefix("file://")
    candidates = [urdf_path.parent / relative]
    candidates += [directory / relative for directory in package_dirs]
    return next((candidate for candidate in candidates if candidate.is_file()), None)


def mesh_stamps(urdf_path: Path, package_dirs: tuple[Path, ...]) -> list[str]:
    """Names, sizes and times of a URDF's meshes: they are read again when one of these changes."""
    stamps = []
    for name in mesh_files(urdf_path):
        path = mesh_path(urdf_path, package_dirs, name)
        if path is not None:
            status = path.stat()
            stamps.append(f"{name} {status.st_size} {status.st_mtime_ns}")
    return stamps

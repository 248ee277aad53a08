"""The URDF as a robot file wants it: joints that are held made fixed, frames added.

The changed URDF is a file in the user's cache. All that reads a robot's URDF reads that file:
Pinocchio, MuJoCo, pictures, exports, the hashes that a robot is known by. Nothing of this machine
is in it: names of meshes that were relative to the URDF are looked up in its folder, which joins
the folders of `package://` names.
"""

from __future__ import annotations

import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path, PurePosixPath

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.cache import cache_path, content_key, write_atomically
from llsrbm.errors import RobotFileError
from llsrbm.request.messages import choices
from llsrbm.robots.schema import AddedFrame, UrdfSource

Array = NDArray[np.float64]

_TURNS, _SLIDES = ("revolute", "continuous"), ("prismatic",)
_OF_FIXED_JOINTS = ("origin", "parent", "child")  # what of a joint a fixed one keeps
_DIGITS = 12  # after the point, so that machines agree on the text and thus on its hash
_STOP = 1e-4  # rad or m by which an angle may exceed a limit: both are rounded in files


def adapted_urdf(
    urdf: Path,
    package_dirs: tuple[Path, ...],
    source: UrdfSource,
    feet: Mapping[str, str],
    path: Path,
) -> tuple[Path, tuple[Path, ...]]:
    """The URDF to read, and where its `package://` names are looked up.

    Args:
        urdf, package_dirs: as they are; without changes in `source` they come back.
        source: what is held and added.
        feet: leg -> frame of its foot; joints that move one cannot be held.
        path: of the robot file, for messages.

    Raises:
        RobotFileError: a joint or link is not there, an angle is beyond its joint's limits, or a
            held joint moves a foot.
    """
    if not source.held and not source.frames:
        return urdf, package_dirs
    try:
        robot = ET.parse(urdf).getroot()  # noqa: S314  the user's own file, as Pinocchio reads it
        # Frames first: a foot may be one, and what carries it must not be held either.
        for name, frame in source.frames.items():
            _add_frame(robot, name, frame, path)
        _check_no_foot_is_held(robot, source.held, feet, path)
        for name, angle in source.held.items():
            _hold(robot, name, angle, path)
    except (ET.ParseError, ValueError) as error:  # ValueError: where numbers should be
        raise RobotFileError(f"{path}: urdf: {urdf} is not a URDF: {error}") from error
    _keep_meshes_findable(robot)
    text = ET.tostring(robot, encoding="unicode")
    return _stored(text.encode(), path), (urdf.parent, *package_dirs)


def _add_frame(robot: ET.Element, name: str, frame: AddedFrame, path: Path) -> None:
    links = [link.attrib.get("name", "") for link in robot.findall("link")]
    taken = {*links, *(joint.attrib.get("name", "") for joint in robot.findall("joint"))}
    if name in taken or f"{name}_fixed" in taken:
        raise RobotFileError(
            f'{path}: urdf.frames.{name}: the URDF has a link or joint of that name, or "'
            f'{name}_fixed"; expected a new name'
        )
    if frame.link not in links:
        raise RobotFileError(
            f'{path}: urdf.frames.{name}.link: the URDF has no link "{frame.link}"; '
            f"{choices(frame.link, links)}"
        )
    link = ET.SubElement(robot, "link", name=name)
    if frame.radius is not None:
        geometry = ET.SubElement(ET.SubElement(link, "collision"), "geometry")
        ET.SubElement(geometry, "sphere", radius=repr(frame.radius))
    joint = ET.SubElement(robot, "joint", name=f"{name}_fixed", type="fixed")
    ET.SubElement(joint, "origin", xyz=_numbers(frame.xyz), rpy=_numbers(frame.rpy))
    ET.SubElement(joint, "parent", link=frame.link)
    ET.SubElement(joint, "child", link=name)


def _hold(robot: ET.Element, name: str, angle: float, path: Path) -> None:
    """Make a joint a fixed one where it is at an angle: rad, or m if it slides."""
    movable = _movable(robot)
    if name not in movable:
        raise RobotFileError(
            f'{path}: urdf.held: the URDF has no joint "{name}" that turns or slides; '
            f"{choices(name, movable)}"
        )
    joint = movable[name]
    slides = joint.attrib["type"] in _SLIDES
    limit = joint.find("limit")
    if limit is not None and joint.attrib["type"] != "continuous":
        lower, upper = (float(limit.attrib.get(end, 0.0)) for end in ("lower", "upper"))
        if not lower - _STOP <= angle <= upper + _STOP:
            raise RobotFileError(
                f"{path}: urdf.held.{name}: expected {lower:g} to {upper:g} "
                f"{'m' if slides else 'rad'}, as the URDF limits it, got {angle:g}"
            )
    if angle:
        _move(joint, angle, slides=slides)
    joint.attrib["type"] = "fixed"
    for part in [part for part in joint if part.tag not in _OF_FIXED_JOINTS]:
        joint.remove(part)


def _move(joint: ET.Element, angle: float, *, slides: bool) -> None:
    """Let a joint's origin be where the joint takes its child at an angle."""
    origin, axis = joint.find("origin"), joint.find("axis")
    if origin is None:
        origin = ET.SubElement(joint, "origin")
    xyz, rpy = (_vector(origin.attrib.get(key), (0.0, 0.0, 0.0)) for key in ("xyz", "rpy"))
    along = _vector(None if axis is None else axis.attrib.get("xyz"), (1.0, 0.0, 0.0))
    along = along / np.linalg.norm(along)
    rotation = pin.rpy.rpyToMatrix(rpy)
    if slides:
        xyz = xyz + rotation @ along * angle
    else:
        rpy = pin.rpy.matrixToRpy(rotation @ pin.AngleAxis(angle, along).toRotationMatrix())
    origin.attrib.update(xyz=_numbers(xyz), rpy=_numbers(rpy))


def _check_no_foot_is_held(
    robot: ET.Element, held: Mapping[str, float], feet: Mapping[str, str], path: Path
) -> None:
    joints = {joint.attrib.get("name", ""): joint for joint in robot.findall("joint")}
    carries = {_link(joint, "child"): (name, joint) for name, joint in joints.items()}
    moving: dict[str, str] = {}  # joint -> a leg whose foot it moves
    for leg, frame in feet.items():
        # A foot's frame may be a link or a joint; what the URDF does not have is told later.
        link = _link(joints[frame], "child") if frame in joints else frame
        while link in carries:
            name, joint = carries.pop(link)  # taken out: a URDF with a ring of joints ends, too
            moving[name] = leg
            link = _link(joint, "parent")
    for name in held:
        if name in moving:
            others = [joint for joint in _movable(robot) if joint not in moving]
            raise RobotFileError(
                f"{path}: urdf.held.{name}: it moves the foot of leg {moving[name]}; expected "
                f"joints that move no foot: {', '.join(others) or 'there are none'}"
            )


def _keep_meshes_findable(robot: ET.Element) -> None:
    for tag in ("mesh", "texture"):
        for part in robot.iter(tag):
            name = part.attrib.get("filename", "")
            if name and "://" not in name and not PurePosixPath(name).is_absolute():
                part.attrib["filename"] = f"package://{name}"


def _movable(robot: ET.Element) -> dict[str, ET.Element]:
    return {
        joint.attrib.get("name", ""): joint
        for joint in robot.findall("joint")
        if joint.attrib.get("type") in (*_TURNS, *_SLIDES)
    }


def _link(joint: ET.Element, end: str) -> str:
    part = joint.find(end)
    return "" if part is None else part.attrib.get("link", "")


def _vector(text: str | None, default: tuple[float, float, float]) -> Array:
    return np.array(default if text is None else [float(number) for number in text.split()])


def _numbers(values: Iterable[float]) -> str:
    return " ".join(repr(round(float(value), _DIGITS) + 0.0) for value in values)


def _stored(content: bytes, path: Path) -> Path:
    """A file with that content: in the cache, or of this process if nothing can be written there.

    It is touched only if it has to be: robots are read again when their files change.
    """
    in_cache = cache_path("urdf", content_key("urdf", content), ".urdf")
    for folder in (lambda: in_cache.parent, lambda: Path(_temporary_folder().name)):
        try:
            file: Path = folder() / in_cache.name
            if not file.is_file() or file.read_bytes() != content:
                write_atomically(file, content)
        except OSError:
            continue
        return file
    raise RobotFileError(
        f"{path}: urdf: the URDF with its held joints can be written neither to the cache nor to "
        f"{tempfile.gettempdir()}; expected room in one"
    )


@cache
def _temporary_folder() -> tempfile.TemporaryDirectory[str]:
    return tempfile.TemporaryDirectory(prefix="llsrbm-urdf-")

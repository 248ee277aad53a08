"""Rotors of a robot's drives, as far as its URDF, links or transmissions, or its SRDF has them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from llsrbm.errors import RobotFileError, printable
from llsrbm.robots.description.elements import Part
from llsrbm.robots.description.mesh_paths import is_there
from llsrbm.robots.description.parts import Description, Inertial, Joint
from llsrbm.robots.description.source import read_xml

_ROTOR = "_rotor"  # after the name of the link that it turns
_PARAMETERS = "rotor_params"
_DRAKE = "{http://drake.mit.edu}"  # namespace of Drake's elements


def rotor_links(robot: Description) -> dict[str, float]:
    """Joint -> inertia of its rotor about the joint's axis, kg m2, before the gear.

    As in Unitree's URDFs: the link `FR_hip_rotor`, fixed to what carries the joint of `FR_hip`.
    """
    found = {}
    carried = {joint.child: joint for joint in robot.joints.values()}
    for name, link in robot.links.items():
        joint = carried.get(name.removesuffix(_ROTOR))
        if joint is None or not name.endswith(_ROTOR) or link.inertial is None or not joint.moves:
            continue
        fixed = carried[name]
        inertia = _about_axis(joint, fixed, link.inertial)
        if fixed.parent == joint.parent and not fixed.moves and inertia > 0:
            found[joint.name] = inertia
    return found


def _about_axis(joint: Joint, fixed: Joint, inertial: Inertial) -> float:
    """Moment of inertia, kg m2, of what is fixed to a joint's parent, about its axis."""
    xx, xy, xz, yy, yz, zz = inertial.inertia
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    rotation = fixed.origin.placement.rotation @ inertial.origin.placement.rotation
    axis = joint.origin.placement.rotation @ joint.axis
    axis = rotation.T @ axis / np.linalg.norm(axis)
    return float(axis @ inertia @ axis)


def transmission_rotors(robot: Description) -> dict[str, float]:
    """Joint -> inertia of its rotor, kg m2 as the joint feels it, by the URDF's transmissions.

    These have them in Drake's words: `<drake:rotor_inertia value=""/>`, kg m2 before the gear, and
    `<drake:gear_ratio value=""/>` in an `<actuator>`; a gear that is not there is none. Raises
    `RobotFileError`: a number that is none.
    """
    found: dict[str, float] = {}
    for transmission in read_xml(robot.file, str(robot.file), "a URDF").iterfind("transmission"):
        joint, actuator = transmission.find("joint"), transmission.find("actuator")
        name = "" if joint is None else joint.get("name", "")
        if actuator is None or name not in robot.joints:
            continue
        numbers = {"rotor_inertia": 0.0, "gear_ratio": 1.0}
        for element in actuator:
            key = element.tag.rpartition("}")[2]
            if element.tag.startswith(_DRAKE) and key in numbers:
                part = Part(element, f'{robot.file}: transmission of "{printable(name)}": {key}')
                numbers[key] = part.number("value")
                part.not_negative(value=numbers[key])
        if inertia := numbers["rotor_inertia"] * numbers["gear_ratio"] ** 2:
            found[name] = inertia
    return found


def srdf_rotors(robot: Description) -> tuple[dict[str, float], str]:
    """Joint -> inertia of its rotor, kg m2 as the joint feels it, and the SRDF that says so.

    Its `<rotor_params><joint name="" mass="" gear_ratio=""/>` as example-robot-data has them: the
    rotor's inertia, kg m2, and the gear. SRDFs beside the URDF and in the folder `srdf` beside its
    folder are looked at, the one of its name first. Empty where none has rotors of its joints.
    Raises `RobotFileError`: one that has rotors is no SRDF, or has a number that is none.
    """
    folders = robot.file.parent, robot.file.parent.parent / "srdf"
    files = {file for folder in folders for file in folder.glob("*.srdf") if is_there(file)}
    for file in sorted(files, key=lambda file: (file.stem != robot.file.stem, file.name)):
        if _has_parameters(file) and (found := _parameters(robot, file)):
            return found, file.name
    return {}, ""


def _has_parameters(file: Path) -> bool:
    """Whether it speaks of rotors: others need not be in order."""
    try:
        content = file.read_bytes()
    except OSError as error:
        raise RobotFileError(f"{file} cannot be read: {error.strerror}") from error
    return any(_PARAMETERS.encode(code) in content for code in ("utf-8", "utf-16-le", "utf-16-be"))


def _parameters(robot: Description, file: Path) -> dict[str, float]:
    found: dict[str, float] = {}
    named: set[str] = set()
    root = read_xml(file, str(file), "an SRDF")
    for element in root.iterfind(f"{_PARAMETERS}/joint"):
        name = Part(element, f"{file}: {_PARAMETERS}").text("name")
        part = Part(element, f'{file}: {_PARAMETERS}: joint "{printable(name)}"')
        part.check(("name", "mass", "gear_ratio"), strict=True)
        if name in named:
            raise part.fault("it is there twice; expected one")
        named.add(name)
        inertia, gear = part.number("mass"), part.number("gear_ratio")
        part.not_negative(mass=inertia, gear_ratio=gear)
        if name in robot.joints and inertia * gear:
            found[name] = inertia * gear**2
    return found

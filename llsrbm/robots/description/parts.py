"""A robot as its URDF describes it, as plain data: links, joints, and the solids of links.

Rotations are as URDFs have them: roll, pitch and yaw about fixed axes, rad.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
import pinocchio as pin

from llsrbm.errors import RobotFileError

Vector = tuple[float, float, float]
Kind = Literal["box", "sphere", "cylinder", "capsule", "mesh"]

ZERO: Vector = (0.0, 0.0, 0.0)
TURNS, SLIDES = ("revolute", "continuous"), ("prismatic",)
_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_HALF_TURN = float(np.pi)  # rad, to either side: where a joint without stops is taken to end


@dataclass(frozen=True)
class Origin:
    """A frame seen from its parent: m and rad."""

    xyz: Vector = ZERO
    rpy: Vector = ZERO

    @property
    def placement(self) -> pin.SE3:
        """The same as Pinocchio has it."""
        return pin.SE3(pin.rpy.rpyToMatrix(*self.rpy), np.array(self.xyz))


@dataclass(frozen=True)
class Inertial:
    """Mass, kg, and inertia (xx, xy, xz, yy, yz, zz), kg m2, about the CoM at `origin`."""

    origin: Origin
    mass: float
    inertia: tuple[float, ...]


@dataclass(frozen=True)
class Solid:
    """A shape of a link, in its own frame.

    Attributes:
        size: m, full lengths of a box; radius of a sphere; radius and length of a cylinder, and of
            a capsule without its two caps; three factors of a mesh.
        mesh: its file's name as the URDF has it; file: where that is.
        colour: of a picture, (4,) from 0 to 1; None: the mesh's own, or grey.
    """

    kind: Kind
    origin: Origin
    size: tuple[float, ...]
    mesh: str = ""
    file: Path = Path()
    colour: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Link:
    """A link; without `inertial` it has no mass."""

    name: str
    inertial: Inertial | None = None
    visuals: tuple[Solid, ...] = ()
    collisions: tuple[Solid, ...] = ()


@dataclass(frozen=True)
class Mimic:
    """A joint's angle as `multiplier` times another's, plus `offset`, rad or m."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Limit:
    """Stops, rad or m; torque, Nm or N, and speed, rad/s or m/s: zero where nothing is said."""

    lower: float = 0.0
    upper: float = 0.0
    effort: float = 0.0
    velocity: float = 0.0


@dataclass(frozen=True)
class Dynamics:
    """Damping, Nm s/rad or N s/m, and friction, Nm or N: zero where nothing is said."""

    damping: float = 0.0
    friction: float = 0.0


@dataclass(frozen=True)
class Joint:
    """A joint that turns, slides or is fixed; `limit` is None where the URDF has none.

    Its `dynamics` are for first robot files alone: drives are the robot file's.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Origin = Origin()
    axis: Vector = (1.0, 0.0, 0.0)
    limit: Limit | None = None
    mimic: Mimic | None = None
    dynamics: Dynamics = Dynamics()

    @property
    def moves(self) -> bool:
        """Whether it turns or slides."""
        return self.kind != "fixed"

    @property
    def slides(self) -> bool:
        """Whether it is prismatic."""
        return self.kind in SLIDES

    @property
    def unit(self) -> str:
        """Unit of its angle."""
        return "m" if self.slides else "rad"


@dataclass(frozen=True)
class Description:
    """A robot's URDF, read and checked: a tree of links.

    Attributes:
        file: the URDF.
        links, joints: by name, in the order of the file.
    """

    file: Path
    links: dict[str, Link] = field(hash=False)
    joints: dict[str, Joint] = field(hash=False)

    @cached_property
    def root(self) -> str:
        """Name of the link that hangs on no joint."""
        carried = {joint.child for joint in self.joints.values()}
        return next(name for name in self.links if name not in carried)

    @cached_property
    def content(self) -> bytes:
        """All of it as text: what its caches are known by. Nothing of this machine is in it."""
        return ET.tostring(_element(self, solids=True))

    @cached_property
    def skeleton(self) -> str:
        """A URDF of links with masses and joints alone, for Pinocchio.

        A joint that turns without stops is one that turns by half a turn either way.
        """
        return ET.tostring(_element(self, solids=False), encoding="unicode")

    @property
    def meshes(self) -> dict[str, Path]:
        """Its mesh files, by the names that the URDF has for them."""
        return {
            solid.mesh: solid.file
            for link in self.links.values()
            for solid in (*link.visuals, *link.collisions)
            if solid.kind == "mesh"
        }

    def mesh_stamps(self) -> tuple[str, ...]:
        """Names, sizes and times of its meshes: they are read again when one of these changes."""
        return tuple(f"{name} {_stamp(file)}" for name, file in self.meshes.items())


def _stamp(file: Path) -> str:
    try:
        status = file.stat()
    except OSError as error:
        raise RobotFileError(f"{file}: a mesh cannot be read any more: {error.strerror}") from error
    return f"{status.st_size} {status.st_mtime_ns}"


def _element(robot: Description, *, solids: bool) -> ET.Element:
    root = ET.Element("robot", name="robot")
    for link in robot.links.values():
        _add_link(root, link, solids=solids)
    for joint in robot.joints.values():
        _add_joint(root, joint)
    return root


def _add_link(root: ET.Element, link: Link, *, solids: bool) -> None:
    element = ET.SubElement(root, "link", name=link.name)
    if link.inertial is not None:
        inertial = ET.SubElement(element, "inertial")
        _add_origin(inertial, link.inertial.origin)
        ET.SubElement(inertial, "mass", value=repr(link.inertial.mass))
        moments = map(repr, link.inertial.inertia)
        ET.SubElement(inertial, "inertia", dict(zip(_INERTIA, moments, strict=True)))
    for tag, given in (("visual", link.visuals), ("collision", link.collisions)):
        for solid in given if solids else ():
            part = ET.SubElement(element, tag)
            _add_origin(part, solid.origin)
            size, colour = numbers_text(solid.size), numbers_text(solid.colour or ())
            ET.SubElement(part, solid.kind, size=size, mesh=solid.mesh, colour=colour)


def _add_joint(root: ET.Element, joint: Joint) -> None:
    kind = "revolute" if joint.kind == "continuous" else joint.kind
    element = ET.SubElement(root, "joint", name=joint.name, type=kind)
    _add_origin(element, joint.origin)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    if not joint.moves:
        return
    ET.SubElement(element, "axis", xyz=numbers_text(joint.axis))
    limit = vars(joint.limit or Limit())
    if joint.kind == "continuous":
        limit = {**limit, "lower": -_HALF_TURN, "upper": _HALF_TURN}
    ET.SubElement(element, "limit", {key: repr(value) for key, value in limit.items()})


def _add_origin(element: ET.Element, origin: Origin) -> None:
    ET.SubElement(element, "origin", xyz=numbers_text(origin.xyz), rpy=numbers_text(origin.rpy))


def numbers_text(values: Iterable[float]) -> str:
    """Numbers as URDFs have them, with all digits."""
    return " ".join(repr(float(value)) for value in values)

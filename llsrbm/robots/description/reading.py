"""A URDF file, read once and checked, from which everything else about a robot is built."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path

from llsrbm.errors import printable
from llsrbm.robots.description.elements import FARTHEST, Part
from llsrbm.robots.description.mesh_paths import MeshPaths
from llsrbm.robots.description.parts import (
    ZERO,
    Description,
    Dynamics,
    Inertial,
    Joint,
    Kind,
    Limit,
    Link,
    Mimic,
    Origin,
    Solid,
)
from llsrbm.robots.description.source import read_xml
from llsrbm.robots.description.tree import check_tree, without_floating_root

_KINDS = ("revolute", "continuous", "prismatic", "fixed")
_PINOCCHIOS = ("universe", "root_joint")  # names of its world and of the joint of the root
_FREE = "floating"  # of a joint between the world and the root alone
_OF_ROBOT = ("link", "joint", "material")
_OF_LINK = ("inertial", "visual", "collision")
_OF_JOINT = ("origin", "parent", "child", "axis", "limit", "mimic", "dynamics")
_OF_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_GEOMETRIES = ("box", "sphere", "cylinder", "capsule", "mesh")
_ROUNDED = 1e-12  # kg m2 below zero that a program's rounding makes of it
_NEGLIGIBLE = 1e-5  # kg m2 of links without mass, which some files have
_LEAST_SCALE = 1e-9  # of a mesh: its file is in nm
_SMALLEST_AXIS = 1e-6  # length from which on an axis has a direction

Colour = tuple[float, ...]


def read_description(urdf: Path, where: str) -> Description:
    """Read a URDF; `where`: how messages begin, which name the file. Raises `RobotFileError`: one
    line that names the link or joint and the value that is wrong.
    """
    root = Part(read_xml(urdf, where), where)
    root.children(_OF_ROBOT)
    for element in root.element.iter():
        if "xacro" in str(element.tag).partition("}")[0]:
            name = str(element.tag).rpartition("}")[2]
            raise root.fault(
                f"<xacro:{printable(name)}> is for xacro, which was not run; expected what "
                "`xacro robot.urdf.xacro > robot.urdf` writes"
            )
    colours = _named_colours(root)
    paths = MeshPaths(urdf)
    links: dict[str, Link] = {}
    for element in root.element.findall("link"):
        link = _link(element, where, colours, paths)
        if link.name in links:
            raise root.fault(f'two links are called "{link.name}"; expected names of their own')
        links[link.name] = link
    joints: dict[str, Joint] = {}
    for element in root.element.findall("joint"):
        joint = _joint(element, where)
        if joint.name in joints:
            raise root.fault(f'two joints are called "{joint.name}"; expected names of their own')
        joints[joint.name] = joint
    check_tree(links, joints, where)
    return without_floating_root(Description(urdf, links, joints), where)


def _named(element: ET.Element, where: str) -> Part:
    """A link or joint, with its name in messages."""
    part = Part(element, where)
    name = part.text("name")
    part.check(("name", "type"))
    return Part(element, f'{where}: {part.tag} "{printable(name)}"')


def _link(
    element: ET.Element, where: str, colours: dict[str, Colour | None], paths: MeshPaths
) -> Link:
    part = _named(element, where)
    part.children(_OF_LINK)
    inertial = part.one("inertial")
    solids: dict[str, list[Solid]] = {"visual": [], "collision": []}
    for tag, found in solids.items():
        for shape in element.findall(tag):
            if len(shape):  # an empty one says nothing
                found.append(_solid(Part(shape, part.where), colours, paths))
    return Link(
        name=element.attrib["name"],
        inertial=None if inertial is None else _inertial(inertial),
        visuals=tuple(solids["visual"]),
        collisions=tuple(solids["collision"]),
    )


def _inertial(part: Part) -> Inertial:
    part.children(("origin", "mass", "inertia"))
    mass, inertia = part.needed("mass"), part.needed("inertia")
    mass.check(("value",), strict=True)
    inertia.check(_OF_INERTIA, strict=True)
    kg, moments = mass.number("value"), [inertia.number(key) for key in _OF_INERTIA]
    if kg < 0:
        raise mass.fault(f'<mass value="{kg:g}">: expected 0 kg or more')
    for key in ("ixx", "iyy", "izz"):
        moment = moments[_OF_INERTIA.index(key)]
        if moment < -_ROUNDED:
            raise inertia.fault(f'<inertia {key}="{moment:g}">: expected 0 kg m2 or more')
    if kg == 0 and max(map(abs, moments)) > _NEGLIGIBLE:
        raise mass.fault('<mass value="0"> with an inertia; expected a mass, or no inertia')
    return Inertial(_origin(part), kg, tuple(moments))


def _origin(part: Part) -> Origin:
    origin = part.one("origin")
    if origin is None:
        return Origin()
    origin.check(("xyz", "rpy"), strict=True)
    x, y, z = origin.numbers("xyz", 3, ZERO, FARTHEST)
    roll, pitch, yaw = origin.numbers("rpy", 3, ZERO)
    return Origin((x, y, z), (roll, pitch, yaw))


def _solid(part: Part, colours: dict[str, Colour | None], paths: MeshPaths) -> Solid:
    part.children(("origin", "geometry", "material"))
    geometry = part.needed("geometry")
    shapes = [each for each in geometry.element if not str(each.tag).startswith("{")]
    for given in shapes:
        if given.tag not in _GEOMETRIES:
            raise part.fault(
                f"<{part.tag}> has a <{printable(str(given.tag))}>; expected one of "
                f"{', '.join(_GEOMETRIES)}"
            )
    if len(shapes) != 1:
        raise part.fault(
            f"the <geometry> of a <{part.tag}> has {len(shapes)} shapes; expected one, and a "
            f"<{part.tag}> for each"
        )
    shape = Part(shapes[0], part.where)
    kind: Kind = shapes[0].tag  # type: ignore[assignment]  # one of _GEOMETRIES
    colour = _colour(part, colours) if part.tag == "visual" else None
    if kind != "mesh":
        return Solid(kind, _origin(part), _size(kind, shape), colour=colour)
    shape.check(("filename", "scale"))
    name = shape.text("filename")
    size = tuple(shape.numbers("scale", 3, (1.0, 1.0, 1.0)))
    if min(map(abs, size)) < _LEAST_SCALE:
        scale = printable(shape.element.get("scale", ""))
        raise shape.fault(
            f'<mesh scale="{scale}">: expected three numbers that are not zero, '
            f"{_LEAST_SCALE:g} at least"
        )
    return Solid(kind, _origin(part), size, name, paths.find(name, part.where), colour)


def _size(kind: Kind, shape: Part) -> tuple[float, ...]:
    keys = {"box": ("size",), "sphere": ("radius",)}.get(kind, ("radius", "length"))
    shape.check(keys, strict=True)
    if kind == "box":
        return shape.positive("size", 3)
    return tuple(length for key in keys for length in shape.positive(key, 1))


def _named_colours(root: Part) -> dict[str, Colour | None]:
    """Colours of the materials that have some, by name: links may use one another's."""
    found: dict[str, Colour | None] = {}
    for element in root.element.iter("material"):
        colour = _own_colour(Part(element, root.where))
        name = element.get("name", "")
        if colour is not None:
            found.setdefault(name, colour)
    return found


def _colour(part: Part, colours: dict[str, Colour | None]) -> Colour | None:
    element = part.element.find("material")  # of several the first, as others have it
    if element is None:
        return None
    return _own_colour(Part(element, part.where)) or colours.get(element.get("name", ""))


def _own_colour(material: Part) -> Colour | None:
    colour = material.one("color")
    if colour is None:
        return None
    return tuple(min(max(share, 0.0), 1.0) for share in colour.numbers("rgba", 4))


def _joint(element: ET.Element, where: str) -> Joint:
    part = _named(element, where)
    part.children(_OF_JOINT)
    kind = part.text("type")
    if kind not in (*_KINDS, _FREE):
        raise part.fault(f'type="{printable(kind)}"; expected one of {", ".join(_KINDS)}')
    ends = {}
    for end in ("parent", "child"):
        link = part.needed(end)
        link.check(("link",), strict=True)
        ends[end] = link.text("link")
    moves = kind not in ("fixed", _FREE)
    if element.attrib["name"] in (_PINOCCHIOS if moves else _PINOCCHIOS[:1]):
        raise part.fault("Pinocchio has that name for itself; expected another one")
    return Joint(
        name=element.attrib["name"],
        kind=kind,
        **ends,
        origin=_origin(part),
        axis=_axis(part) if moves else (1.0, 0.0, 0.0),
        limit=_limit(part) if moves else None,
        mimic=_mimic(part) if moves else None,
        dynamics=_dynamics(part) if moves else Dynamics(),
    )


def _axis(part: Part) -> tuple[float, float, float]:
    axis = part.one("axis")
    if axis is None:
        return (1.0, 0.0, 0.0)
    axis.check(("xyz",), strict=True)
    x, y, z = axis.numbers("xyz", 3)
    if not x * x + y * y + z * z > _SMALLEST_AXIS**2:
        given = printable(axis.element.get("xyz", ""))
        raise axis.fault(f'<axis xyz="{given}"> has no direction; expected a vector')
    return x, y, z


def _limit(part: Part) -> Limit | None:
    limit = part.one("limit")
    if limit is None:
        return None
    limit.check(("lower", "upper", "effort", "velocity"))
    # Some have 1e16 for none; what a joint needs is checked where it is known whether it moves.
    keys = ("lower", "upper", "effort", "velocity")
    found = Limit(*(limit.number(key, 0.0, math.inf) for key in keys))
    if found.lower > found.upper:
        raise limit.fault(
            f'<limit lower="{found.lower:g}" upper="{found.upper:g}">: expected lower below upper'
        )
    limit.not_negative(effort=found.effort, velocity=found.velocity)
    return found


def _dynamics(part: Part) -> Dynamics:
    dynamics = part.one("dynamics")
    if dynamics is None:
        return Dynamics()
    dynamics.check(("damping", "friction"))
    found = {key: dynamics.number(key, 0.0) for key in ("damping", "friction")}
    dynamics.not_negative(**found)
    return Dynamics(**found)


def _mimic(part: Part) -> Mimic | None:
    mimic = part.one("mimic")
    if mimic is None:
        return None
    mimic.check(("joint", "multiplier", "offset"), strict=True)
    return Mimic(mimic.text("joint"), mimic.number("multiplier", 1.0), mimic.number("offset", 0.0))

"""The links of a URDF as a tree: one root, and every other link on one joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from llsrbm.errors import RobotFileError, printable
from llsrbm.request.messages import choices
from llsrbm.robots.description.parts import Description, Joint, Link


def check_tree(links: Mapping[str, Link], joints: Mapping[str, Joint], where: str) -> None:
    """Raise `RobotFileError` unless joints make a tree of links."""
    if not links or not joints:
        what = "links" if not links else "joints"
        raise RobotFileError(f"{where} is not the URDF of a robot with legs: it has no {what}")
    carried: dict[str, str] = {}
    for joint in joints.values():
        of_joint = f'{where}: joint "{printable(joint.name)}"'
        for end in (joint.parent, joint.child):
            if end not in links:
                raise RobotFileError(
                    f'{of_joint}: there is no link "{printable(end)}"; {choices(end, links)}'
                )
        if joint.child in carried:
            raise RobotFileError(
                f'{of_joint}: its child "{joint.child}" hangs on joint "{carried[joint.child]}", '
                "too; expected one joint for each link"
            )
        carried[joint.child] = joint.name
        mimic = joint.mimic
        if mimic is not None and mimic.joint not in joints:
            raise RobotFileError(
                f'{of_joint}: it mimics "{printable(mimic.joint)}", and there is no such joint; '
                f"{choices(mimic.joint, joints)}"
            )
    roots = [name for name in links if name not in carried]
    if len(roots) > 1:
        raise RobotFileError(
            f"{where}: links {', '.join(map(printable, roots[:8]))} hang on no joint; expected "
            "one root"
        )
    reached = set(roots)
    below: dict[str, list[str]] = {}
    for joint in joints.values():
        below.setdefault(joint.parent, []).append(joint.child)
    ahead = list(roots)
    while ahead:
        children = below.get(ahead.pop(), [])
        reached.update(children)
        ahead += children
    ring = [name for name in links if name not in reached]
    if ring:
        raise RobotFileError(
            f"{where}: links {', '.join(map(printable, ring[:8]))} hang on each other in a ring; "
            "expected a tree with one root"
        )


def without_floating_root(robot: Description, where: str) -> Description:
    """The robot without a world that its first link floats in: every root floats anyway. Raises
    `RobotFileError`: another joint floats, or that world is more than a name.
    """
    floating = [joint for joint in robot.joints.values() if joint.kind == "floating"]
    if not floating:
        return robot
    joint, world = floating[0], robot.links[robot.root]
    alone = sum(other.parent == world.name for other in robot.joints.values()) == 1
    bare = world.inertial is None and not world.visuals and not world.collisions
    if len(floating) > 1 or joint.parent != world.name or not (alone and bare):
        other = next((j for j in floating if j.parent != world.name), joint)
        raise RobotFileError(
            f'{where}: joint "{printable(other.name)}": type="floating"; expected it between the '
            "robot and a root link without mass, shapes and other joints, or nowhere"
        )
    links = {name: link for name, link in robot.links.items() if name != world.name}
    joints = {name: other for name, other in robot.joints.items() if name != joint.name}
    return replace(robot, links=links, joints=joints)

"""URDFs by hand, and the robot that they describe by numpy alone: no reader of ours or another's.

The robot: a trunk and two legs of a hip and a knee, with feet on fixed joints.
"""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.robots.schema import robot_files

LEG = """
  <link name="{n}_thigh"><inertial><origin xyz="0.01 0 -0.1" rpy="0.1 0.2 0.3"/><mass value="1.2"/>
    <inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.012" iyz="0" izz="0.004"/></inertial></link>
  <link name="{n}_shank"><inertial><origin xyz="0 0 -0.1"/><mass value="0.4"/>
    <inertia ixx="0.003" ixy="0" ixz="0" iyy="0.003" iyz="0" izz="0.001"/></inertial>
    <collision><origin xyz="0 0 -0.1"/><geometry><cylinder radius="0.02" length="0.2"/></geometry>
    </collision></link>
  <link name="{n}_foot"><inertial><mass value="0.1"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
    <collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <joint name="{n}_hip" type="revolute"><parent link="trunk"/><child link="{n}_thigh"/>
    <origin xyz="0 {y} 0" rpy="0.02 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-1.5" upper="1.5" effort="20" velocity="10"/></joint>
  <joint name="{n}_knee" type="revolute"><parent link="{n}_thigh"/><child link="{n}_shank"/>
    <origin xyz="0 0 -0.2"/><axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2.5" effort="20" velocity="10"/></joint>
  <joint name="{n}_ankle" type="fixed"><parent link="{n}_shank"/><child link="{n}_foot"/>
    <origin xyz="0 0 -0.2"/></joint>"""
TRUNK = """<link name="trunk"><inertial><origin xyz="0.02 0 0.1"/><mass value="5"/>
    <inertia ixx="0.1" ixy="0" ixz="0.01" iyy="0.09" iyz="0" izz="0.08"/></inertial>
    <visual><geometry><box size="0.2 0.3 0.2"/></geometry></visual>
    <collision><origin xyz="0 0 0.1"/><geometry><box size="0.2 0.3 0.2"/></geometry></collision>
  </link>"""
URDF = (
    f'<?xml version="1.0"?>\n<robot name="strange">\n  {TRUNK}'
    + LEG.format(n="left", y=0.15)
    + LEG.format(n="right", y=-0.15)
    + "\n</robot>\n"
)


def replaced(old, new, count=1):
    """The URDF with a text in place of another."""
    assert old in URDF, old
    return URDF.replace(old, new, count)


def added(text):
    """The URDF with a text at its end."""
    return URDF.replace("</robot>", f"{text}</robot>")


def after(opening, text):
    """The URDF with a text within the element that begins so."""
    start = URDF.index(">", URDF.index(opening)) + 1
    return URDF[:start] + text + URDF[start:]


def robot_file(folder: Path, urdf: str | bytes = URDF, held: str = "") -> Path:
    """A robot file for such a URDF, both written to a folder."""
    content = urdf if isinstance(urdf, bytes) else urdf.encode()
    (folder / "strange.urdf").write_bytes(content)
    tables = robot_files()["anymal"].read_text().split("[reach]")[1]
    path = folder / "strange.toml"
    path.write_text(
        f'name = "strange"\ntitle = "Strange"\n[urdf]\nfile = "strange.urdf"\n{held}\n[legs]\n'
        'left = { foot = "left_foot", hip = "left_hip" }\n'
        'right = { foot = "right_foot", hip = "right_hip" }\n'
        "[posture]\nleft = [0.4, -0.8]\nright = [0.4, -0.8]\n[reach]"
        + re.sub(r"(?m)^(torque|joint_speed) = .*\n", "", tables)
    )
    return path


def numbers(element, key, default):
    return np.array([float(x) for x in element.get(key, default).split()])


def frame(part):
    origin = part.find("origin")
    T = np.eye(4)
    if origin is not None:
        T[:3, 3] = numbers(origin, "xyz", "0 0 0")
        T[:3, :3] = Rotation.from_euler("xyz", numbers(origin, "rpy", "0 0 0")).as_matrix()
    return T


def by_hand(urdf, angles, base):
    """Mass, CoM, inertia about it, and link -> (4, 4), in a posture; base (4, 4) of the root."""
    robot = ET.fromstring(urdf)
    joints = [joint for joint in robot.findall("joint") if joint.get("type") != "floating"]
    carried = {joint.find("child").get("link") for joint in joints}
    floating = {j.find("child").get("link") for j in robot.findall("joint") if j not in joints}
    links = {link.get("name"): link for link in robot.findall("link")}
    (root,) = floating or (links.keys() - carried)
    places, ahead = {root: base}, [root]
    while ahead:
        parent = ahead.pop()
        for joint in joints:
            if joint.find("parent").get("link") == parent:
                places[joint.find("child").get("link")] = places[parent] @ moved(joint, angles)
                ahead.append(joint.find("child").get("link"))
    bodies = []
    for name, place in places.items():
        inertial = links[name].find("inertial")
        if inertial is not None:
            tensor = inertial.find("inertia")
            xx, xy, xz, yy, yz, zz = (
                float(tensor.get(key)) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
            )
            T = place @ frame(inertial)
            local = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            mass = float(inertial.find("mass").get("value"))
            bodies.append((mass, T[:3, 3], T[:3, :3] @ local @ T[:3, :3].T))
    total = sum(mass for mass, _, _ in bodies)
    com = sum(mass * p for mass, p, _ in bodies) / total
    inertia = np.zeros((3, 3))
    for mass, p, own in bodies:
        d = p - com
        inertia += own + mass * (d @ d * np.eye(3) - np.outer(d, d))
    return total, com, inertia, places


def moved(joint, angles):
    T, axis = frame(joint), joint.find("axis")
    if joint.get("type") == "fixed":
        return T
    along = numbers(axis, "xyz", "") if axis is not None else np.array([1.0, 0.0, 0.0])
    along, step = along / np.linalg.norm(along), np.eye(4)
    if joint.get("type") == "prismatic":
        step[:3, 3] = along * angles[joint.get("name")]
    else:
        step[:3, :3] = Rotation.from_rotvec(along * angles[joint.get("name")]).as_matrix()
    return T @ step

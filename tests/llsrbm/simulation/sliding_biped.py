"""A robot by hand: two legs, each of a hip that turns and a slide; feet are spheres."""

from pathlib import Path

from llsrbm.robots import load_robot
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import robot_files

_LEG = """
  <link name="{n}_hip"><inertial><origin xyz="0.01 0 -0.05"/><mass value="1.2"/>
    <inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.012" iyz="0" izz="0.004"/></inertial></link>
  <link name="{n}_shin">
    <inertial><origin xyz="0 0 -0.2"/><mass value="0.8"/>
      <inertia ixx="0.02" ixy="0" ixz="0.0005" iyy="0.021" iyz="0" izz="0.001"/></inertial>
    <collision><origin xyz="0 0 -0.1"/><geometry><sphere radius="0.05"/></geometry></collision>
  </link>
  <link name="{n}_sole">
    <collision><origin xyz="0 0 0.03"/><geometry><sphere radius="0.04"/></geometry></collision>
  </link>
  <joint name="{n}_swing" type="revolute"><parent link="pelvis"/><child link="{n}_hip"/>
    <origin xyz="0 {y} 0"/><axis xyz="0 1 0"/><dynamics damping="0.5" friction="0.3"/>
    <limit lower="-1.5" upper="1.5" effort="2" velocity="10"/></joint>
  <joint name="{n}_slide" type="prismatic"><parent link="{n}_hip"/><child link="{n}_shin"/>
    <origin xyz="0 0 -0.1"/><axis xyz="0 0 -1"/>
    <limit lower="-0.3" upper="0.3" effort="2" velocity="10"/></joint>
  <joint name="{n}_ankle" type="fixed"><parent link="{n}_shin"/><child link="{n}_sole"/>
    <origin xyz="0 0 -0.5"/></joint>
"""
# The legs in the other order than the robot file's.
URDF = (
    """<robot name="sliding">
  <link name="pelvis">
    <inertial><mass value="1e-6"/>
      <inertia ixx="1e-6" ixy="1e-6" ixz="1e-6" iyy="1e-6" iyz="1e-6" izz="1e-6"/></inertial>
    <collision><origin xyz="0 0 0.1"/><geometry><box size="0.2 0.3 0.2"/></geometry></collision>
  </link>
  <link name="load"><inertial><origin xyz="0.02 0 0.1"/><mass value="9.5"/>
    <inertia ixx="0.1" ixy="0" ixz="0.01" iyy="0.09" iyz="0" izz="0.08"/></inertial></link>
  <joint name="load" type="fixed"><parent link="pelvis"/><child link="load"/></joint>"""
    + _LEG.format(n="right", y=-0.15)
    + _LEG.format(n="left", y=0.15)
    + "</robot>"
)


def sliding_biped(directory: Path, urdf: str = URDF) -> Robot:
    """The robot, its files written to a directory."""
    (directory / "sliding.urdf").write_text(urdf)
    tables = robot_files()["anymal"].read_text().split("[reach]")[1]
    path = directory / "sliding.toml"
    path.write_text(
        'name = "sliding"\ntitle = "Sliding biped"\n[urdf]\nfile = "sliding.urdf"\n[legs]\n'
        'left = { foot = "left_sole", hip = "left_swing" }\n'
        'right = { foot = "right_sole", hip = "right_swing" }\n'
        "[posture]\nleft = [0.0, 0.0]\nright = [0.0, 0.0]\n[reach]" + tables
    )
    return load_robot(str(path))

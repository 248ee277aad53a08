"""URDFs that two readers may read differently: all robots agree with one by hand, or it is refused.

Pinocchio's robot plans, MuJoCo's is simulated.
"""

import codecs

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from llsrbm.cli import main
from llsrbm.errors import RobotFileError
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import build_robot
from llsrbm.simulation.scene import build_scene
from tests.llsrbm.robots.strange_urdf import URDF, added, by_hand, replaced, robot_file

GROUND = Surroundings(ground=0.0, blocks=())


def agrees(robot, urdf, seed=0):
    """Pinocchio's and MuJoCo's robot are the one by hand, in random postures."""
    scene, rng = build_scene(robot, GROUND, Disturbance(), 1e-3), np.random.default_rng(seed)
    model = robot.model
    low, high = robot.joint_stops
    np.testing.assert_allclose(
        [scene.model.joint(name).range for name in robot.joint_names], np.array([low, high]).T
    )
    for _ in range(4):
        joints = rng.uniform(low, high)
        angles = dict(zip(robot.joint_names, joints, strict=True)) | robot.file.urdf.held
        turn, place = Rotation.random(rng=rng), rng.normal(size=3)
        base = np.eye(4)
        base[:3, :3], base[:3, 3] = turn.as_matrix(), place
        mass, com, inertia, places = by_hand(urdf, angles, base)
        q = np.concatenate([place, turn.as_quat(), joints])
        data = model.createData()
        pin.ccrba(model, data, q, np.zeros(model.nv))
        pin.framesForwardKinematics(model, data, q)
        assert data.Ig.mass == pytest.approx(mass, rel=1e-9)
        np.testing.assert_allclose(data.com[0], com, atol=1e-9)
        np.testing.assert_allclose(data.Ig.inertia, inertia, atol=1e-9)
        for link, expected in places.items():
            frame = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
            np.testing.assert_allclose(frame.homogeneous, expected, atol=1e-9, err_msg=link)
        simulated = mujoco.MjData(scene.model)
        simulated.qpos[scene.q_order] = q
        mujoco.mj_forward(scene.model, simulated)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(scene.model, simulated, M)
        assert M[0, 0] == pytest.approx(mass, rel=1e-9)
        np.testing.assert_allclose(simulated.subtree_com[1], com, atol=1e-9)
        for body in range(1, scene.model.nbody):
            link = scene.model.body(body).name
            link = "world" if link == "world_link" else link  # MuJoCo's own is called so
            np.testing.assert_allclose(simulated.xpos[body], places[link][:3, 3], atol=1e-9)
            seen = simulated.xmat[body].reshape(3, 3)
            np.testing.assert_allclose(seen, places[link][:3, :3], atol=1e-9)
        # The inertia about the CoM: of the base's turns, by the world's axes.
        R, d = turn.as_matrix(), com - place
        about = R @ M[3:6, 3:6] @ R.T - mass * (d @ d * np.eye(3) - np.outer(d, d))
        np.testing.assert_allclose(about, inertia, atol=1e-9)


HEAVY = """<link name="load"><inertial><origin xyz="{x} 0.01 0" rpy="{r} 0.1 {x}"/>
    <mass value="{m}"/><inertia ixx="0.01" ixy="0" ixz="0.001" iyy="0.012" iyz="0" izz="0.009"/>
    </inertial></link><joint name="loaded" type="fixed"><parent link="{on}"/><child link="load"/>
    <origin xyz="0.1 {x} 0" rpy="{r} {x} 1"/></joint>"""
WORLD = """<link name="{w}"/><joint name="{w}_joint" type="{kind}"><parent link="{w}"/>
    <child link="trunk"/><origin xyz="0.1 0.2 0.3" rpy="0.1 0 {r}"/></joint>"""
IGNORED = """<!-- a comment --><gazebo reference="trunk"><mass>9</mass></gazebo>
    <transmission name="t"><joint name="left_hip"/></transmission>
    <mujoco><compiler discardvisual="true" balanceinertia="true" boundmass="3" fusestatic="false"
    angle="degree" strippath="true"/><option gravity="0 0 5"/></mujoco>"""
numbers = st.floats(-1.2, 1.2).map(lambda x: round(x, 6))


@settings(
    max_examples=25,
    phases=[Phase.explicit, Phase.reuse, Phase.generate],
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(
    axis=st.tuples(numbers, numbers, numbers).filter(lambda v: np.linalg.norm(v) > 0.1),
    kind=st.sampled_from(["revolute", "continuous", "prismatic"]),
    root=st.sampled_from(["", "world", "root_joint", "base_footprint", "universe"]),
    floats=st.booleans(),
    load=st.none() | st.sampled_from(["trunk", "left_thigh", "right_shank", "left_foot"]),
    x=numbers,
    m=st.floats(0.1, 3.0),
    ignored=st.booleans(),
    shape=st.sampled_from(["capsule", "cylinder"]),
)
def test_robots_agree(tmp_path, axis, kind, root, floats, load, x, m, ignored, shape):
    a, b, c = axis
    urdf = URDF.replace('<axis xyz="0 1 0"/>', f'<axis xyz="\n {a:e}\t{b} {c} "/>', 2)
    urdf = urdf.replace('type="revolute"', f'type="{kind}"').replace("<cylinder", f"<{shape}")
    more = IGNORED if ignored else ""
    if root:
        more += WORLD.format(w=root, kind="floating" if floats else "fixed", r=x)
    if load is not None:
        more += HEAVY.format(on=load, x=x, m=m, r=x / 2)
    urdf = urdf.replace("</robot>", f"{more}</robot>")
    robot = build_robot(robot_file(tmp_path, urdf))
    agrees(robot, urdf)


def test_elements_of_other_programs_are_no_shapes(tmp_path):
    theirs = '<geometry><drake:declare_convex xmlns:drake="http://drake.mit.edu"/>'
    robot = build_robot(robot_file(tmp_path, URDF.replace("<geometry>", theirs)))
    agrees(robot, URDF)


MIMIC = '<mimic joint="{}" multiplier="-2" offset="0.1"/><limit lower="-2.5"'
KNEE = '<limit lower="-2.5"'
FINGERS = """<link name="f1"/><link name="f2"/>
    <joint name="f1" type="revolute"><parent link="trunk"/><child link="f1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
    <joint name="f2" type="revolute"><parent link="f1"/><child link="f2"/>
    <mimic joint="f1" multiplier="-1" offset="0.1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
FIXED = '<joint name="{n}" type="{t}"><parent link="{p}"/><child link="{c}"/></joint>'
REFUSED = {
    "a joint that mimics": (replaced(KNEE, MIMIC.format("left_hip")), ["left_knee", "left_hip"]),
    "mimics nobody": (replaced(KNEE, MIMIC.format("hop")), ["left_knee", '"hop"']),
    "xacro not run": (
        replaced('<mass value="5"/>', '<mass value="${m}"/>'),
        ['link "trunk"', "${m}", "xacro"],
    ),
    "a xacro macro": (
        added('<xacro:leg xmlns:xacro="http://ros.org/xacro"/>'),
        ["xacro:leg", "was not run"],
    ),
    **{
        f'a mass of "{text}"': (
            replaced('<mass value="5"/>', f'<mass value="{text}"/>'),
            ['link "trunk"', f'"{text}"', "expected"],
        )
        for text in ("nan", "inf", "", "1,5", "1e400", "five", "1_0", "0x10", "-5", "5 5")
    },
    "a length of nan": (replaced('radius="0.02"', 'radius="nan"'), ['link "left_shank"', "nan"]),
    "two of three numbers": (replaced('xyz="0 0 -0.2"', 'xyz="0 0"'), ["left_knee", '"0 0"']),
    "no mass": (replaced('<mass value="5"/>', ""), ['link "trunk"', "<mass>"]),
    "no izz": (replaced(' izz="0.08"', ""), ['link "trunk"', "izz"]),
    "an inertia misspelt": (replaced('izz="0.08"', 'Izz="0.08"'), ['link "trunk"', '"izz"']),
    "a limit misspelt": (replaced('upper="2.5"', 'uper="2.5"'), ["left_knee", '"upper"']),
    "a collision misspelt": (
        replaced("<collision><origin", "<colision/><collision><origin"),
        ['link "trunk"', "colision"],
    ),
    "a negative moment": (replaced('ixx="0.1"', 'ixx="-0.1"'), ['link "trunk"', "-0.1"]),
    "no triangle": (replaced('izz="0.001"', 'izz="0.1"'), ['"left_shank"', "principal", "0.1"]),
    "not positive": (replaced('ixy="0.001"', 'ixy="0.1"'), ['"left_thigh"', "principal"]),
    "a body without mass": (
        URDF.replace('<mass value="0.4"/>', '<mass value="0"/>', 1),
        ['"left_shank"', "with an inertia"],
    ),
    "no inertia on a moving body": (
        added('<link name="hand"/>' + FIXED.format(n="h", t="revolute", p="trunk", c="hand")),
        ['joint "h"', "limit"],
    ),
    "a joint that floats": (
        replaced('name="left_knee" type="revolute"', 'name="left_knee" type="floating"'),
        ["left_knee", "floating"],
    ),
    "a joint in a plane": (
        replaced('name="left_knee" type="revolute"', 'name="left_knee" type="planar"'),
        ["left_knee", "planar", "revolute"],
    ),
    "no range": (
        replaced('lower="-2.5" upper="2.5"', 'effort_="1"').replace('effort_="1"', ""),
        ["left_knee", "lower = upper = 0"],
    ),
    "no limit": (
        replaced('<limit lower="-2.5" upper="2.5" effort="20" velocity="10"/>', ""),
        ["left_knee", "no <limit>"],
    ),
    "stops the wrong way": (
        replaced('lower="-2.5" upper="2.5"', 'lower="2.5" upper="-2.5"'),
        ["left_knee", "lower below upper"],
    ),
    "no effort": (
        replaced('upper="2.5" effort="20"', 'upper="2.5" effort="0"'),
        ["left_knee", 'effort="0"', "limits.torque"],
    ),
    "no velocity": (
        replaced('upper="2.5" effort="20" velocity="10"', 'upper="2.5" effort="20"'),
        ["left_knee", 'velocity="0"', "limits.joint_speed"],
    ),
    **{
        f"{key} of {number}": (
            replaced('<axis xyz="0 1 0"/>', f'<axis xyz="0 1 0"/><dynamics {key}="{number}"/>'),
            ["left_hip", f'<dynamics {key}="{number}">', "expected"],
        )
        for key in ("damping", "friction")
        for number in ("-0.1", "nan")
    },
    "an axis of zero": (
        replaced('<axis xyz="0 1 0"/>', '<axis xyz="0 0 0"/>'),
        ["left_hip", "axis"],
    ),
    "two links of a name": (added('<link name="left_foot"/>'), ['"left_foot"', "two links"]),
    "two joints of a name": (
        added('<link name="a"/>' + FIXED.format(n="left_hip", t="fixed", p="trunk", c="a")),
        ['"left_hip"', "two joints"],
    ),
    **{
        f"a joint called {name}": (URDF.replace('"left_knee"', f'"{name}"'), [name, "Pinocchio"])
        for name in ("universe", "root_joint")
    },
    "an unknown parent": (
        added('<link name="a"/>' + FIXED.format(n="j", t="fixed", p="trnk", c="a")),
        ['joint "j"', '"trnk"', 'did you mean "trunk"'],
    ),
    "two parents": (
        added(FIXED.format(n="j", t="fixed", p="trunk", c="left_foot")),
        ['joint "j"', '"left_foot"', "left_ankle"],
    ),
    "a ring": (
        added(
            '<link name="a"/><link name="b"/>'
            + FIXED.format(n="i", t="fixed", p="a", c="b")
            + FIXED.format(n="j", t="fixed", p="b", c="a")
        ),
        ["a, b", "ring"],
    ),
    "two roots": (added('<link name="alone"/>'), ["trunk, alone", "one root"]),
    "an unknown shape": (
        replaced('<sphere radius="0.02"/>', '<cone radius="0.02"/>'),
        ['link "left_foot"', "<cone>", "capsule"],
    ),
    "two shapes in one": (
        replaced('<sphere radius="0.02"/>', '<sphere radius="0.02"/><box size="1 1 1"/>'),
        ['link "left_foot"', "2 shapes"],
    ),
    "a negative size": (replaced('radius="0.02"/>', 'radius="-0.02"/>'), ["left_foot", "-0.02"]),
    "a size of zero": (replaced('size="0.2 0.3 0.2"', 'size="0.2 0 0.2"'), ["trunk", "0.2 0 0.2"]),
    "a mesh of scale zero": (
        replaced('<sphere radius="0.02"/>', '<mesh filename="a.stl" scale="1 0 1"/>'),
        ['link "left_foot"', 'scale="1 0 1"'],
    ),
    **{
        f"a mesh {name}": (
            replaced('<sphere radius="0.02"/>', f'<mesh filename="{name}"/>'),
            ['link "left_foot"', name, "expected"],
        )
        for name in ("no.stl", "package://no/a.stl", r"a\b.stl", r"C:\a.stl", "http://a/b.stl")
    },
    "a mesh with a name without end": (
        replaced('<sphere radius="0.02"/>', f'<mesh filename="{"x" * 5000}.stl"/>'),
        ['link "left_foot"', "xxx...", "is missing"],
    ),
    "entities": (
        URDF.replace("<robot", '<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/passwd">]>\n<robot', 1),
        ["document type"],
    ),
    "another format": ("<mujoco/>", ["<mujoco>", "expected <robot>"]),
    "not XML": (URDF[:200], ["is not a URDF"]),
    "an encoding that it does not say": (
        URDF.replace("<robot", "<!-- \u817f -->\n<robot", 1).encode("gb2312"),
        ["line 2", "utf-8", "encoding="],
    ),
    "an unknown encoding": (URDF.replace('"1.0"', '"1.0" encoding="klingon"', 1), ["klingon"]),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_urdf_that_is_wrong_is_one_line_about_the_link_or_joint(tmp_path, case):
    urdf, expected = REFUSED[case]
    path = robot_file(tmp_path, urdf)
    with pytest.raises(RobotFileError) as caught:
        build_robot(path)
    message = str(caught.value)
    assert "\n" not in message
    for part in ["strange.toml: urdf", "strange.urdf", *expected]:
        assert part in message, message


def in_encoding(name):
    return URDF.replace('"1.0"', f'"1.0" encoding="{name}"', 1)


@pytest.mark.parametrize(
    "content",
    [
        in_encoding("ISO-8859-1").replace("trunk", "tr\xe4ger").encode("latin-1"),
        in_encoding("gb2312").replace("trunk", "\u817f").encode("gb2312"),
        codecs.BOM_UTF8 + URDF.replace("trunk", "\u817f").encode(),
        URDF.replace("trunk", "\u817f").encode("utf-16"),
        URDF.replace("<robot", '<robot xmlns="http://www.ros.org"').encode(),
    ],
    ids=["latin-1", "gb2312", "with a mark", "utf-16", "a namespace"],
)
def test_bytes_are_read_as_xml_says(tmp_path, content):
    robot = build_robot(robot_file(tmp_path, content))
    assert robot.mass == pytest.approx(5 + 2 * 1.7)


def test_joints_that_mimic_are_held_together(tmp_path):
    urdf = added(FINGERS)
    robot = build_robot(robot_file(tmp_path, urdf, "[urdf.held]\nf1 = 0.3\nf2 = -0.2"))
    agrees(robot, urdf)
    for held, expected in (("f1 = 0.3\nf2 = 0.2", "expected -0.2 rad"), ("f2 = 0.1", "not held")):
        with pytest.raises(RobotFileError, match=f"urdf.held.f2: it mimics f1.*{expected}"):
            build_robot(robot_file(tmp_path, urdf, f"[urdf.held]\n{held}"))


@pytest.mark.parametrize("command", ["plan --robot", "simulate --robot", "robot new"])
def test_commands_refuse_it_in_one_line(tmp_path, monkeypatch, capsys, command):
    path = robot_file(tmp_path, REFUSED["xacro not run"][0])
    if command == "robot new":
        path.unlink()
    monkeypatch.chdir(tmp_path)
    file = "strange.urdf" if command == "robot new" else "./strange.toml"
    assert main([*command.split(), file]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert len(err.strip().splitlines()) == 1
    assert 'link "trunk"' in err

"""Held joints and added frames, against Pinocchio's own way to lock joints of the whole robot."""

import math

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.errors import RobotFileError
from llsrbm.robots.description import changed, read_description
from llsrbm.robots.schema import AddedFrame, UrdfSource, robot_files
from llsrbm.robots.urdf import pinocchio_model

INERTIAL = """<inertial><origin xyz="{c} 0.02 -0.1" rpy="0.1 0.2 {c}"/><mass value="{m}"/>
<inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0.002" iyz="0.003"/></inertial>"""
ARMS = {
    "waist": ("continuous", "0 0 1"),
    "shoulder": ("revolute", "0.6 0 0.8"),
    "hand": ("prismatic", "1 2 2"),
}
LIMITS = {"waist": (-9.0, 9.0), "shoulder": (-1.0, 2.0), "hand": (-0.1, 0.3)}


def link(name: str, mass: float) -> str:
    return f'<link name="{name}">{INERTIAL.format(c=mass / 10, m=mass)}</link>'


def joint(name: str, kind: str, parent: str, child: str, axis: str) -> str:
    lower, upper = LIMITS.get(name, (-2.0, 2.0))
    return f"""<joint name="{name}" type="{kind}"><origin xyz="0.1 {len(name) / 20} -0.2"
    rpy="0.3 -0.4 {len(name) / 10}"/><parent link="{parent}"/><child link="{child}"/>
    <axis xyz="{axis}"/><dynamics damping="1"/>
    <limit lower="{lower}" upper="{upper}" effort="10" velocity="5"/></joint>"""


SMALL = "\n".join(
    [
        '<?xml version="1.0"?><robot name="small"><!-- a leg and an arm of three joints -->',
        link("trunk", 5.0),
        *(link(f"{name}_link", 1.0 + k) for k, name in enumerate(ARMS)),
        link("thigh", 2.0),
        link("shank", 1.5),
        joint("waist", *ARMS["waist"][:1], "trunk", "waist_link", ARMS["waist"][1]),
        joint("shoulder", "revolute", "waist_link", "shoulder_link", ARMS["shoulder"][1]),
        joint("hand", "prismatic", "shoulder_link", "hand_link", ARMS["hand"][1]),
        joint("hip", "revolute", "trunk", "thigh", "0 1 0"),
        joint("knee", "revolute", "thigh", "shank", "0 1 0"),
        "</robot>",
    ]
)
FEET = {"leg": "shank"}


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    path = tmp_path_factory.mktemp("urdf") / "small.urdf"
    path.write_text(SMALL)
    return path


def adapted(urdf, held=None, frames=None, feet=FEET):
    """The description as a robot file with these tables has it."""
    source = UrdfSource(file="x.urdf", held=held or {}, frames=frames or {})
    return changed(read_description(urdf, str(urdf)), source, feet, "mine.toml")


def free(robot):
    return pinocchio_model(robot, "mine.toml")


def test_a_waist_that_moves_all_feet_can_be_held(tmp_path):
    """With feet on both of its sides it cannot: the legs would lose a joint."""
    urdf = tmp_path / "two.urdf"
    other = [link("other", 1.0), joint("other_hip", "revolute", "waist_link", "other", "0 1 0")]
    urdf.write_text(SMALL.replace("</robot>", "".join(other) + "</robot>"))
    feet = {"one": "hand_link", "two": "other"}
    assert not adapted(urdf, {"waist": 0.3}, feet=feet).joints["waist"].moves
    with pytest.raises(RobotFileError, match=r"moves the foot of leg two; .* no foot, or all"):
        adapted(urdf, {"waist": 0.3}, feet=feet | {"three": "shank"})


def locked(urdf, held):
    """The robot with the same joints locked by Pinocchio, read from the URDF as it is."""
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    q = pin.neutral(model)
    for name, angle in held.items():
        joint = model.joints[model.getJointId(name)]
        turns = [math.cos(angle), math.sin(angle)]
        q[joint.idx_q : joint.idx_q + joint.nq] = angle if joint.nq == 1 else turns
    return pin.buildReducedModel(model, [model.getJointId(name) for name in held], q)


def posture(model, angles):
    q = pin.neutral(model)
    for name in list(model.names)[2:]:
        joint = model.joints[model.getJointId(name)]
        turns = [math.cos(angles[name]), math.sin(angles[name])]
        q[joint.idx_q : joint.idx_q + joint.nq] = angles[name] if joint.nq == 1 else turns
    return q


def compare(ours, theirs, angles, foot):
    assert list(ours.names) == list(theirs.names)
    ours_data, theirs_data = ours.createData(), theirs.createData()
    for model, data in ((ours, ours_data), (theirs, theirs_data)):
        q = posture(model, angles)
        pin.ccrba(model, data, q, np.zeros(model.nv))
        pin.crba(model, data, q)
        pin.framesForwardKinematics(model, data, q)
    assert ours_data.Ig.mass == pytest.approx(theirs_data.Ig.mass, rel=1e-12)
    np.testing.assert_allclose(ours_data.com[0], theirs_data.com[0], atol=1e-10)
    np.testing.assert_allclose(ours_data.Ig.inertia, theirs_data.Ig.inertia, atol=1e-9)
    np.testing.assert_allclose(ours_data.M, theirs_data.M, atol=1e-9)  # every joint's share
    places = [
        data.oMf[model.getFrameId(foot)].homogeneous
        for model, data in ((ours, ours_data), (theirs, theirs_data))
    ]
    np.testing.assert_allclose(*places, atol=1e-10)


@settings(max_examples=20)
@given(
    held=st.fixed_dictionaries({}, optional={n: st.floats(*LIMITS[n]) for n in ARMS}),
    legs=st.tuples(st.floats(-2, 2), st.floats(-2, 2)),
    others=st.floats(-0.1, 0.3),
)
def test_held_joints_are_as_pinocchio_locks_them(small, held, legs, others):
    ours, theirs = free(adapted(small, held)), locked(small, held)
    angles = dict.fromkeys(ARMS, others) | {"hip": legs[0], "knee": legs[1]}
    compare(ours, theirs, angles, "shank")


@settings(max_examples=10)
@given(
    xyz=st.tuples(*[st.floats(-1, 1)] * 3),
    rpy=st.tuples(*[st.floats(-3, 3)] * 3),
    knee=st.floats(-2, 2),
)
def test_an_added_frame_is_where_it_is_said_to_be(small, xyz, rpy, knee):
    frames = {"sole": AddedFrame(link="shank", xyz=xyz, rpy=rpy)}
    model, before = free(adapted(small, frames=frames)), free(adapted(small))
    assert model.nq == before.nq
    assert pin.computeTotalMass(model) == pytest.approx(pin.computeTotalMass(before))
    q = pin.neutral(model)
    q[model.joints[model.getJointId("knee")].idx_q] = knee
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    shank, sole = (data.oMf[model.getFrameId(name)] for name in ("shank", "sole"))
    expected = shank * pin.SE3(pin.rpy.rpyToMatrix(*rpy), np.array(xyz))
    np.testing.assert_allclose(sole.homogeneous, expected.homogeneous, atol=1e-10)


def test_without_the_tables_nothing_changes(small):
    assert adapted(small) == read_description(small, "small")
    for path in robot_files().values():
        table = UrdfSource(file=path.name).model_dump(mode="json")
        assert table == {"package": None, "path": None, "file": path.name}


WRONG = {
    "no such joint": (
        {"wiast": 0.0},
        {},
        ["urdf.held", '"wiast"', 'did you mean "waist"?', "waist, shoulder, hand, hip, knee"],
    ),
    "beyond its limits": (
        {"shoulder": 2.5},
        {},
        ["urdf.held.shoulder", "expected -1 to 2 rad, as the URDF limits it", "got 2.5"],
    ),
    "beyond the limits of what slides": (
        {"hand": -0.2},
        {},
        ["expected -0.1 to 0.3 m", "got -0.2"],
    ),
    "a foot's joint": (
        {"knee": 0.0},
        {},
        ["urdf.held.knee", "moves the foot of leg leg", "waist, shoulder, hand"],
    ),
    "no such link": (
        {},
        {"sole": AddedFrame(link="shnak", xyz=(0.0, 0.0, 0.0))},
        ["urdf.frames.sole.link", '"shnak"', 'did you mean "shank"?'],
    ),
    "a name that is taken": (
        {},
        {"thigh": AddedFrame(link="shank", xyz=(0.0, 0.0, 0.0))},
        ["urdf.frames.thigh", "expected a new name"],
    ),
}


@pytest.mark.parametrize("mistake", WRONG)
def test_a_mistake_is_one_clear_line(small, mistake):
    held, frames, expected = WRONG[mistake]
    with pytest.raises(RobotFileError) as caught:
        adapted(small, held, frames)
    message = str(caught.value)
    assert "\n" not in message
    for part in ["mine.toml", *expected]:
        assert part in message

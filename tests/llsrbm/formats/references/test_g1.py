"""G1's jump as trainers of its 29 joints read it, by their published layouts.

Joints and bodies are listed here as Unitree's MJCF (mjlab), LAFAN1's retargeted tables and Isaac
Lab (BeyondMimic) have them; where bodies are and how they move is held against Pinocchio on the
URDF with 29 free joints. Waist and wrists are held in plans.
"""

import json
import pickle

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import llsrbm
from llsrbm.formats import export
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned

LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow")
WRIST = ("wrist_roll", "wrist_pitch", "wrist_yaw")
WAIST = ("waist_yaw", "waist_roll", "waist_pitch")
PARTS = [
    *(f"{side}_{part}" for side in ("left", "right") for part in LEG),
    *WAIST,
    *(f"{side}_{part}" for side in ("left", "right") for part in ARM + WRIST),
]
JOINTS = [f"{part}_joint" for part in PARTS]
LINKS = ["torso_link" if part == "waist_pitch" else f"{part}_link" for part in PARTS]
# Where each of these joints is in Isaac Lab's order, as converters between both have it.
IN_ISAAC_LAB = [
    *(0, 3, 6, 9, 13, 17, 1, 4, 7, 10, 14, 18, 2, 5, 8),
    *(11, 15, 19, 21, 23, 25, 27, 12, 16, 20, 22, 24, 26, 28),
]
HELD = [
    JOINTS.index(f"{part}_joint")
    for part in (*WAIST, *(f"{s}_{w}" for s in ("left", "right") for w in WRIST))
]
ARMS = [JOINTS.index(f"{side}_{part}_joint") for side in ("left", "right") for part in ARM]
FPS = 250
STEP = 1 / FPS


@pytest.fixture(scope="module")
def rollout():
    return llsrbm.simulate(planned("g1"), seed=0)


@pytest.fixture(scope="module")
def jump(rollout):
    return rollout


@pytest.fixture(scope="module")
def model():
    """Pinocchio's, all 29 joints free."""
    return pin.buildModelFromUrdf(str(load_robot("g1").urdf_path), pin.JointModelFreeFlyer())


@pytest.fixture(scope="module", params=["depth-first", "breadth-first"])
def tracked(jump, request, tmp_path_factory):
    """A motion-tracking file's arrays with joints and bodies as `JOINTS` and `LINKS` have them, and
    whether it is Isaac Lab's."""
    path = tmp_path_factory.mktemp("g1") / "jump.npz"
    export(jump, path, format="motion-npz", order=request.param, fps=FPS)
    with np.load(path) as data:
        arrays = {key: data[key] for key in data.files}
    isaac = request.param == "breadth-first"
    places = np.array(IN_ISAAC_LAB if isaac else range(29))
    assert arrays["joint_names"][places].tolist() == JOINTS
    bodies = [0, *(places + 1)]
    assert arrays["body_names"][bodies].tolist() == ["pelvis", *LINKS]
    for key, at in {"joint": places, "body": bodies}.items():
        arrays |= {k: v[:, at] for k, v in arrays.items() if k.startswith(f"{key}_") and v.ndim > 1}
    return arrays, isaac


def differences(values):
    """(K - 2, ...) per s at the inner frames."""
    return (values[2:] - values[:-2]) / (2 * STEP)


def test_bodies_are_where_the_joints_put_them(tracked, model):
    arrays, _ = tracked
    assert arrays["joint_pos"].shape[1] == 29
    data = model.createData()
    quat = arrays["body_quat_w"]
    np.testing.assert_allclose(quat[0, 0], [1, 0, 0, 0], atol=0.03)
    for k in range(0, len(quat), 10):
        q = pin.neutral(model)
        q[:3], q[3:7] = arrays["body_pos_w"][k, 0], quat[k, 0, [1, 2, 3, 0]]
        for name, angle in zip(JOINTS, arrays["joint_pos"][k], strict=True):
            q[model.joints[model.getJointId(name)].idx_q] = angle
        pin.forwardKinematics(model, data, q)
        pin.updateFramePlacements(model, data)
        frames = [data.oMf[model.getFrameId(link, pin.FrameType.BODY)] for link in LINKS]
        positions = np.array([frame.translation for frame in frames])
        np.testing.assert_allclose(arrays["body_pos_w"][k, 1:], positions, atol=1e-9)
        attitudes = Rotation.from_quat(quat[k, 1:], scalar_first=True).as_matrix()
        wanted = np.array([frame.rotation for frame in frames])
        np.testing.assert_allclose(attitudes, wanted, atol=1e-9)


def test_velocities_are_those_of_the_positions(tracked, model):
    arrays, isaac = tracked
    attitude = Rotation.from_quat(arrays["body_quat_w"].reshape(-1, 4), scalar_first=True)
    shape = arrays["body_pos_w"].shape
    points = arrays["body_pos_w"]
    if isaac:  # centres of mass
        levers = [model.inertias[1].lever]
        levers += [model.inertias[model.getJointId(name)].lever for name in JOINTS]
        points = points + attitude.apply(np.tile(levers, (shape[0], 1))).reshape(shape)
    turned = (attitude[: -2 * shape[1]].inv() * attitude[2 * shape[1] :]).as_rotvec() / (2 * STEP)
    middle = attitude[shape[1] : -shape[1]].apply(turned).reshape(shape[0] - 2, *shape[1:])
    for key, rate in {
        "joint_vel": differences(arrays["joint_pos"]),
        "body_lin_vel_w": differences(points),
        "body_ang_vel_w": middle,
    }.items():
        exact = arrays[key]
        # Of the worst body or joint at each frame; they jump at lift-off and touchdown.
        off = np.abs(exact[1:-1] - rate).reshape(len(rate), -1).max(axis=1)
        assert np.quantile(off, 0.5) < 0.005 * np.abs(exact).max(), key
        assert np.quantile(off, 0.9) < 0.02 * np.abs(exact).max(), key


def test_waist_and_wrists_are_held_and_arms_move(tracked):
    arrays, _ = tracked
    assert not arrays["joint_pos"][:, HELD].any()
    assert not arrays["joint_vel"][:, HELD].any()
    assert np.ptp(arrays["joint_pos"][:, ARMS], axis=0).max() > 0.3


def test_a_table_has_a_column_a_joint_in_unitrees_order(jump, tmp_path):
    path = tmp_path / "jump.csv"
    export(jump, path, format="unitree-csv")
    rows = np.loadtxt(path, delimiter=",")
    assert rows.shape[1] == 7 + 29
    told = json.loads((tmp_path / "jump.csv.meta.json").read_text())
    assert told["joint_order"] == JOINTS
    assert told["column_units"] == [*"mmm1111", *["rad"] * 29]
    np.testing.assert_allclose(rows[0, 3:7], [0, 0, 0, 1], atol=0.03)
    assert Rotation.from_quat(rows[-1, 3:7]).as_euler("zyx")[0] == pytest.approx(2.1, abs=0.1)
    assert not rows[:, 7:][:, HELD].any()
    own = dict(zip(jump.joint_names, jump.joint_position[-1], strict=True))
    for column in range(29):
        if column not in HELD:
            wanted = own[JOINTS[column]]
            assert rows[-1, 7 + column] == pytest.approx(wanted, abs=1e-6), JOINTS[column]


def test_other_trainers_have_all_joints_too(rollout, tmp_path):
    for name, suffix in {
        "gmr-pkl": "pkl",
        "mimickit-pkl": "pkl",
        "motion-imitation-json": "json",
    }.items():
        export(rollout, tmp_path / f"{name}.{suffix}", format=name)
    gmr = pickle.loads((tmp_path / "gmr-pkl.pkl").read_bytes())
    assert gmr["link_body_list"] == ["pelvis", *LINKS]
    assert gmr["local_body_pos"].shape[1:] == (30, 3)
    mimickit = pickle.loads((tmp_path / "mimickit-pkl.pkl").read_bytes())
    clip = json.loads((tmp_path / "motion-imitation-json.json").read_text())
    assert clip["JointOrder"] == JOINTS
    own = {name: rollout.joint_position[-1, k] for k, name in enumerate(rollout.joint_names)}
    wanted = [own.get(joint, 0.0) for joint in JOINTS]
    last = (gmr["dof_pos"][-1], mimickit["frames"][-1][6:], clip["Frames"][-1][7:])
    for joints in last:
        np.testing.assert_allclose(joints, wanted, atol=1e-6)


@pytest.mark.parametrize("format_", ["motion-npz", "unitree-csv"])
def test_held_joints_are_left_out_again_when_opened(rollout, tmp_path, format_):
    path = tmp_path / ("jump.npz" if format_ == "motion-npz" else "jump.csv")
    export(rollout, path, format=format_, fps=50)
    motion = llsrbm.load_motion(path, robot="g1")
    assert motion.joint_position.shape[1] == len(rollout.joint_names) == 20
    np.testing.assert_allclose(motion.joint_position[-1], rollout.joint_position[-1], atol=1e-6)

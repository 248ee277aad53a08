"""OPT-Mimic's reference, read as its trainer reads it, with 12 joints in place of 8."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.errors import InputError
from llsrbm.formats import export
from llsrbm.installed import assets_directory
from llsrbm.motion.plan import load_plan
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import HALF_TURN, planned, same_attitude, simulated
from tests.llsrbm.formats.wire.jumps import KINDS, TWIST, beside, jump, rate_of

JOINTS = [f"{leg}_{part}" for leg in ("FL", "FR", "HL", "HR") for part in ("HAA", "HFE", "KFE")]
SOME_TORQUE = 1e-5  # Nm2: less, summed over a leg, means to its trainer that the leg is in the air


def loaded(path):
    """Rows as stod of what stands between commas, cut where its reader cuts them."""
    lines = path.read_text().splitlines()
    rows = np.array([[float(entry) for entry in line.split(",")] for line in lines])
    assert rows.shape[1] == 14 + 3 * 12
    ends = (1, 4, 8, 11, 14, 26, 38)
    names = ("t", "position", "quat", "velocity", "turning", "q", "dq", "tau")
    return dict(zip(names, np.split(rows, ends, axis=1), strict=True))


@pytest.fixture(scope="module", params=KINDS)
def kind(request):
    return request.param


@pytest.fixture(scope="module")
def motion(kind, tmp_path_factory):
    path = tmp_path_factory.mktemp("opt-mimic") / "jump.csv"
    export(jump("solo12", kind), path, format="opt-mimic-csv", fps=rate_of("solo12"))
    return loaded(path)


def test_rows_are_the_robots_states(tmp_path):
    rollout = simulated("solo12", TWIST)
    export(rollout, tmp_path / "x.csv", format="opt-mimic-csv", fps=rate_of("solo12"))
    motion, ticks = loaded(tmp_path / "x.csv"), np.arange(0, len(rollout.time), 2)
    motion = {name: values[: len(ticks)] for name, values in motion.items()}
    qpos, qvel = rollout.qpos[ticks], rollout.qvel[ticks]
    columns = [rollout.joint_names.index(joint) for joint in JOINTS]
    np.testing.assert_allclose(motion["position"], qpos[:, :3], atol=1e-9)
    same_attitude(motion["quat"], qpos[:, 3:7], atol=1e-9)
    np.testing.assert_allclose(motion["velocity"], qvel[:, :3], atol=1e-9)
    R = Rotation.from_quat(qpos[:, 3:7], scalar_first=True)
    np.testing.assert_allclose(motion["turning"], R.apply(qvel[:, 3:6]), atol=1e-9)
    np.testing.assert_allclose(motion["q"], qpos[:, 7:][:, columns], atol=1e-9)
    np.testing.assert_allclose(motion["dq"], qvel[:, 6:][:, columns], atol=1e-9)


def test_a_leg_is_in_contact_where_its_torques_are_not_zero(kind, motion):
    trajectory = jump("solo12", kind)
    time = motion["t"][:, 0]
    inside = (time > 0) & (time < trajectory.time[-1] - trajectory.time[0])
    at = np.searchsorted(trajectory.time - trajectory.time[0], time + 1e-9, side="right") - 1
    legs = motion["tau"].reshape(len(time), 4, 3)
    read = (legs**2).sum(axis=2) > SOME_TORQUE
    order = [trajectory.leg_names.index(leg) for leg in ("FL", "FR", "RL", "RR")]
    stands = np.asarray(trajectory.contact, dtype=bool)[at][:, order]
    assert not read[inside & ~stands.any(axis=1)].any()
    assert (read == stands)[inside].mean() > (0.999 if kind == "plan" else 0.98)


def test_knees_of_a_standing_robot_have_the_published_signs(motion):
    """In its own files FL and FR: q < 0, tau > 0 at the knee, HL and HR the other way round."""
    knees = [2, 5, 8, 11]
    assert (np.sign(motion["q"][0, knees]) == [-1, -1, 1, 1]).all()
    pushing = motion["tau"][: len(motion["tau"]) // 5, knees]
    assert (np.sign(np.median(pushing, axis=0)) == [1, 1, -1, -1]).all()


def test_torques_do_the_work_of_the_forces(tmp_path):
    """By finite differences of where the feet are, seen from a base at rest."""
    plan, robot = planned("solo12", TWIST), load_robot("solo12")
    export(plan, tmp_path / "x.csv", format="opt-mimic-csv", fps=100)
    motion = loaded(tmp_path / "x.csv")
    model, data = robot.model, robot.model.createData()
    columns = [robot.joint_names.index(joint) for joint in JOINTS]
    k = 10
    force = plan.contact_force[np.searchsorted(plan.time, motion["t"][k, 0] + 1e-9) - 1]

    def feet(q):
        pin.framesForwardKinematics(model, data, q)
        return np.array([data.oMf[leg.foot_frame_id].translation for leg in robot.legs])

    q = np.concatenate([motion["position"][k], np.roll(motion["quat"][k], -1), np.zeros(12)])
    q[7:][columns] = motion["q"][k]
    for joint, column in enumerate(columns):
        step = np.zeros(len(q))
        step[7 + column] = 1e-6
        moved = (feet(q + step) - feet(q - step)) / 2e-6
        assert motion["tau"][k, joint] == pytest.approx(-np.sum(moved * force), abs=1e-5)


def test_50_rows_a_second_that_its_trainer_takes(tmp_path):
    export(planned("solo12", TWIST), tmp_path / "x.csv", format="opt-mimic-csv")
    time = loaded(tmp_path / "x.csv")["t"][:, 0]
    assert (np.abs(time - 0.02 * np.arange(len(time))) < 1e-9).all()
    told = beside(tmp_path / "x.csv")
    assert told["fps"] == 50
    assert told["joint_order"] == JOINTS
    assert told["columns"][:8] == ["t", "x", "y", "z", "qw", "qx", "qy", "qz"]
    assert len(told["columns"]) == 50


def test_the_quaternion_begins_with_w_and_does_not_jump(tmp_path):
    export(planned("anymal", HALF_TURN), tmp_path / "x.csv", format="opt-mimic-csv")
    quat = loaded(tmp_path / "x.csv")["quat"]
    assert quat[0, 0] > 0.99
    assert (np.sum(quat[1:] * quat[:-1], axis=1) > 0.9).all()


def test_a_biped_has_no_such_legs(tmp_path):
    plan = load_plan(assets_directory() / "plans" / "slider.npz")
    with pytest.raises(InputError, match="slider is no quadruped"):
        export(plan, tmp_path / "x.csv", format="opt-mimic-csv")
    assert not list(tmp_path.iterdir())

"""The folder for MuJoCo, opened by MuJoCo in a process that does not import this project."""

import itertools
import json
import subprocess
import sys
import zipfile
from dataclasses import replace
from textwrap import indent

import mujoco
import numpy as np
import pytest

from llsrbm.errors import InputError
from llsrbm.formats import export
from llsrbm.look.shown_motion import surroundings_of
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.sampling import resample
from llsrbm.request.scenario import Scenario
from llsrbm.robots import load_robot
from llsrbm.simulation.scene import build_scene
from tests.llsrbm.formats.jumps import ROBOTS, planned, simulated

FEET = {"anymal": ("LF", "RF", "LH", "RH"), "slider": ("left", "right")}

# What a stranger would write: forward kinematics of every frame, nothing but MuJoCo and NumPy.
IMPORTS = "import sys\nimport mujoco, numpy as np\n"
EACH = "for folder, result in zip(sys.argv[1::2], sys.argv[2::2]):\n"
REPLAY = """
model = mujoco.MjModel.from_xml_path(folder + "/scene.xml")
data = mujoco.MjData(model)
motion = dict(np.load(folder + "/motion.npz", allow_pickle=False))
feet = [g for g in range(model.ngeom) if model.geom(g).name.startswith("foot-")]
found = {key: [] for key in ("feet", "com", "momentum", "spin")}
for qpos, qvel, mocap in zip(motion["qpos"], motion["qvel"], motion["mocap_pos"], strict=True):
    data.qpos[:], data.qvel[:], data.mocap_pos[:] = qpos, qvel, mocap
    mujoco.mj_forward(model, data)
    mujoco.mj_subtreeVel(model, data)
    robot = model.body(1).id
    found["feet"].append(data.geom_xpos[feet])
    found["com"].append(data.subtree_com[robot].copy())
    found["momentum"].append(data.subtree_linvel[robot] * model.body_subtreemass[robot])
    found["spin"].append(data.subtree_angmom[robot].copy())
names = [model.geom(g).name for g in feet]
joints = [model.joint(j).name for j in range(1, model.njnt)]
motors = [model.actuator(a).name for a in range(model.nu)]
assert "llsrbm" not in sys.modules
np.savez(result, **found, foot_names=names, radius=model.geom_size[feet, 0], joints=joints,
         motors=motors, mass=model.body_mass.sum(), ctrlrange=model.actuator_ctrlrange,
         forcerange=model.actuator_forcerange, limits=model.jnt_range[1:])
"""


def alone(program, *arguments, cwd=None):
    """Run in a process of its own, in isolated mode."""
    done = subprocess.run(
        [sys.executable, "-I", "-c", program, *map(str, arguments)],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


class Case:
    """A robot's plan and rollout, their folders, and what MuJoCo alone makes of them."""

    def __init__(self, name, folder):
        self.name = name
        self.robot = load_robot(name)
        self.plan = planned(name)
        self.rollout = replace(simulated(name), plan=self.plan)
        self.rate = self.robot.file.control.rate
        self.folders = {}
        for key, trajectory, options in (
            ("plan", self.plan, {}),
            ("rollout", self.rollout, {}),
            ("ticks", self.rollout, {"fps": self.rate}),
        ):
            self.folders[key] = folder / key
            export(trajectory, self.folders[key], "mujoco", **options)

    def motion(self, key):
        with np.load(self.folders[key] / "motion.npz", allow_pickle=False) as file:
            return dict(file)

    def replayed(self, key):
        results = {
            each: path.with_name(f"{each}-replayed.npz") for each, path in self.folders.items()
        }
        if not results[key].exists():
            pairs = zip(self.folders.values(), results.values(), strict=True)
            alone(IMPORTS + EACH + indent(REPLAY, "    "), *itertools.chain(*pairs))
        with np.load(results[key]) as file:
            return dict(file)

    def model(self, key="rollout"):
        return mujoco.MjModel.from_xml_path(str(self.folders[key] / "scene.xml"))

    def foot_position(self, key):
        """(T, L, 3): the middle of each foot's spheres, at their lowest."""
        found = self.replayed(key)
        names = found["foot_names"].tolist()
        feet = []
        for leg in FEET[self.name]:
            own = [i for i, name in enumerate(names) if name.split("-")[1] == leg]
            middle = found["feet"][:, own].mean(axis=1)
            feet.append(middle - [0, 0, found["radius"][own[0]]])
        return np.stack(feet, axis=1)


@pytest.fixture(scope="module", params=ROBOTS)
def case(request, tmp_path_factory):
    return Case(request.param, tmp_path_factory.mktemp(request.param))


@pytest.fixture(scope="module")
def anymal():
    return planned("anymal")


def test_feet_are_where_the_rollout_says(case):
    assert case.rollout.leg_names == FEET[case.name]
    at_ticks = case.foot_position("ticks")
    np.testing.assert_allclose(at_ticks, case.rollout.foot_position, atol=1e-6)
    between = resample(case.rollout, case.motion("rollout")["time"]).foot_position
    error = np.abs(case.foot_position("rollout") - between).max()
    assert error < 1e-3


def test_a_plan_stands_on_its_ground(case):
    """Point feet are points in a plan and balls in the model: its ground is that much lower."""
    ground = case.model("plan").geom("world-ground").pos[2]
    feet = case.foot_position("plan")
    assert feet[0, :, 2].min() == pytest.approx(ground, abs=1e-6)
    assert feet[-1, :, 2].min() == pytest.approx(case.plan.jump.height + ground, abs=5e-3)
    assert {"anymal": -0.02, "slider": -1e-6}[case.name] < ground < 1e-6
    planned = resample(case.plan, case.motion("plan")["time"]).foot_position
    assert np.abs(feet - planned - [0, 0, ground]).max() < 0.025  # ANYmal's balls are off-centre


def test_velocities_are_in_mujocos_frames(case):
    """Momenta by MuJoCo, which hang on the axes of both of the base's velocities."""
    found = case.replayed("ticks")
    for ours, key in (("linear_momentum", "momentum"), ("angular_momentum", "spin")):
        expected = getattr(case.rollout, ours)
        np.testing.assert_allclose(found[key], expected, atol=1e-6 * np.abs(expected).max())


def test_joints_and_motors_are_depth_first_and_limited(case):
    found, robot = case.replayed("rollout"), case.robot
    joints = found["joints"].tolist()
    assert joints == found["motors"].tolist() == case.motion("rollout")["joint_names"].tolist()
    assert joints == list(case.rollout.joint_names)  # the simulator's own order
    order = [robot.joint_names.index(name) for name in joints]
    limit = robot.torque_limit[order]
    np.testing.assert_allclose(found["ctrlrange"], np.stack([-limit, limit], axis=1), rtol=1e-5)
    np.testing.assert_array_equal(found["forcerange"], found["ctrlrange"])
    lower = robot.model.lowerPositionLimit[7:][order]
    np.testing.assert_allclose(found["limits"][:, 0], lower, atol=1e-5)


def test_joints_have_the_drives_rotors_and_friction(case):
    """With all digits, as MuJoCo alone reads them."""
    model, robot = case.model(), case.robot
    order = [robot.joint_names.index(model.joint(j).name) for j in range(1, model.njnt)]
    assert (robot.armature > 0).all()
    np.testing.assert_array_equal(model.dof_armature[6:], robot.armature[order])
    np.testing.assert_array_equal(model.dof_frictionloss[6:], robot.friction[order])
    np.testing.assert_array_equal(model.dof_damping[6:], robot.damping[order])
    assert not model.dof_armature[:6].any()


def test_time_and_rate(case):
    for key, trajectory, fps in (
        ("plan", case.plan, 500),
        ("rollout", case.rollout, 500),
        ("ticks", case.rollout, case.rate),
    ):
        motion = case.motion(key)
        assert motion["fps"] == fps
        np.testing.assert_allclose(motion["time"], np.arange(len(motion["qpos"])) / fps, atol=1e-9)
        assert 0 <= motion["time"][-1] - trajectory.duration + 1e-6 < 1 / fps + 2e-6
    np.testing.assert_allclose(case.motion("ticks")["ctrl"], case.rollout.torque, atol=1e-9)


def test_keyframes(case):
    for key in ("plan", "rollout"):
        model, motion = case.model(key), case.motion(key)
        names = [model.key(i).name for i in range(model.nkey)]
        assert names == ["start", "lift-off", "touchdown", "end"]
        assert (np.diff(model.key_time) > 0).all()
        for row, k in ((0, 0), (-1, -1)):
            np.testing.assert_allclose(model.key_qpos[row], motion["qpos"][k], atol=1e-6)
            # At its end the motion rests, a robot all but rests.
            atol = 1e-4 if row == 0 else 5e-3
            np.testing.assert_allclose(model.key_qvel[row], motion["qvel"][k], atol=atol)
            np.testing.assert_allclose(model.key_ctrl[row], motion["ctrl"][k], atol=1e-6)
    assert case.model("plan").key_time == pytest.approx(case.plan.phase_start)
    model, time = case.model("rollout"), case.rollout.time
    lift_off, touchdown = (int(np.argmin(np.abs(time - t))) for t in model.key_time[1:3])
    contact = case.rollout.contact
    assert contact[lift_off - 1].any()
    assert not contact[lift_off:touchdown].any()
    assert contact[touchdown].any()


def test_the_model_is_that_of_the_simulation(case):
    """The same accelerations, constraints and options where the feet press on the ground."""
    exported = case.model()
    tick = 1 / case.rate
    steps = int(np.ceil(tick / 5e-4 - 1e-9))
    around = surroundings_of(case.rollout, case.robot)
    ours = build_scene(case.robot, around, Disturbance(), tick / steps)
    for name in ("timestep", "cone", "impratio", "integrator", "gravity"):
        assert np.array_equal(getattr(exported.opt, name), getattr(ours.model.opt, name)), name
    assert exported.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    motors = [case.robot.joint_names.index(name) for name in case.rollout.joint_names]
    for row in range(exported.nkey):
        accelerations = []
        for model, order in ((exported, slice(None)), (ours.model, np.argsort(motors))):
            data = mujoco.MjData(model)
            data.qpos[:], data.qvel[:] = exported.key_qpos[row], exported.key_qvel[row]
            data.ctrl[:] = exported.key_ctrl[row][order]
            data.mocap_pos[:] = exported.key_mpos[row].reshape(-1, 3)
            mujoco.mj_forward(model, data)
            accelerations.append(data.qacc.copy())
        scale = np.abs(accelerations[1]).max()
        np.testing.assert_allclose(*accelerations, atol=1e-4 * scale + 1e-6)


def test_its_torques_move_the_exported_robot_as_they_moved_ours(case):
    """In flight, from lift-off to touchdown; without the rotors joints are elsewhere by far."""
    motion, model = case.motion("ticks"), case.model("ticks")
    lift_off, touchdown = np.searchsorted(motion["time"], model.key_time[1:3] - 1e-9)
    steps = round(1 / case.rate / model.opt.timestep)
    missed = []
    for rotors in (1.0, 0.0):
        model.dof_armature *= rotors
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = motion["qpos"][lift_off], motion["qvel"][lift_off]
        for ctrl in motion["ctrl"][lift_off:touchdown]:
            data.ctrl[:] = ctrl
            mujoco.mj_step(model, data, steps)
        missed.append(np.abs(data.qpos - motion["qpos"][touchdown])[7:].max())
    assert missed[0] < 0.02  # rad or m: torques are means of ticks
    assert missed[1] > 10 * missed[0]


@pytest.mark.parametrize("case", ["anymal"], indirect=True)
def test_the_program_in_the_readme_replays_it(case):
    """With a window that only counts, which is all that is ours about it."""
    text = (case.folders["rollout"] / "README.txt").read_text()
    program = "\n".join(line[4:] for line in text.splitlines() if line.startswith("    "))
    window = """
import contextlib, sys, time, types
shown = []
class Window:
    def sync(self): shown.append(1)
def launch_passive(model, data): return contextlib.nullcontext(Window())
viewer = types.ModuleType("mujoco.viewer")
viewer.launch_passive = launch_passive
import mujoco
mujoco.viewer = sys.modules["mujoco.viewer"] = viewer
waited = []
time.sleep = waited.append
"""
    report = """
assert "llsrbm" not in sys.modules
print(len(shown), sum(waited), *data.qpos[:3])
"""
    folder = case.folders["rollout"]
    count, waited, *base = alone(window + program + report, cwd=folder).split()
    motion = case.motion("rollout")
    assert int(count) == len(motion["time"])
    assert float(waited) == pytest.approx(int(count) / 500)
    np.testing.assert_allclose(np.array(base, dtype=float), motion["qpos"][-1, :3], atol=1e-12)


def test_again_zipped_and_over_something_else(anymal, tmp_path):
    folder = tmp_path / "out"
    for fps in (60, 50):
        export(anymal, folder, "mujoco", fps=fps)
        assert np.load(folder / "motion.npz")["fps"] == fps
    export(anymal, tmp_path / "out.zip", "mujoco")
    with zipfile.ZipFile(tmp_path / "out.zip") as archive:
        archive.extractall(tmp_path / "unpacked")
    (inner,) = (tmp_path / "unpacked").iterdir()
    assert inner.name.startswith("anymal_")
    assert inner.name.endswith("_mujoco")
    mujoco.MjModel.from_xml_path(str(inner / "scene.xml"))
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.tex").write_text("years")
    with pytest.raises(InputError, match="other things"):
        export(anymal, other, "mujoco")
    assert [file.name for file in other.iterdir()] == ["thesis.tex"]


def blocks_in(folder):
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    with np.load(folder / "motion.npz") as motion:
        time, places = motion["time"], motion["mocap_pos"]
        names = motion["mocap_names"].tolist()
    assert [model.body(name).mocapid[0] for name in names] == list(range(len(names)))
    return model, time, places, names


def test_a_box_stands_from_the_start(tmp_path):
    export(planned("slider"), tmp_path / "plan", "mujoco", pad=0.1)
    model, _, places, names = blocks_in(tmp_path / "plan")
    assert names == ["world-box"]
    np.testing.assert_allclose(places[:, 0, 2], 0.175, atol=1e-6)
    assert model.body("world-box").pos[2] == pytest.approx(0.175)
    assert model.key_mpos[:, 2] == pytest.approx(0.175)
    # The feet of the last keyframe stand on it.
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 3)
    mujoco.mj_forward(model, data)
    for foot in ("left", "right"):
        geom = f"foot-{foot}-0"
        lowest = data.geom(geom).xpos[2] - model.geom(geom).size[0]
        assert lowest == pytest.approx(0.35, abs=1e-4)


@pytest.mark.parametrize("case", ["anymal"], indirect=True)
def test_a_board_of_the_rollouts_own(case, tmp_path):
    tried = replace(
        case.rollout,
        scenario=Scenario(board=0.03),
        disturbance=Disturbance(trunk_mass_factor=1.1, friction=0.5, armature_factor=1.1),
    )
    export(tried, tmp_path / "out", "mujoco")
    model, _, places, names = blocks_in(tmp_path / "out")
    assert names == ["world-board"]
    assert places[-1, 0, 2] == pytest.approx(0.015)
    assert places[0, 0, 2] < -10
    trunk = case.robot.model.inertias[1].mass
    assert model.body_mass.sum() == pytest.approx(case.robot.mass + 0.1 * trunk, abs=1e-9)
    assert model.geom("foot-LF-0").friction[0] == 0.5
    assert model.dof_armature[6:].sum() == pytest.approx(1.1 * case.robot.armature.sum())


@pytest.mark.parametrize("case", ["anymal"], indirect=True)
def test_ideal_drives_have_no_rotors(case, tmp_path):
    export(replace(case.rollout, scenario=Scenario(drives="ideal")), tmp_path / "out", "mujoco")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "scene.xml"))
    for of_joints in (model.dof_armature, model.dof_frictionloss, model.dof_damping):
        assert not of_joints.any()
    drives = json.loads((tmp_path / "out" / "meta.json").read_text())["drives"]
    assert not any(drives["armature"])
    assert drives["delay"] == 0


def test_a_plan_whose_torques_are_not_known(anymal, tmp_path):
    unknown = replace(anymal, joint_torque=None, joint_torque_limit=None)
    export(unknown, tmp_path / "out", "mujoco")
    assert "ctrl" not in np.load(tmp_path / "out" / "motion.npz")
    assert "is not known" in (tmp_path / "out" / "README.txt").read_text()
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "scene.xml"))
    assert not model.key_ctrl.any()

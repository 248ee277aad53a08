"""A folder for MuJoCo: the robot in its surroundings as MJCF, and the motion in its coordinates.

`scene.xml`, for MuJoCo 3.3 or newer: the model that our simulation runs (inertias, feet, trunk,
ground, boxes, friction and solver options; of a rollout those that were drawn for it), light meshes
of the robot in `meshes/` (geom group 2; what collides is in group 3), motors that take torques in
Nm or N within the robot file's limits, and keyframes "start", "lift-off", "touchdown" and "end" as
far as they happened; of several flights also "lift-off-2", "touchdown-2" and so on. Joints have
their drives' rotors, Coulomb friction and damping as `armature`, `frictionloss` and `damping`; of a
rollout those that were drawn for it, of ideal drives none. Limits that fall with the speed, torque
delays and the controller are not in it. A rollout's lift-off is a flight's first control tick in
which no foot touches anything.

`motion.npz`: `time` (T,) s, `fps`, `qpos` (T, 7 + J): position, quaternion w, x, y, z without jumps
of sign, joints; `qvel` (T, 6 + J): linear velocity in the world's axes, angular velocity in the
base's, joints; `ctrl` (T, J) torques, if they are known; `joint_names` (J,): MuJoCo's depth-first
order, in qpos, qvel and ctrl alike; `mocap_pos` (T, B, 3) m and `mocap_names` (B,). Boxes and
boards are mocap bodies: where they stand for a while only, `mocap_pos` and the keyframes put them
there, and 100 m below the ground before and after; by itself the model has them as they are at the
end.

500 frames/s unless asked otherwise: one a default step of MuJoCo, a whole number of our
simulation's. At the robot's control rate (400 for ANYmal and Go2, 1000 for SLIDER) a rollout's
ticks come out as they are. `README.txt` has a program of ten lines that replays it. `meta.json`:
request, robot, solver. A plan that carries feedback gains, as `llsrbm plan --out` and `llsrbm
library export` make them, also has `controls.npz` and `replay.py`, which lets the robot do the
motion by torques and gains alone (`README.txt` says how).

Reading: such a folder, its zip, or any npz with `qpos`, and if there are `qvel`, `time` or `fps` or
`frequency`, `joint_names` (LocoMuJoCo's files too). Joints go by their names, or else are in
depth-first order. Without `qvel` velocities are differences over neighbouring frames, and impacts
are smeared over them. Only numbers are read: no MJCF, no pickles.
"""

import json
from pathlib import Path

import numpy as np

from llsrbm.arrays import Array
from llsrbm.files.atomic import MARK
from llsrbm.files.npz import write_archive
from llsrbm.formats.base import Format, Options, Purpose, driven_robot
from llsrbm.formats.mujoco.controls import REPLAY, write_controls
from llsrbm.formats.mujoco.motion import read_motion, recognises
from llsrbm.look.shown_motion import surroundings_of
from llsrbm.motion.flights import flights
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Disturbance, Rollout
from llsrbm.motion.surroundings import Surroundings
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion

SCENE, MOTION, README = "scene.xml", "motion.npz", "README.txt"
_SAME_INSTANT = 1e-9  # s
_ROOM = 0.5  # m around the base's way that a viewer shows at first

_README = """\
{title}: a {kind}, in MuJoCo's coordinates.

scene.xml    the model, with keyframes {keyframes}; meshes are in meshes/
motion.npz   time, qpos, qvel, joint_names, fps, mocap_pos{ctrl}
meta.json    what was asked, of which robot, and how it went

To look at the model (MuJoCo 3.3 or newer): python -m mujoco.viewer --mjcf=scene.xml
To replay the motion, in this folder (on macOS with mjpython in place of python):

    import time
    import mujoco, mujoco.viewer, numpy as np

    model = mujoco.MjModel.from_xml_path("scene.xml")
    data, motion = mujoco.MjData(model), dict(np.load("motion.npz"))
    with mujoco.viewer.launch_passive(model, data) as viewer:
        for k in range(len(motion["time"])):
            data.qpos[:], data.qvel[:] = motion["qpos"][k], motion["qvel"][k]
            data.mocap_pos[:] = motion["mocap_pos"][k]
            mujoco.mj_forward(model, data)
            viewer.sync()
            time.sleep(1 / float(motion["fps"]))

qpos: position, quaternion w x y z, joints. qvel: linear velocity in the world's axes, angular
velocity in the base's, joints. Joints and motors: in the order of joint_names. SI units, z up.
mocap_pos: where boxes and boards are. {torques}
The drives' rotors, friction and damping are the joints' armature, frictionloss and damping.
{played}"""

_PLAYED = """
To let the robot do it by the plan's torques and gains (controls.npz), in this folder:

    python replay.py 7

The seed, 7, draws what is disturbed: the trunk's mass (5 % either way), friction (0.6 to 0.9), how
soft contacts are (4 to 10 ms), and 0 to 2 ms by which torques come later than the drives' own
delay. It says "stands" if the base is within 50 mm and 5 deg of the plan half a second after its
end. Nothing knows which feet touch; torques have limits that do not fall with the speed.
"""

_TORQUES = {
    True: "ctrl: torques of the motors, Nm or N, with what turns their rotors.",
    False: "What torques the motors would give is not known.",
}


def _write(trajectory: Trajectory, path: Path, options: Options) -> None:
    # MuJoCo takes its time to import.
    from llsrbm.formats.mujoco.scene import exported_name, write_scene
    from llsrbm.simulation.scene import block_body, block_places, joints_in_model_order
    from llsrbm.simulation.world import steps_in

    motion = whole_body_motion(trajectory, options.fps, options.pad)
    robot = driven_robot(trajectory)
    around = surroundings_of(trajectory, robot)
    names = joints_in_model_order(robot)
    start, end = (float(trajectory.time[i]) for i in (0, -1))
    own_time = start + motion.time - np.ceil(options.pad * options.fps - 1e-9) / options.fps
    places = [block_places(around, float(t)) for t in np.clip(own_time, start, end)]
    keyframes = _keyframes(trajectory, around)
    tick = 1.0 / robot.file.control.rate
    timestep = tick / steps_in(tick)

    path.mkdir()
    drawn = trajectory.disturbance if isinstance(trajectory, Rollout) else Disturbance()
    write_scene(path / SCENE, robot, around, drawn, timestep, keyframes, _seen(motion))
    write_archive(
        path / MOTION,
        {
            "time": motion.time,
            "fps": np.float64(options.fps),
            **states_in_model_order(motion),
            "joint_names": np.array(names, dtype=np.str_),
            "mocap_pos": np.array(places),
            "mocap_names": np.array(
                [exported_name(block_body(block.name)) for block in around.blocks], dtype=np.str_
            ),
        },
    )
    if isinstance(trajectory, Plan) and trajectory.feedback_gain is not None:
        write_controls(path, trajectory, robot, around)
    _write_words(path, motion, trajectory, options, names, keyframes)


def _write_words(
    path: Path,
    motion: WholeBodyMotion,
    trajectory: Trajectory,
    options: Options,
    names: tuple[str, ...],
    keyframes: dict[str, dict[str, Array]],
) -> None:
    ctrl = motion.joint_torque
    (path / README).write_text(
        _README.format(
            title=motion.robot.file.title,
            kind=motion.origin,
            keyframes=", ".join(f'"{name}"' for name in keyframes),
            ctrl="" if ctrl is None else ", ctrl",
            torques=_TORQUES[ctrl is not None],
            played=_PLAYED if (path / REPLAY).exists() else "",
        ),
        encoding="utf-8",
    )
    meta = MUJOCO.described(
        trajectory,
        options,
        pad_s=options.pad,
        quaternion_order="wxyz",
        joint_order=list(names),
        keyframes={name: float(key["time"]) for name, key in keyframes.items()},
    )
    text = json.dumps(meta, indent=1, allow_nan=False)
    (path / MARK).write_text(text + "\n", encoding="utf-8")


def states_in_model_order(motion: WholeBodyMotion) -> dict[str, Array]:
    """`qpos`, `qvel` and, if they are known, torques `ctrl`, as in the exported model."""
    from llsrbm.simulation.scene import joints_in_model_order

    robot = motion.robot
    joints = np.array([robot.joint_names.index(name) for name in joints_in_model_order(robot)])
    states = {
        "qpos": motion.qpos[:, [*range(7), *(7 + joints)]],
        "qvel": motion.qvel[:, [*range(6), *(6 + joints)]],
    }
    if motion.joint_torque is not None:
        states["ctrl"] = motion.joint_torque[:, joints]
    return states


def _seen(motion: WholeBodyMotion) -> tuple[Array, float]:
    low, high = motion.base_position.min(axis=0), motion.base_position.max(axis=0)
    return (low + high) / 2, float(np.linalg.norm(high - low)) + 2 * _ROOM


def _keyframes(trajectory: Trajectory, around: Surroundings) -> dict[str, dict[str, Array]]:
    from llsrbm.simulation.scene import block_places

    # At a rate at which a plan's knots that count are there as events, and a rollout's ticks all.
    tick = float(trajectory.time[1] - trajectory.time[0])
    rate = 1.0 if isinstance(trajectory, Plan) else 1.0 / tick
    motion = whole_body_motion(trajectory, rate, events=True)
    states, start = states_in_model_order(motion), float(trajectory.time[0])
    found = {}
    for name, instant in _instants(trajectory).items():
        k = int(np.searchsorted(motion.time, instant - start + _SAME_INSTANT, side="right")) - 1
        time = start + float(motion.time[k])
        state = {key: values[k] for key, values in states.items()}
        found[name] = {"time": np.array(time), **state, "mpos": block_places(around, time)}
    return found


def _instants(trajectory: Trajectory) -> dict[str, float]:
    """When what a keyframe is called after happens, s; a rollout's touchdown within its tick."""
    if isinstance(trajectory, Plan):
        starts = trajectory.phase_start.tolist()
        flown = [(starts[phase], starts[phase + 1]) for phase in trajectory.schedule.flights]
    else:
        flown = [(flight.lift_off, flight.touchdown) for flight in flights(trajectory)]
    found = {"start": float(trajectory.time[0])}
    for number, instants in enumerate(flown, start=1):
        suffix = "" if number == 1 else f"-{number}"
        for name, instant in zip(("lift-off", "touchdown"), instants, strict=True):
            if instant is not None:
                found[name + suffix] = instant
    return found | {"end": float(trajectory.time[-1])}


MUJOCO = Format(
    name="mujoco",
    title="a folder for MuJoCo: the scene as MJCF with meshes, keyframes, and qpos, qvel, torques",
    purpose=Purpose.SIMULATION,
    suffix="",
    write=_write,
    conventions=__doc__,
    options=("fps", "pad"),
    defaults=Options(fps=500.0),
    read=read_motion,
    recognises=recognises,
)

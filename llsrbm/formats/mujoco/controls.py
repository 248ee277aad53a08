"""A plan's torques and feedback for MuJoCo, and a script that replays it by them alone.

`controls.npz`, of plans that carry feedback gains: at 1 kHz `time` (K,) s, `qpos`, `qvel`, `ctrl`
and `mocap_pos` as in `motion.npz`; `interval` (K,): which of the gains `gain` (N + 1, J, 12 + 2 J)
counts then, the last from the plan's end on; `delay`, s, of the robot's drives. A motor's torque is
its `ctrl` less its row of the gain times the state's error, in axes of the base as
`llsrbm.with_feedback` says, joints in MuJoCo's order. `replay.py` does so without this package,
with trunk, friction, contacts and delay disturbed by a seed, and says whether the robot stands.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from llsrbm.files.npz import write_archive
from llsrbm.motion.plan import Plan
from llsrbm.motion.surroundings import Surroundings
from llsrbm.motion.whole_body import motion_at
from llsrbm.planning.whole_body.feedback import in_order
from llsrbm.robots.robot import Robot

CONTROLS, REPLAY = "controls.npz", "replay.py"
RATE = 1000.0  # Hz
_SAME_INSTANT = 1e-9  # s

SCRIPT = '''\
"""Replays the plan by its torques and gains in MuJoCo, disturbed: python replay.py [SEED]."""
import sys
from collections import deque

import mujoco
import numpy as np

draw = np.random.default_rng(int(sys.argv[1]) if len(sys.argv) > 1 else 0).uniform
model = mujoco.MjModel.from_xml_path("scene.xml")
plan = {name: values.astype(float) for name, values in np.load("controls.npz").items()}
trunk, mass = model.jnt_bodyid[0], draw(0.95, 1.05)  # of the trunk, a factor
model.body_mass[trunk] *= mass
model.body_inertia[trunk] *= mass
model.geom_friction[:, 0] = model.pair_friction[:, :2] = draw(0.6, 0.9)
model.geom_solref[:, 0] = model.pair_solref[:, 0] = draw(0.004, 0.01)  # s, of contacts
late = round((float(plan["delay"]) + draw(0.0, 0.002)) / model.opt.timestep)  # steps, of torques
data = mujoco.MjData(model)
mujoco.mj_setConst(model, data)
data.qpos[:], data.qvel[:] = plan["qpos"][0], plan["qvel"][0]
off, sent, now, then = np.zeros(model.nv), deque(maxlen=1 + late), np.zeros(9), np.zeros(9)
for step in range(round((plan["time"][-1] + 0.5) / model.opt.timestep)):
    time = step * model.opt.timestep + 1e-9
    k = np.searchsorted(plan["time"], time, side="right") - 1
    q, v = plan["qpos"][k], plan["qvel"][k]
    mujoco.mj_differentiatePos(model, off, 1, q, data.qpos)
    mujoco.mju_quat2Mat(now, data.qpos[3:7])
    mujoco.mju_quat2Mat(then, q[3:7])
    off[:3] = off[:3] @ then.reshape(3, 3)  # from the world's axes into the base's
    fast = data.qvel - v
    fast[:3] = data.qvel[:3] @ now.reshape(3, 3) - v[:3] @ then.reshape(3, 3)
    sent.append(plan["ctrl"][k] - plan["gain"][int(plan["interval"][k])] @ [*off, *fast])
    data.ctrl[:], data.mocap_pos[:] = sent[0], plan["mocap_pos"][k]
    mujoco.mj_step(model, data)
far, turned = np.linalg.norm(off[:3]), np.degrees(np.linalg.norm(off[3:6]))
stands = bool(far < 0.05 and turned < 5.0)
print(f"{'stands' if stands else 'fell'}: {1e3 * far:.0f} mm and {turned:.1f} deg off at the end")
sys.exit(not stands)
'''


def write_controls(path: Path, plan: Plan, robot: Robot, surroundings: Surroundings) -> None:
    """Write both files into the folder `path` of a plan that carries its gains."""
    # MuJoCo takes its time to import.
    from llsrbm.formats.mujoco.folder import states_in_model_order
    from llsrbm.simulation.scene import block_places, joints_in_model_order

    assert plan.feedback_gain is not None
    time = np.append(np.arange(0.0, plan.duration - _SAME_INSTANT, 1.0 / RATE), plan.duration)
    motion = motion_at(plan, time)
    interval = np.searchsorted(plan.time, time + _SAME_INSTANT, side="right") - 1
    gain = in_order(plan.feedback_gain, plan.joint_names, joints_in_model_order(robot))
    states = states_in_model_order(motion)
    write_archive(
        path / CONTROLS,
        {
            "time": time,
            **{name: values.astype(np.float32) for name, values in states.items()},
            "mocap_pos": np.array([block_places(surroundings, float(t)) for t in time]),
            "interval": interval,
            "gain": gain.astype(np.float32),
            "delay": np.float64(robot.drive_delay),
        },
    )
    (path / REPLAY).write_text(SCRIPT, encoding="utf-8")

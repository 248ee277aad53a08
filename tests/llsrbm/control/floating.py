"""A weightless robot in MuJoCo without stops and contacts, drawn to a posture by the program."""

import mujoco
import numpy as np

from llsrbm.control import tasks
from llsrbm.control.inverse_dynamics import InverseDynamics
from llsrbm.control.joint_bounds import JointBounds
from llsrbm.control.link_bounds import LinkBounds
from llsrbm.control.whole_body import WholeBody
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots import load_robot
from llsrbm.robots.drives.torques import friction_torque, torque_range
from llsrbm.simulation.scene import scene_spec
from tests.llsrbm.control.bodies import resting_target

STEP = 5e-4


def floating(name, position, speed, *, bounded=True, apart=False, seconds=0.3, gains=(400, 40)):
    """Joints (T, J), their speeds (T, J): weightless, drawn to a posture with a speed."""
    robot = load_robot(name)
    spec = scene_spec(robot, Surroundings(-100.0, ()), Disturbance(), STEP)
    spec.option.gravity = np.zeros(3)
    for joint in spec.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    # Links that meet would stop joints as well.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model = spec.compile()
    data = mujoco.MjData(model)
    joints = [model.joint(joint) for joint in robot.joint_names]
    at = [joint.qposadr[0] for joint in joints]
    rate = [joint.dofadr[0] for joint in joints]
    data.qpos[at] = robot.posture[7:]
    data.qpos[3] = 1.0
    body, tick = WholeBody(robot), 1 / robot.file.control.rate
    dynamics = InverseDynamics(body, 0.5, "quadprog", tick)
    bounds, links = JointBounds(robot), LinkBounds(robot)
    target = resting_target(len(robot.legs), len(at))
    target.joint_position[:], target.joint_velocity[:] = position, speed
    posture = [(tasks.Posture(range(len(at)), len(at) + 6, gains), 1.0)]
    forces = np.zeros((body.contacts, 3))
    positions, speeds = [], []
    for _ in range(round(seconds / tick)):
        q = np.concatenate([data.qpos[:3], data.qpos[[4, 5, 6, 3]], data.qpos[at]])
        R = np.zeros(9)
        mujoco.mju_quat2Mat(R, data.qpos[3:7])
        v = np.concatenate([R.reshape(3, 3).T @ data.qvel[:3], data.qvel[3:6], data.qvel[rate]])
        body.update(q, v)
        body.h -= body.M[:, :3] @ R.reshape(3, 3).T @ [0, 0, 9.81]  # weightless
        command = dynamics.solve(
            posture,
            target,
            np.zeros(body.contacts, dtype=bool),
            forces,
            1.0,
            torque_range(robot, v[6:]),
            bounds.accelerations(body) if bounded else None,
            links.rows(body) if apart else None,
            friction_torque(robot, v[6:]),
        )
        assert command.solved
        data.ctrl[:] = command.torque
        for _ in range(round(tick / STEP)):
            mujoco.mj_step(model, data)
            positions.append(data.qpos[at].copy())
            speeds.append(data.qvel[rate].copy())
    return np.array(positions), np.array(speeds)

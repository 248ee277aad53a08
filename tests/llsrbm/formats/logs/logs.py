"""Motions of real robots for the tests of logs, and what Pinocchio says about them."""

from dataclasses import replace
from functools import cache

import pinocchio as pin

import llsrbm
from llsrbm.formats import export
from llsrbm.motion.plan import Plan
from llsrbm.motion.realised import realised
from llsrbm.motion.sampling import resample
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned

ROBOTS = ("anymal", "slider")
BOARD = 0.03  # m
HEAVIER = 0.1  # share of the trunk's mass


@cache
def rollout():
    """A twist of Go2 onto a board, with a trunk that is heavier than believed."""
    plan = planned("go2")
    simulated = llsrbm.simulate(plan, board=BOARD, trunk_mass=HEAVIER)
    return replace(simulated, plan=plan)


def sampled(trajectory, times):
    """Base, joints by name, and the trajectory itself at instants."""
    if isinstance(trajectory, Plan):
        at = realised(trajectory, load_robot(trajectory.jump.robot), times)
    else:
        at = resample(trajectory, times)
    return at, dict(zip(at.joint_names, at.joint_position.T, strict=True))


def body_frames(name):
    model = load_robot(name).model
    return {f.name: i for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}


def link_poses(name, at, joints, k):
    """Link -> pin.SE3 in the world, at row k."""
    model = load_robot(name).model
    data = model.createData()
    q = pin.neutral(model)
    q[:3] = at.base_position[k]
    q[3:7] = at.base_quat[k, [1, 2, 3, 0]]
    for joint, positions in joints.items():
        q[model.joints[model.getJointId(joint)].idx_q] = positions[k]
    pin.framesForwardKinematics(model, data, q)
    return {link: data.oMf[i] for link, i in body_frames(name).items()}


def written(trajectory, folder, format_):
    """The file of an export, which is alone in its folder and not large."""
    path = folder / f"x.{format_}"
    export(trajectory, path, format=format_)
    assert list(folder.iterdir()) == [path]
    assert path.stat().st_size < 10e6
    return path

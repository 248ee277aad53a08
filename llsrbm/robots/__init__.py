"""Robots as data: one TOML file a robot, everything else computed from its URDF."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.request.messages import check_kind, look_up
from llsrbm.robots.arms import built_arms
from llsrbm.robots.description import changed, read_description
from llsrbm.robots.feet import check_soles, foot_lift
from llsrbm.robots.leg_fit import load_or_fit
from llsrbm.robots.legs import LegChains, solve_legs
from llsrbm.robots.robot import Leg, Robot
from llsrbm.robots.schema import RobotFile, read_robot_file, robot_files
from llsrbm.robots.urdf import (
    BASE_JOINT,
    check_drives,
    check_joints,
    check_limits,
    check_moving,
    check_posture,
    find_urdf,
    frame_id,
    joint_chain,
    pinocchio_model,
)

__all__ = ["Leg", "Robot", "RobotFile", "build_robot", "load_robot", "names", "read_robot_file"]

_SYMMETRIC_HIPS = 5e-3  # m; hips that agree this well are taken as exact mirror images.
_CORNERS: Array = np.array(
    [[0, 0, 0], *[[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (0, 1)]]
)
_KEPT = 16  # robots at most; those that were built first are forgotten first
_Stamp = tuple[tuple[int, int, int], ...]
_kept: dict[str, tuple[_Stamp, Robot]] = {}


def names() -> tuple[str, ...]:
    """Names of the robots that come with the project."""
    return tuple(robot_files())


def load_robot(name_or_path: str) -> Robot:
    """The robot of that name, or of the robot file at that path.

    What ends in ".toml" or contains a path separator is a path. The same object every time, until
    its robot file or its URDF changes on disk: then both are read again.

    Raises:
        InputError: no such name.
        RobotFileError: the file is wrong.
    """
    path = _path(name_or_path)
    key = str(path.absolute())
    kept = _kept.get(key)
    if kept is not None and _stamp(path, kept[1].urdf_path) == kept[0]:
        return kept[1]
    # Taken before the file is read: a change meanwhile is then noticed the next time.
    stamp = _stamp(path)
    robot = build_robot(path)
    _kept.pop(key, None)
    _kept[key] = (stamp + _stamp(robot.urdf_path), robot)
    for oldest in list(_kept)[:-_KEPT]:
        _kept.pop(oldest, None)
    return robot


def _path(name_or_path: str) -> Path:
    check_kind("robot", name_or_path, str, "a name or a path as text")
    if "\0" in name_or_path:
        raise InputError("robot: expected a name or a path, got one with a null character")
    if name_or_path.endswith(".toml") or os.sep in name_or_path:
        return Path(name_or_path)
    return look_up("robot", name_or_path, robot_files(), "or the path of a robot file (.toml)")


def _stamp(*paths: Path) -> _Stamp:
    return tuple(_state(path) for path in paths)


def _state(path: Path) -> tuple[int, int, int]:
    try:
        status = path.stat()
    except OSError:
        return 0, 0, 0
    return status.st_mtime_ns, status.st_size, status.st_ino


def build_robot(path: str | Path) -> Robot:
    """Read a robot file and compute everything from its URDF.

    Raises:
        RobotFileError: the file is wrong in itself, names what its URDF does not have, or its
            default posture does not stand on its soles; or point feet have no radius.
    """
    path = Path(path).resolve()
    file = read_robot_file(path)
    urdf_path = find_urdf(file, path)
    where = f"{path}: urdf: {urdf_path}"
    source = read_description(urdf_path, where)
    feet = {name: spec.foot for name, spec in file.legs.items()}
    urdf = changed(source, file.urdf, feet, str(path))
    model = pinocchio_model(urdf, where)
    check_moving(urdf, model, where)
    limbs = (*file.legs, *file.arms)
    joint_ids = {name: joint_chain(model, file, path, name) for name in limbs}
    check_joints(model, file, path, joint_ids)
    arms = built_arms(file, model, joint_ids)
    rest = pin.neutral(model)
    for arm in arms:
        rest[arm.q_index] = file.posture[arm.name]
    chains = LegChains(
        model,
        np.array([joint_ids[name] for name in file.legs]),
        tuple(frame_id(model, spec.foot) for spec in file.legs.values()),
        rest,
    )
    posture, data = _standing(chains, np.concatenate([file.posture[n] for n in file.legs]))
    legs = _legs(file, chains)
    robot = Robot(
        file=file,
        path=path,
        urdf_path=urdf_path,
        urdf_source=source,
        urdf=urdf,
        model=model,
        chains=chains,
        legs=legs,
        arms=arms,
        joint_names=tuple(model.names[BASE_JOINT + 1 :]),
        posture=posture,
        mass=float(data.Ig.mass),
        com=data.com[0].copy(),
        inertia=data.Ig.inertia.copy(),
        feet=np.array([data.oMf[f].translation for f in chains.foot_ids]),
        base_position=posture[:3].copy(),
        load_fit=load_or_fit,
    )
    check_posture(robot)
    check_limits(robot, where)
    check_drives(robot)
    model.armature[BASE_JOINT + 5 :] = robot.armature
    if robot.foot_coordinates > 3:
        check_soles(robot)
        return robot
    return _on_balls(robot)


def _on_balls(robot: Robot) -> Robot:
    """A robot whose point feet have their frames on the ground, raised onto their balls."""
    lift = foot_lift(robot)
    up = np.array([0.0, 0.0, lift])
    posture = robot.posture.copy()
    posture[:3] += up
    return replace(
        robot,
        posture=posture,
        com=robot.com + up,
        base_position=robot.base_position + up,
        foot_lift=lift,
    )


def _standing(chains: LegChains, angles: Array) -> tuple[Array, pin.Data]:
    """Default posture (nq,), the lowest foot's frame on the ground; and Pinocchio's data there.

    The CoM is above the origin.
    """
    model, data = chains.model, chains.model.createData()
    posture = pin.neutral(model) if chains.rest is None else chains.rest.copy()
    posture[[model.joints[j].idx_q for j in chains.joint_ids.ravel().tolist()]] = angles
    pin.forwardKinematics(model, data, posture)
    pin.updateFramePlacements(model, data)
    lowest = min(data.oMf[f].translation[2] for f in chains.foot_ids)
    com = pin.centerOfMass(model, data, posture)
    posture[:3] = -com[0], -com[1], -lowest
    pin.ccrba(model, data, posture, np.zeros(model.nv))
    pin.updateFramePlacements(model, data)
    return posture, data


def _legs(file: RobotFile, chains: LegChains) -> tuple[Leg, ...]:
    model, neutral = chains.model, chains.model.createData()
    pin.forwardKinematics(model, neutral, pin.neutral(model))
    hip_ids = [model.getJointId(spec.hip) for spec in file.legs.values()]
    hips = _symmetrised(np.array([neutral.oMi[j].translation for j in hip_ids]))
    mirrors = _mirrors(chains, hips, np.array([file.posture[name] for name in file.legs]))
    return tuple(
        Leg(
            name=name,
            foot_frame=spec.foot,
            foot_frame_id=chains.foot_ids[i],
            joints=tuple(model.names[j] for j in joints),
            joint_ids=tuple(joints),
            q_index=np.array([model.joints[j].idx_q for j in joints]),
            v_index=np.array([model.joints[j].idx_v for j in joints]),
            hip=hips[i],
            mirror=mirrors[i],
        )
        for i, ((name, spec), joints) in enumerate(
            zip(file.legs.items(), chains.joint_ids.tolist(), strict=True)
        )
    )


def _symmetrised(hips: Array) -> Array:
    """Hips as exact mirror images of one another, if the URDF's are so within rounding."""
    size = np.abs(hips)
    if np.ptp(size[:, :2], axis=0).max() > _SYMMETRIC_HIPS or np.ptp(hips[:, 2]) > _SYMMETRIC_HIPS:
        return hips
    mean = np.append(size[:, :2].mean(axis=0), hips[:, 2].mean())
    sign = np.column_stack([np.sign(hips[:, :2]), np.ones(len(hips))])
    return np.where(sign == 0, hips, sign * mean)


def _mirrors(chains: LegChains, hips: Array, angles: Array) -> Array:
    """(L, 3): the reflection that maps each leg onto the first, seen from its hip.

    Left and right legs mirror each other in y. A hind leg mirrors a front leg in x only if it
    bends the other way (ANYmal's knees point at each other, Go2's all point backward), which its
    CoM tells when feet are put at mirrored places.
    """
    side = np.where(hips[:, 1] < 0, -1.0, 1.0)
    end = np.where(hips[:, 0] * hips[0, 0] < 0, -1.0, 1.0)
    if (end > 0).all():
        return np.column_stack([np.ones(len(hips)), side, np.ones(len(hips))])
    standing = chains.motion(angles).foot - hips
    offsets = 0.12 * np.linalg.norm(standing[0]) * _CORNERS
    front = 1.0 if hips[0, 0] > 0 else -1.0

    def com_map(sign: Array) -> tuple[Array, Array]:
        """CoM (S, L, 3) in the mirrored hip frame, feet where the first leg has them, and error."""
        mirror = np.column_stack([sign, side, np.ones(len(hips))])
        target = mirror * (mirror[0] * standing[0] + offsets[:, None, :]) + hips
        q, error = solve_legs(chains, target, angles)
        return mirror * (chains.masses(q).com - hips), error

    mirrored, mirrored_error = com_map(front * end)
    same, same_error = com_map(np.full(len(hips), front))
    sign = []
    for leg in range(len(hips)):
        reference = mirrored[:, 0]
        as_mirrored = np.abs(mirrored[:, leg] - reference).max() + mirrored_error[:, leg].max()
        as_same = np.abs(same[:, leg] - same[:, 0]).max() + same_error[:, leg].max()
        sign.append(front * end[leg] if as_mirrored <= as_same else front)
    return np.column_stack([sign, side, np.ones(len(hips))])

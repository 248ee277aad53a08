"""Plans checked from outside: by files that anybody has, not by the project's own certificate.

    python -m benchmarks.outside --robots anymal,go2 --requests 60 --seed 8800

Requests are those of `benchmarks.range`. Two exports of each plan at 1 kHz are read: MuJoCo's
folder (states, and where boxes are) and the table (contact forces and points). Pinocchio reads the
plain URDF, coal takes its collision geometry as convex hulls. Nothing of `llsrbm.certificate` is
used: accelerations are differences of the exported velocities over 2 ms, and next to a plan's
knots, where they jump, torques are not looked at. Links that belong to neighbouring joints, or
touch as the robot stands, cannot be told apart and are left out. Printed are the checks that do not
hold, and how many plans hold here and by their certificates.
"""

import csv
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from typing import Any

import coal
import mujoco
import numpy as np
import pinocchio as pin
import typer

import llsrbm
from benchmarks.range import COMPONENTS, requests
from llsrbm.robots import load_robot

RATE = 1000  # Hz
SHARE = 1.01  # of a limit
STOP = 0.01  # of the range between the stops
APART, TOUCHING = 0.005, -0.005  # m
BESIDE = 1.2e-3  # s from a knot
WHOLE = 0.7  # of the largest speed, up to which a drive has its whole torque
ROUNDING = 1e-4  # m
SLIGHT, MISSING = 5e-3, 0.1  # of the weight
ARM = 0.2  # m at which a missing moment counts as a force
DEEP = 2.0  # m that a box in the ground's place has


@dataclass(frozen=True)
class Outside:
    """A robot by its plain URDF; joints in the model's order, whose names these are."""

    model: pin.Model
    shapes: pin.GeometryModel
    joints: tuple[str, ...]
    drives: dict[str, np.ndarray]
    friction: float


@lru_cache
def outside(name: str) -> Outside:
    """Read a robot's URDF by Pinocchio, and the numbers of its file."""
    robot = load_robot(name)
    urdf, held = str(robot.urdf_path), robot.file.urdf.held
    packages = [str(parent) for parent in Path(urdf).parents]
    whole = pin.buildModelFromUrdf(urdf, pin.JointModelFreeFlyer())
    shapes = pin.buildGeomFromUrdf(whole, urdf, pin.GeometryType.COLLISION, package_dirs=packages)
    posture = pin.neutral(whole)
    for joint, angle in held.items():
        posture[whole.joints[whole.getJointId(joint)].idx_q] = angle
    fixed = [i for i, n in enumerate(whole.names) if i > 1 and n not in robot.joint_names]
    model = whole
    if fixed:
        model, shapes = pin.buildReducedModel(whole, shapes, fixed, posture)
    for shape in shapes.geometryObjects:
        if isinstance(shape.geometry, coal.BVHModelBase):
            shape.geometry.buildConvexRepresentation(False)
            shape.geometry = shape.geometry.convex
    joints = tuple(model.names[2:])
    order = [robot.joint_names.index(joint) for joint in joints]
    names = ("armature", "friction", "damping", "torque_limit", "speed_limit")
    drives = {n: np.broadcast_to(getattr(robot, n), len(order))[order] for n in names}
    return Outside(model, shapes, joints, drives, robot.file.limits.friction)


@dataclass(frozen=True)
class Motion:
    """The exports of a plan: K instants."""

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    inner: np.ndarray  # which instants are away from the knots
    points: np.ndarray  # (K, C, 3)
    forces: np.ndarray
    boxes: list[tuple[coal.CollisionGeometry, np.ndarray]]  # with (K, 3) m of their centres


def exported(plan: llsrbm.Plan, robot: Outside) -> Motion:
    """Write both exports, and read them."""
    with tempfile.TemporaryDirectory() as folder:
        at = Path(folder)
        llsrbm.export(plan, at / "scene", format="mujoco", fps=RATE)
        llsrbm.export(plan, at / "table.csv", format="csv", fps=RATE)
        scene = mujoco.MjModel.from_xml_path(str(at / "scene" / "scene.xml"))
        moving = dict(np.load(at / "scene" / "motion.npz"))
        with (at / "table.csv").open() as file:
            head, *rows = csv.reader(file)
    table = np.array(rows, dtype=np.float64)
    time = moving["time"]
    # The table has rows at events as well: of each instant the last row that is not later.
    row = np.searchsorted(table[:, 0], time + 1e-9, side="right") - 1
    columns = {
        n: [i for i, h in enumerate(head) if h.startswith(n)]
        for n in ("contact_point/", "contact_force/")
    }
    points, forces = (table[row][:, c].reshape(len(time), -1, 3) for c in columns.values())
    names = moving["joint_names"].tolist()
    order = [names.index(joint) for joint in robot.joints]
    qpos, qvel = moving["qpos"], moving["qvel"]
    q = np.hstack([qpos[:, :3], qpos[:, 4:7], qpos[:, 3:4], qpos[:, 7:][:, order]])
    turn = [pin.Quaternion(x[6], x[3], x[4], x[5]).matrix() for x in q]
    linear = np.einsum("kji,kj->ki", turn, qvel[:, :3])
    v = np.hstack([linear, qvel[:, 3:6], qvel[:, 6:][:, order]])
    knots = plan.time - plan.time[0]
    inner = (np.abs(time[:, None] - knots) > BESIDE).all(axis=1)
    inner[[0, -1]] = False
    return Motion(q, v, np.gradient(v, time, axis=0), inner, points, forces, _boxes(scene, moving))


def _boxes(scene: mujoco.MjModel, moving: dict[str, Any]) -> list[tuple[Any, np.ndarray]]:
    plane = int(np.flatnonzero(scene.geom_type == mujoco.mjtGeom.mjGEOM_PLANE)[0])
    middle = scene.geom_pos[plane] - [0.0, 0.0, DEEP / 2]
    found = [(coal.Box(20.0, 20.0, DEEP), np.tile(middle, (len(moving["time"]), 1)))]
    for i, name in enumerate(moving["mocap_names"].tolist()):
        body = scene.body(name)
        geom = scene.geom(int(body.geomadr[0]))
        found.append((coal.Box(*(2 * geom.size)), moving["mocap_pos"][:, i]))
    return found


def findings(motion: Motion, robot: Outside) -> Iterator[tuple[str, float, bool]]:
    """Each check: its name, its worst value, and whether it holds."""
    model, drives = robot.model, robot.drives
    lower, upper = model.lowerPositionLimit[7:], model.upperPositionLimit[7:]
    q = motion.q[:, 7:]
    beyond = np.max(np.maximum(lower - q, q - upper) / (upper - lower))
    yield "stops", beyond, beyond <= STOP
    share = np.abs(motion.v[:, 6:]) / drives["speed_limit"]
    yield "speed", share.max(), share.max() <= SHARE
    data, weight = model.createData(), pin.computeTotalMass(model) * 9.81
    effort = np.array(
        [_effort(model, data, motion, k, robot) for k in np.flatnonzero(motion.inner)]
    )
    force, moment = (np.linalg.norm(part, axis=1).max() for part in np.split(effort[:, :6], 2, 1))
    base = max(force, moment / ARM) / weight
    yield "dynamics", base, base <= MISSING
    torque, fast = np.abs(effort[:, 6:]) / drives["torque_limit"], share[motion.inner]
    yield "torque", torque.max(), torque.max() <= SHARE
    driving = effort[:, 6:] * motion.v[motion.inner, 6:] > 0
    region = np.where(driving, (1 - WHOLE) * torque + fast, torque).max()
    yield "torque at speed", region, region <= SHARE
    normal, across = motion.forces[..., 2], np.linalg.norm(motion.forces[..., :2], axis=-1)
    firm = np.linalg.norm(motion.forces, axis=-1) > SLIGHT * weight
    slip = np.where(firm, across / np.maximum(normal, 1e-9), 0.0).max() / robot.friction
    yield "friction", slip, slip <= SHARE
    yield from _distances(motion, robot)


def _effort(model: Any, data: Any, motion: Motion, k: int, robot: Outside) -> np.ndarray:
    """(nv,) what is left to the base and the drives: with rotors and friction."""
    q, v, a = motion.q[k], motion.v[k], motion.a[k]
    pin.computeJointJacobians(model, data, q)
    effort = pin.rnea(model, data, q, v, a)
    for leg, (point, force) in enumerate(zip(motion.points[k], motion.forces[k], strict=True)):
        if force.any():
            joint = _carrier(robot, leg, motion)
            J = pin.getJointJacobian(model, data, joint, pin.LOCAL_WORLD_ALIGNED)
            arm = point - data.oMi[joint].translation
            effort -= J[:3].T @ force + J[3:].T @ np.cross(arm, force)
    drives = robot.drives
    effort[6:] += drives["armature"] * a[6:] + drives["damping"] * v[6:]
    effort[6:] += drives["friction"] * np.tanh(v[6:] / 0.1)
    return effort


def _carrier(robot: Outside, contact: int, motion: Motion) -> int:
    """The joint of the link by which a contact touches: the one that is nearest at the start."""
    return _carriers(robot.model, tuple(map(tuple, motion.points[0])), tuple(motion.q[0]))[contact]


@lru_cache(maxsize=4)
def _carriers(model: Any, points: tuple[Any, ...], q: tuple[float, ...]) -> list[int]:
    data = model.createData()
    pin.forwardKinematics(model, data, np.array(q))
    ends = [j for j in range(2, model.njoints) if not len(model.children[j])]
    ends = ends or list(range(2, model.njoints))
    low = {j: data.oMi[j].translation for j in ends}
    return [min(ends, key=lambda j: np.linalg.norm(low[j] - point)) for point in points]


def _distances(motion: Motion, robot: Outside) -> Iterator[tuple[str, float, bool]]:
    """Least distances between links, and from all but standing feet to the ground and boxes."""
    model, shapes = robot.model, robot.shapes
    data, placed = model.createData(), shapes.createData()
    objects = shapes.geometryObjects
    feet: dict[int, list[int]] = {}
    for c in range(motion.points.shape[1]):
        feet.setdefault(_carrier(robot, c, motion), []).append(c)

    def apart(i: int, j: int) -> float:
        return _apart(objects[i].geometry, placed.oMg[i], objects[j].geometry, placed.oMg[j])

    pin.updateGeometryPlacements(model, data, shapes, placed, motion.q[0])
    candidates = [
        (i, j)
        for i, j in combinations(range(len(objects)), 2)
        if not _neighbours(model, objects[i].parentJoint, objects[j].parentJoint)
    ]
    link = [each.parentFrame for each in objects]
    settled = {frozenset((link[i], link[j])) for i, j in candidates if apart(i, j) < APART}
    pairs = [(i, j) for i, j in candidates if frozenset((link[i], link[j])) not in settled]
    own, around = (np.inf, "", ""), (np.inf, "", "")
    for k in range(0, len(motion.q), 5):
        pin.updateGeometryPlacements(model, data, shapes, placed, motion.q[k])
        own = min(own, *((apart(i, j), objects[i].name, objects[j].name) for i, j in pairs))
        for i, each in enumerate(objects):
            standing = any(motion.forces[k, c].any() for c in feet.get(each.parentJoint, ()))
            if standing:
                continue
            for box, centre in motion.boxes:
                there = pin.SE3(np.eye(3), centre[k])
                near = _apart(each.geometry, placed.oMg[i], box, there)
                around = min(around, (near, each.name, "ground or box"))
    yield f"self-distance {own[1]} {own[2]}", own[0], own[0] >= APART - ROUNDING
    yield f"clearance {around[1]}", around[0], around[0] >= TOUCHING - ROUNDING


def _neighbours(model: Any, a: int, b: int) -> bool:
    return a == b or model.parents[a] == b or model.parents[b] == a


def _apart(a: Any, at_a: pin.SE3, b: Any, at_b: pin.SE3) -> float:
    here, there = (coal.Transform3s(M.rotation, M.translation) for M in (at_a, at_b))
    return float(coal.distance(a, here, b, there, coal.DistanceRequest(), coal.DistanceResult()))


def main(
    robots: str = "anymal,go2", count: int = typer.Option(60, "--requests"), seed: int = 8800
) -> None:
    """Print what does not hold, and how many plans do."""
    for name in robots.split(","):
        held = certified = planned = 0
        for number, request in enumerate(requests(name, count, seed)):
            motion = {n: request[n] for n in COMPONENTS if n in request}
            try:
                plan = llsrbm.plan(llsrbm.Jump(robot=name, **motion), explains=False, patient=False)
            except llsrbm.NotConverged:
                continue
            found = list(findings(exported(plan, outside(name)), outside(name)))
            planned, certified = planned + 1, certified + plan.certified
            held += all(holds for *_, holds in found)
            for check, worst, holds in found:
                if not holds:
                    print(f"{name} {number} {motion}: {check} {worst:.3f}", flush=True)
        print(f"{name}: {count} asked, {planned} planned, {certified} certified, {held} hold here")


if __name__ == "__main__":
    typer.run(main)

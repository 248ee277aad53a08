"""The bodies of a robot: in which order tools have them, where they are and how they move.

A body is a link that a joint moves, with all that is welded to it; the first is the root link. It
is called as the URDF calls the link, and its frame is the link's. Bodies and joints are those of
the robot's own URDF: joints that its file holds stand among them where they are held.
"""

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.mechanics import quaternions, rotation_matrices, sign_continuous
from llsrbm.motion.whole_body import WholeBodyMotion, pinocchio_states
from llsrbm.robots import Robot
from llsrbm.robots.urdf import BASE_JOINT, pinocchio_model


@dataclass(frozen=True)
class JointOrder:
    """The n joints of a robot's own URDF in some order.

    Attributes:
        joints: their names.
        index: where each is among `Robot.joint_names`; -1: the robot's file holds it.
        held: rad or m at which it is held; 0 of those that move.
        units: "rad", or "m" of those that slide.
    """

    joints: tuple[str, ...]
    index: tuple[int, ...]
    held: tuple[float, ...]
    units: tuple[str, ...]

    def position(self, motion: WholeBodyMotion) -> Array:
        """(K, n) rad or m."""
        return self._filled(motion.joint_position, self.held)

    def velocity(self, motion: WholeBodyMotion) -> Array:
        """(K, n) rad/s or m/s."""
        return self._filled(motion.joint_velocity, (0.0,) * len(self.joints))

    def _filled(self, moved: Array, held: tuple[float, ...]) -> Array:
        index = np.array(self.index)
        return np.where(index < 0, held, moved[:, index])


@dataclass(frozen=True)
class BodyOrder(JointOrder):
    """The joints with the names of the 1 + n bodies: the root link, then what each joint moves."""

    bodies: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """B = 1 + n bodies at K instants; world frame.

    Attributes:
        position: (K, B, 3) m of the links' origins; quat: (K, B, 4) w, x, y, z, no jumps of sign.
        velocity: (K, B, 3) m/s of the links' origins; com_velocity: of the bodies' CoMs.
        angular_velocity: (K, B, 3) rad/s.
    """

    order: BodyOrder
    position: Array
    quat: Array
    velocity: Array
    com_velocity: Array
    angular_velocity: Array


@lru_cache(maxsize=32)
def urdf_joints(robot: Robot) -> JointOrder:
    """In Pinocchio's order; where the robot's file holds none they are `Robot.joint_names`."""
    return _joint_order(robot, tuple(_own_model(robot).names[BASE_JOINT + 1 :]))


def _joint_order(robot: Robot, joints: tuple[str, ...]) -> JointOrder:
    model, held = _own_model(robot), robot.file.urdf.held
    kinds = [model.joints[model.getJointId(joint)].shortname() for joint in joints]
    return JointOrder(
        joints=joints,
        index=tuple(-1 if j in held else robot.joint_names.index(j) for j in joints),
        held=tuple(held.get(joint, 0.0) for joint in joints),
        units=tuple("m" if kind.startswith("JointModelP") else "rad" for kind in kinds),
    )


@lru_cache(maxsize=32)
def _own_model(robot: Robot) -> pin.Model:
    """Model of the URDF that the robot's file names, in which nothing is held."""
    return pinocchio_model(robot.urdf_source, str(robot.path))


@lru_cache(maxsize=32)
def body_order(robot: Robot, order: str) -> BodyOrder:
    """The bodies as tools have them that read the robot's URDF.

    "depth-first": limb after limb, siblings as their joints stand in the URDF, as MuJoCo, PyBullet
    and MimicKit have them; "breadth-first": level after level, siblings by the names of their
    joints, as Isaac Lab has them. Raises `InputError` for another order.
    """
    root, moved = _tree(robot)
    if order == "depth-first":
        steps = list(_depth_first(moved, root))
    elif order == "breadth-first":
        steps = list(_breadth_first(moved, root))
    else:
        raise InputError(f'order: expected "depth-first" or "breadth-first", got {order!r}')
    joints = _joint_order(robot, tuple(joint for joint, _ in steps))
    return BodyOrder(**vars(joints), bodies=(root, *(link for _, link in steps)))


def body_motion(motion: WholeBodyMotion, order: str) -> BodyMotion:
    """Where the bodies are and how they move: Pinocchio's, from the motion's own velocities."""
    robot = motion.robot
    model, data = robot.model, robot.model.createData()
    chosen = body_order(robot, order)
    # Bodies are frames of the model that moves; its masses have those of held bodies in them.
    frames = [model.getFrameId(body, pin.FrameType.BODY) for body in chosen.bodies]
    own = _own_model(robot)
    levers = [root_com(robot), *(own.inertias[own.getJointId(j)].lever for j in chosen.joints)]
    shape = len(motion.time), len(frames)
    position, velocity, com_velocity, angular = (np.empty((*shape, 3)) for _ in range(4))
    rotation = np.empty((*shape, 3, 3))
    for k, (q, v) in enumerate(zip(*pinocchio_states(motion.qpos, motion.qvel), strict=True)):
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        for b, (frame, lever) in enumerate(zip(frames, levers, strict=True)):
            moves = pin.getFrameVelocity(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
            position[k, b], rotation[k, b] = data.oMf[frame].translation, data.oMf[frame].rotation
            velocity[k, b], angular[k, b] = moves.linear, moves.angular
            com_velocity[k, b] = moves.linear + np.cross(moves.angular, rotation[k, b] @ lever)
    return BodyMotion(
        order=chosen,
        position=position,
        quat=sign_continuous(quaternions(rotation)),
        velocity=velocity,
        com_velocity=com_velocity,
        angular_velocity=angular,
    )


def root_com(robot: Robot) -> Array:
    """(3,) m: CoM of the root body in the root link's frame."""
    return np.array(_own_model(robot).inertias[BASE_JOINT].lever)


_Steps = dict[str, list[tuple[str, str]]]  # body -> (joint, body) that hang on it


def _tree(robot: Robot) -> tuple[str, _Steps]:
    """The root link, and what moves on what, as it stands in the URDF; links that are welded to a
    body are part of it.
    """
    urdf = robot.urdf_source
    children: _Steps = defaultdict(list)
    for joint in urdf.joints.values():
        children[joint.parent].append((joint.name, joint.child))
    moved: _Steps = defaultdict(list)
    joints = set(urdf_joints(robot).joints)

    def hang(link: str, body: str) -> None:
        for joint, child in children[link]:
            if joint in joints:
                moved[body].append((joint, child))
                hang(child, child)
            else:
                hang(child, body)

    hang(urdf.root, urdf.root)
    return urdf.root, moved


def _depth_first(moved: _Steps, body: str) -> Iterator[tuple[str, str]]:
    for joint, child in moved.get(body, ()):
        yield joint, child
        yield from _depth_first(moved, child)


def _breadth_first(moved: _Steps, root: str) -> Iterator[tuple[str, str]]:
    level = [root]
    while level:
        steps = [step for body in level for step in sorted(moved.get(body, ()))]
        yield from steps
        level = [child for _, child in steps]


@dataclass(frozen=True, eq=False)
class LinkPath:
    """Where one link is over K instants, seen from its parent; the root link's parent is "world".

    Attributes:
        moves: whether it does: a link behind a fixed joint does not, and has K = 1.
        position: (K, 3) m and quat: (K, 4) w, x, y, z without jumps of sign, in the parent's frame.
    """

    link: str
    parent: str
    moves: bool
    position: Array
    quat: Array


def link_paths(robot: Robot, body_position: Array, body_quat: Array) -> Iterator[LinkPath]:
    """Every link of the URDF, parents first, by which viewers of robots are moved.

    Positions (K, B, 3) m and attitudes (K, B, 4) w, x, y, z of the moving bodies are those of
    `llsrbm.look.visuals.forward_kinematics`.
    """
    model = robot.model
    rotation = rotation_matrices(body_quat)
    for frame in model.frames:
        if frame.type != pin.FrameType.BODY:
            continue
        parent = model.frames[model.frames[frame.parentFrame].parentFrame]
        R, p = _placed(frame, body_position, rotation)
        if parent.type != pin.FrameType.BODY:
            yield LinkPath(frame.name, "world", True, p, sign_continuous(quaternions(R)))
        elif parent.parentJoint == frame.parentJoint:
            seen = parent.placement.actInv(frame.placement)
            place, quat = seen.translation[None], quaternions(seen.rotation[None])
            yield LinkPath(frame.name, parent.name, False, place, quat)
        else:
            R_parent, p_parent = _placed(parent, body_position, rotation)
            back = np.swapaxes(R_parent, -1, -2)
            place = np.einsum("kij,kj->ki", back, p - p_parent)
            quat = sign_continuous(quaternions(back @ R))
            yield LinkPath(frame.name, parent.name, True, place, quat)


def _placed(frame: pin.Frame, position: Array, rotation: Array) -> tuple[Array, Array]:
    """Attitudes (K, 3, 3) and origins (K, 3) of a frame in the world."""
    body = frame.parentJoint - 1
    R = rotation[:, body]
    return R @ frame.placement.rotation, position[:, body] + R @ frame.placement.translation

"""The MuJoCo model: the robot's own URDF on a free joint, and what stands around it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

import coal
import mujoco
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.errors import RobotFileError
from llsrbm.motion.rollout import Disturbance
from llsrbm.robots.foot_contact import collision_shapes, foot_contacts
from llsrbm.robots.robot import Robot
from llsrbm.robots.urdf import BASE_JOINT
from llsrbm.simulation.contacts import add_sensors
from llsrbm.simulation.surroundings import Surroundings

Indices = NDArray[np.int64]

# Elliptic cones with friction ten times as stiff as the normal: feet that stand do not creep.
FRICTION_STIFFNESS = 10.0
CONTACT_IMPEDANCE = (0.9, 0.95, 0.001, 0.5, 2.0)  # MuJoCo's default; results hang on it
DAMPING_RATIO = 1.0  # of contacts: critical, no bouncing
TORSION_AND_ROLLING = (0.005, 0.0001)  # m, MuJoCo's default; without effect at condim 3

_WORLD, _ROBOT = 1, 2  # collision bits: the robot meets the world, never itself
_AWAY = np.array([0.0, 0.0, -100.0])  # m, where blocks are that do not stand in the world

_SHAPES = {
    coal.Sphere: (mujoco.mjtGeom.mjGEOM_SPHERE, lambda shape: [shape.radius, 0, 0]),
    coal.Box: (mujoco.mjtGeom.mjGEOM_BOX, lambda shape: shape.halfSide),
    coal.Cylinder: (
        mujoco.mjtGeom.mjGEOM_CYLINDER,
        lambda shape: [shape.radius, shape.halfLength, 0],
    ),
}


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled model and where things are in it: J joints.

    Attributes:
        model: MuJoCo's; motors and sensors in the order of the robot's joints and legs.
        q_order: (7 + J,) MuJoCo's qpos in the order of Pinocchio's q.
        v_order: (6 + J,) the same for velocities; their base is in another frame as well.
        surroundings: what stands around the robot.
        block_ids: index of each of its blocks among the mocap bodies.
    """

    model: mujoco.MjModel
    q_order: Indices
    v_order: Indices
    surroundings: Surroundings
    block_ids: tuple[int, ...]

    def move_blocks(self, data: mujoco.MjData, time: float) -> None:
        """Put blocks where they are at `time`, s."""
        for block, mocap in zip(self.surroundings.blocks, self.block_ids, strict=True):
            stands = block.from_s <= time < block.until_s
            data.mocap_pos[mocap] = block.centre if stands else _AWAY


def build_scene(
    robot: Robot, surroundings: Surroundings, disturbance: Disturbance, timestep: float
) -> Scene:
    """Compile the robot in its surroundings.

    Feet are spheres and the trunk its collision shapes; nothing else of the robot collides.
    Joints have neither armature nor damping, so that masses and accelerations are Pinocchio's.

    Args:
        disturbance: its trunk mass, friction and contact time enter the model.
        timestep: of the simulation, s.

    Raises:
        RobotFileError: the URDF lacks collision geometry, or MuJoCo refuses it.
    """
    try:
        spec = mujoco.MjSpec.from_string(_bare_urdf(robot))
    except ValueError as error:
        raise _refused(robot, error) from error
    option = spec.option
    option.timestep = timestep
    option.gravity = robot.model.gravity.linear
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = FRICTION_STIFFNESS
    touch = {
        "friction": [disturbance.friction, *TORSION_AND_ROLLING],
        "solref": [disturbance.contact_time, DAMPING_RATIO],
        "solimp": list(CONTACT_IMPEDANCE),
        "condim": 3,
    }
    _add_surroundings(spec, surroundings, touch)
    root = spec.worldbody.first_body()
    # Before compiling, or the compiler fuses the base with the world.
    root.add_freejoint()
    _set_inertias(spec, root, robot, disturbance.trunk_mass_factor)
    _add_motors(spec, robot)
    feet = _add_feet(spec, robot, touch)
    _add_trunk(spec, root, robot, touch)
    add_sensors(spec, feet, root.name)
    try:
        model = spec.compile()
    except ValueError as error:
        raise _refused(robot, error) from error
    joints = [model.joint(name) for name in robot.joint_names]
    return Scene(
        model=model,
        # Quaternion x y z w from w x y z.
        q_order=np.array([0, 1, 2, 4, 5, 6, 3, *(joint.qposadr[0] for joint in joints)]),
        v_order=np.array([*range(6), *(joint.dofadr[0] for joint in joints)]),
        surroundings=surroundings,
        block_ids=tuple(
            int(model.body(_block_name(block.name)).mocapid[0]) for block in surroundings.blocks
        ),
    )


def _bare_urdf(robot: Robot) -> str:
    """The URDF's links and joints only: without shapes, and without inertias.

    MuJoCo refuses links that are welded to others and whose own inertia is a placeholder.
    """
    root = ET.parse(robot.urdf_path).getroot()  # noqa: S314  the user's own file, read before
    for link in root.iter("link"):
        for kind in ("visual", "collision", "inertial"):
            for part in link.findall(kind):
                link.remove(part)
    return ET.tostring(root, encoding="unicode")


def _set_inertias(
    spec: mujoco.MjSpec, root: mujoco.MjsBody, robot: Robot, trunk_mass_factor: float
) -> None:
    """Give each moving body the URDF's inertia of its link and of all that is welded to it."""
    bodies = {BASE_JOINT: root}
    for joint in range(BASE_JOINT + 1, robot.model.njoints):
        bodies[joint] = spec.joint(robot.model.names[joint]).parent
    for joint, body in bodies.items():
        welded = robot.model.inertias[joint]
        factor = trunk_mass_factor if joint == BASE_JOINT else 1.0
        body.explicitinertial = True
        body.mass = factor * welded.mass
        body.ipos = welded.lever
        body.fullinertia = factor * welded.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def _add_surroundings(
    spec: mujoco.MjSpec, surroundings: Surroundings, touch: dict[str, object]
) -> None:
    spec.worldbody.add_geom(
        name="world/ground",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 1],  # endless
        pos=[0, 0, surroundings.ground],
        contype=_WORLD,
        conaffinity=_ROBOT,
        **touch,
    )
    for block in surroundings.blocks:
        body = spec.worldbody.add_body(
            name=_block_name(block.name),
            mocap=True,
            pos=_AWAY,
            quat=[np.cos(block.yaw / 2), 0, 0, np.sin(block.yaw / 2)],
        )
        body.add_geom(
            name=_block_name(block.name),
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=block.size / 2,
            mass=0,
            contype=_WORLD,
            conaffinity=_ROBOT,
            **touch,
        )


def _add_motors(spec: mujoco.MjSpec, robot: Robot) -> None:
    for name in robot.joint_names:
        joint = spec.joint(name)
        joint.armature = joint.frictionloss = 0.0
        joint.damping = np.zeros_like(joint.damping)
        # The robot file's limits hold, not the URDF's; see `llsrbm.simulation.drives`.
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)


def _add_feet(spec: mujoco.MjSpec, robot: Robot, touch: dict[str, object]) -> list[list[str]]:
    """Add the feet's spheres, without mass; returns their names, a list a foot."""
    feet = []
    for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True):
        frame = robot.model.frames[leg.foot_frame_id]
        names = []
        for i, centre in enumerate(contact.centres):
            names.append(f"foot/{leg.name}/{i}")
            spec.joint(leg.joints[-1]).parent.add_geom(
                name=names[-1],
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[contact.radius, 0, 0],
                pos=frame.placement.act(centre),
                mass=0,
                contype=_ROBOT,
                conaffinity=_WORLD,
                **touch,
            )
        feet.append(names)
    return feet


def _add_trunk(
    spec: mujoco.MjSpec, root: mujoco.MjsBody, robot: Robot, touch: dict[str, object]
) -> None:
    """Add the trunk's boxes, cylinders, spheres and the convex hulls of its meshes, massless."""
    before = len(root.geoms)
    for shape in collision_shapes(robot):
        if shape.parentJoint != BASE_JOINT:
            continue
        name, geometry = f"trunk/{shape.name}", shape.geometry
        form: dict[str, object]
        if type(geometry) in _SHAPES:
            kind, size = _SHAPES[type(geometry)]
            form = {"type": kind, "size": size(geometry)}
        elif isinstance(geometry, coal.BVHModelBase):
            spec.add_mesh(name=name, uservert=np.ravel(geometry.vertices()))
            form = {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": name}
        else:
            continue
        x, y, z, w = pin.Quaternion(shape.placement.rotation).coeffs()
        root.add_geom(
            name=name,
            **form,
            pos=shape.placement.translation,
            quat=[w, x, y, z],
            mass=0,
            contype=_ROBOT,
            conaffinity=_WORLD,
            **touch,
        )
    if len(root.geoms) == before:
        raise RobotFileError(
            f"{robot.path}: urdf: the base of {robot.urdf_path} has no collision box, cylinder, "
            "sphere or mesh; expected one, or a fall on the trunk would go unnoticed"
        )


def _block_name(name: str) -> str:
    return f"world/{name}"


def _refused(robot: Robot, error: ValueError) -> RobotFileError:
    reason = " ".join(str(error).split())
    return RobotFileError(f"{robot.path}: urdf: MuJoCo refuses {robot.urdf_path}: {reason}")

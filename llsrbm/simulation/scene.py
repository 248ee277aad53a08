"""The MuJoCo model: the robot's own URDF on a free joint, and what stands around it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import mujoco
import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array, IntArray
from llsrbm.errors import RobotFileError
from llsrbm.motion.bodies import body_order
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.link_shapes import LinkShapes
from llsrbm.robots.robot import Robot
from llsrbm.robots.urdf import BASE_JOINT, ROUNDED, bodies_on
from llsrbm.simulation.contacts import add_sensors

# Elliptic cones with friction ten times as stiff as the normal: feet that stand do not creep.
FRICTION_STIFFNESS = 10.0
CONTACT_IMPEDANCE = (0.9, 0.95, 0.001, 0.5, 2.0)  # MuJoCo's default; results hang on it
DAMPING_RATIO = 1.0  # of contacts: critical, no bouncing
TORSION_AND_ROLLING = (0.005, 0.0001)  # m, MuJoCo's default; without effect at condim 3

HUNG = 1.0  # m over the default posture

_WORLD, _ROBOT = 1, 2  # collision bits: the robot meets the world; itself by stated pairs alone
_AWAY = np.array([0.0, 0.0, -100.0])  # m, where blocks are that do not stand in the world

_FLAT = 1e-13  # of the largest moment, which MuJoCo's own rounding needs

_TYPES = {
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
}


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled model and where things are in it: J joints."""

    # MuJoCo's; motors and sensors in the order of the robot's joints and legs.
    model: mujoco.MjModel
    q_order: IntArray  # (7 + J,) MuJoCo's qpos in the order of Pinocchio's q
    v_order: IntArray  # (6 + J,) the same for velocities; their base is in another frame as well
    surroundings: Surroundings  # what stands around the robot
    block_ids: tuple[int, ...]  # index of each of its blocks among the mocap bodies

    def move_blocks(self, data: mujoco.MjData, time: float) -> None:
        """Put blocks where they are at `time`, s."""
        if not self.block_ids:
            return
        for place, mocap in zip(block_places(self.surroundings, time), self.block_ids, strict=True):
            data.mocap_pos[mocap] = place


def block_places(surroundings: Surroundings, time: float) -> Array:
    """Centres of B blocks at `time`, s: (B, 3) m, far below the ground while they do not stand."""
    places = [
        block.centre if block.from_s <= time < block.until_s else _AWAY
        for block in surroundings.blocks
    ]
    return np.reshape(places, (len(places), 3))


def build_scene(
    robot: Robot,
    surroundings: Surroundings,
    disturbance: Disturbance,
    timestep: float,
    *,
    hung: bool = False,
) -> Scene:
    """Compile the robot in its surroundings, with sensors; `timestep` in s.

    `hung`: whether something holds its base where `hung_posture` has it.

    Of the disturbance trunk mass, rotors, both frictions and contact time enter. Raises
    `RobotFileError`: the URDF lacks collision geometry, or MuJoCo refuses it.
    """
    spec = scene_spec(robot, surroundings, disturbance, timestep)
    if hung:
        _hang(spec, robot)
    untouched = [block_body(block.name) for block in surroundings.blocks if block.untouched]
    add_sensors(spec, foot_geoms(robot), untouched)
    model = compiled(spec, robot)
    joints = [model.joint(name) for name in robot.joint_names]
    return Scene(
        model=model,
        # Quaternion x y z w from w x y z.
        q_order=np.array([0, 1, 2, 4, 5, 6, 3, *(joint.qposadr[0] for joint in joints)]),
        v_order=np.array([*range(6), *(joint.dofadr[0] for joint in joints)]),
        surroundings=surroundings,
        block_ids=tuple(
            int(model.body(block_body(block.name)).mocapid[0]) for block in surroundings.blocks
        ),
    )


def scene_spec(
    robot: Robot,
    surroundings: Surroundings,
    disturbance: Disturbance,
    timestep: float,
    motors: Sequence[str] | None = None,
) -> mujoco.MjSpec:
    """The robot in its surroundings, not compiled yet; arguments and errors as `build_scene`.

    Feet meet the world as spheres, everything else as the shapes of its link; shapes of links that
    can meet touch each other (`llsrbm.robots.link_shapes`).
    Joints have the drives' rotors, Coulomb friction and damping, as the disturbance has them.
    `motors`: the joints in their order; None: that of `robot.joint_names`.
    """
    spec = _skeleton(robot)
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
    root = robot_root(spec)
    _add_surroundings(spec, surroundings, touch)
    # Before compiling, or the compiler fuses the base with the world.
    root.add_freejoint()
    _set_inertias(spec, robot, disturbance.trunk_mass_factor)
    _add_motors(spec, robot, disturbance, robot.joint_names if motors is None else motors)
    _add_feet(spec, robot, touch)
    _add_links(spec, robot, touch)
    return spec


def compiled(spec: mujoco.MjSpec, robot: Robot) -> mujoco.MjModel:
    """The model. Raises `RobotFileError`: MuJoCo refuses it."""
    try:
        return spec.compile()
    except ValueError as error:
        raise _refused(robot, error) from error


@lru_cache(maxsize=16)
def joints_in_model_order(robot: Robot) -> tuple[str, ...]:
    """(J,) names of the joints in the order of MuJoCo's qpos: depth-first through the URDF. Raises
    `RobotFileError`: MuJoCo refuses the URDF.
    """
    return tuple(joint.name for joint in _skeleton(robot).joints)


def foot_geoms(robot: Robot) -> list[list[str]]:
    """Names of the feet's spheres, a list a foot, in the order of the legs."""
    return [
        [f"foot/{leg.name}/{i}" for i in range(len(contact.centres))]
        for leg, contact in zip(robot.legs, foot_contacts(robot), strict=True)
    ]


def block_body(name: str) -> str:
    """Name of a block's body, and of its geom."""
    return f"world/{name}"


def moving_bodies(spec: mujoco.MjSpec, robot: Robot) -> dict[int, mujoco.MjsBody]:
    """The body that each of Pinocchio's joints moves, the base's among them."""
    bodies = {BASE_JOINT: robot_root(spec)}
    for joint in range(BASE_JOINT + 1, robot.model.njoints):
        bodies[joint] = spec.joint(robot.model.names[joint]).parent
    return bodies


def robot_root(spec: mujoco.MjSpec) -> mujoco.MjsBody:
    """The robot's base."""
    return spec.worldbody.first_body()


def _skeleton(robot: Robot) -> mujoco.MjSpec:
    """The robot's bodies and joints: Pinocchio's, siblings in the order of the URDF."""
    model, spec = robot.model, mujoco.MjSpec()
    spec.compiler.degree = False
    bodies = {BASE_JOINT: _add_body(spec.worldbody, robot, BASE_JOINT)}
    for step in body_order(robot, "depth-first").joints:
        if step not in robot.joint_names:
            continue
        joint = model.getJointId(step)
        body = _add_body(bodies[model.parents[joint]], robot, joint)
        slides = step in robot.sliding_joints
        motion = np.asarray(model.joints[joint].createData().S).reshape(6)
        low, high = robot.joint_stops[:, robot.joint_names.index(step)]
        body.add_joint(
            name=step,
            type=mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE,
            axis=motion[:3] if slides else motion[3:],
            range=[low, high],
            limited=mujoco.mjtLimited.mjLIMITED_TRUE,
        )
        bodies[joint] = body
    return spec


def _add_body(parent: mujoco.MjsBody, robot: Robot, joint: int) -> mujoco.MjsBody:
    """The body that a joint moves, called like its first link."""
    link = bodies_on(robot.model, joint)[0].name
    place = robot.model.jointPlacements[joint]
    x, y, z, w = pin.Quaternion(place.rotation).coeffs()
    # MuJoCo's own world has that name.
    name = "world_link" if link == "world" else link
    return parent.add_body(name=name, pos=place.translation, quat=[w, x, y, z])


def _set_inertias(spec: mujoco.MjSpec, robot: Robot, trunk_mass_factor: float) -> None:
    for joint, body in moving_bodies(spec, robot).items():
        welded = _thickened(robot.model.inertias[joint])
        factor = trunk_mass_factor if joint == BASE_JOINT else 1.0
        body.explicitinertial = True
        body.mass = factor * welded.mass
        body.ipos = welded.lever
        body.fullinertia = factor * welded.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def _thickened(body: pin.Inertia) -> pin.Inertia:
    """A flat body less flat by the rounding of its numbers: MuJoCo allows none."""
    a, b, c = np.linalg.eigvalsh(body.inertia)
    missing = c - a - b
    if missing < -ROUNDED * c:
        return body
    more = 2 * max(missing, 0.0) + _FLAT * c
    return pin.Inertia(body.mass, body.lever, body.inertia + more * np.eye(3))


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
            name=block_body(block.name),
            mocap=True,
            pos=_AWAY,
            quat=block.quat,
        )
        body.add_geom(
            name=block_body(block.name),
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=block.size / 2,
            mass=0,
            contype=_WORLD,
            conaffinity=_ROBOT,
            **touch,
        )


def hung_posture(robot: Robot) -> Array:
    """(nq,) default posture with the base as high as no foot can reach the ground from."""
    q = robot.posture.copy()
    q[2] += HUNG
    return q


def _hang(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Hold the base where it hangs, by a weld that is as stiff as a time step allows."""
    x, y, z, qx, qy, qz, qw = hung_posture(robot)[:7]
    weld = spec.add_equality(
        name="world/hung",
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=robot_root(spec).name,
        solref=[2 * spec.option.timestep, 1.0],
        solimp=[0.9999, 0.9999, 0.001, 0.5, 2.0],
    )
    # Of the world seen from the base: an anchor, a pose, and how turning weighs against moving.
    base = pin.SE3(pin.Quaternion(qw, qx, qy, qz).toRotationMatrix(), np.array([x, y, z])).inverse()
    turned = pin.Quaternion(base.rotation)
    pose = [*base.translation, turned.w, turned.x, turned.y, turned.z]
    weld.data[:11] = [0.0, 0.0, 0.0, *pose, 1.0]


def _add_motors(
    spec: mujoco.MjSpec, robot: Robot, disturbance: Disturbance, joints: Sequence[str]
) -> None:
    losses = disturbance.joint_friction_factor
    for name in joints:
        joint, k = spec.joint(name), robot.joint_names.index(name)
        joint.armature = disturbance.armature_factor * robot.armature[k]
        joint.frictionloss = losses * robot.friction[k]
        # As stiff as a time step allows: by MuJoCo's default, 20 ms, friction pushes joints on that
        # their drives brake, up to some rad/s.
        joint.solref_friction = [2 * spec.option.timestep, 1.0]
        # The first of a polynomial's coefficients.
        joint.damping = np.eye(len(joint.damping))[0] * losses * robot.damping[k]
        # The robot file's limits hold, not the URDF's; see `Drives`.
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)


def _add_feet(spec: mujoco.MjSpec, robot: Robot, touch: dict[str, object]) -> None:
    for leg, contact, names in zip(
        robot.legs, foot_contacts(robot), foot_geoms(robot), strict=True
    ):
        frame = robot.model.frames[leg.foot_frame_id]
        for name, centre in zip(names, contact.centres, strict=True):
            spec.joint(leg.joints[-1]).parent.add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[contact.radius, 0, 0],
                pos=frame.placement.act(centre),
                mass=0,
                contype=_ROBOT,
                conaffinity=_WORLD,
                **touch,
            )


def _add_links(spec: mujoco.MjSpec, robot: Robot, touch: dict[str, object]) -> None:
    """The links' shapes, and the pairs of those that can meet.

    Of a foot's link the world meets the spheres alone, or soles would stand on their hulls.
    """
    links = LinkShapes.of(robot)
    if all(shape.joint != BASE_JOINT for shape in links.shapes):
        raise RobotFileError(
            f"{robot.path}: urdf: the base of {robot.urdf_path} has no collision box, cylinder, "
            "sphere or mesh; expected one, or a fall on the trunk would go unnoticed"
        )
    bodies = moving_bodies(spec, robot)
    names = [f"link/{shape.link}/{k}" for k, shape in enumerate(links.shapes)]
    for name, shape in zip(names, links.shapes, strict=True):
        form: dict[str, object]
        if shape.kind == "hull":
            spec.add_mesh(name=name, uservert=np.ravel(shape.points))
            form = {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": name}
        else:
            form = {"type": _TYPES[shape.kind], "size": shape.size}
        x, y, z, w = pin.Quaternion(shape.rotation).coeffs()
        bodies[shape.joint].add_geom(
            name=name,
            **form,
            pos=shape.centre,
            quat=[w, x, y, z],
            mass=0,
            contype=0 if shape.foot else _ROBOT,
            conaffinity=0 if shape.foot else _WORLD,
            **touch,
        )
    for one, other in links.shape_pairs:
        spec.add_pair(geomname1=names[one], geomname2=names[other], **_of_pair(touch))


def _of_pair(touch: dict[str, object]) -> dict[str, object]:
    """A pair of geoms states for itself what else follows from both."""
    sliding, torsion, rolling = np.array(touch["friction"])
    return {**touch, "friction": [sliding, sliding, torsion, rolling, rolling]}


def _refused(robot: Robot, error: ValueError) -> RobotFileError:
    reason = " ".join(str(error).split())
    return RobotFileError(f"{robot.path}: urdf: MuJoCo refuses {robot.urdf_path}: {reason}")

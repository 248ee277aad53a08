"""A plan followed in the simulator, from its start to a second after its end."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.control.controller import WholeBodyController
from llsrbm.control.reference import braking_time
from llsrbm.control.whole_body import WholeBody
from llsrbm.errors import InputError
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.grounds import foot_normals
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import surroundings
from llsrbm.ocp.progress import interruptible
from llsrbm.request.scenario import Scenario
from llsrbm.robots.drives.variants import driven
from llsrbm.robots.feet import foot_contacts
from llsrbm.robots.robot import Robot
from llsrbm.simulation.disturbance import Pushes, draw_disturbance
from llsrbm.simulation.episode import Episode, Hook, Recorder
from llsrbm.simulation.replanning import Replanning
from llsrbm.simulation.sensors import Sensors
from llsrbm.simulation.verdict import judge
from llsrbm.simulation.world import World

_EXACT = 1e-9  # m and rad: where Newton's step stops
_GOOD = 1e-5  # m and rad: far below what feet sink in by standing
_ITERATIONS = 50
_SLOW = 0.02  # m/s and rad/s: a small part of a run-up's speed
_LONGEST_STEP = 0.2  # rad or m a joint: the linearisation holds


def standing_state(robot: Robot, plan: Plan) -> Array:
    """The posture q (nq,), Pinocchio's, in which the robot stands at the plan's first knot.

    Base attitude and CoM are the plan's. The feet's spheres rest on the plan's contact points; a
    draft's balls are above them by the same in all postures, so where a foot's frame is not the
    middle of its ball the legs are bent a little more or less. Raises `InputError`: the robot
    cannot stand so.
    """
    if set(plan.joint_names) != set(robot.joint_names):
        raise InputError(
            f"plan: it has joints {', '.join(plan.joint_names)}; expected a plan of "
            f"{robot.file.title}: {', '.join(robot.joint_names)}"
        )
    model, contacts = robot.model, foot_contacts(robot)
    data = model.createData()
    # Spheres may lie inside of a sole's corners: the sole's own place is what counts.
    R_world_foot = rotation_matrices(plan.foot_quat[0])
    normals, flat = foot_normals(plan, plan.time[:1])[0], np.array([1.0, 1.0, 0.0])
    point = robot.file.foot.is_point
    places = plan.contact_point[0] if point else plan.foot_position[0]
    goal = [
        place + (contact.centres * flat) @ R.T + contact.radius * normal
        for place, R, contact, normal in zip(places, R_world_foot, contacts, normals, strict=True)
    ]
    R_world_base = rotation_matrices(plan.base_quat[0])
    q = robot.posture.copy()
    q[:3] = plan.base_position[0]
    q[3:7] = np.roll(plan.base_quat[0], -1)
    q[7:] = plan.joint_position[0][[plan.joint_names.index(name) for name in robot.joint_names]]
    for _ in range(_ITERATIONS):
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        J_com = pin.jacobianCenterOfMass(model, data, q)
        R = data.oMi[1].rotation
        turn = np.zeros((3, model.nv))
        turn[:, 3:6] = np.eye(3)
        errors, jacobians = [plan.com[0] - data.com[0], pin.log3(R.T @ R_world_base)], [J_com, turn]
        for leg, contact, aims in zip(robot.legs, contacts, goal, strict=True):
            frame = data.oMf[leg.foot_frame_id]
            J = pin.getFrameJacobian(
                model, data, leg.foot_frame_id, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
            )
            for centre, place in zip(contact.centres, aims, strict=True):
                lever = frame.rotation @ centre
                errors.append(place - frame.translation - lever)
                jacobians.append(J[:3] - pin.skew(lever) @ J[3:])
        error = np.concatenate(errors)
        if np.abs(error).max() < _EXACT:
            break
        step = np.linalg.lstsq(np.vstack(jacobians), error, rcond=1e-8)[0]
        step *= min(1.0, _LONGEST_STEP / np.abs(step).max())
        q = pin.integrate(model, q, step)
    if not np.abs(error).max() < _GOOD:
        raise InputError(
            f"plan: {robot.file.title} cannot stand as its first knot says: "
            f"{np.abs(error).max():.3g} m or rad are left; expected a plan of this robot"
        )
    return q


def starting_velocity(robot: Robot, plan: Plan, q: Array) -> Array:
    """V (nv,) of the whole robot in q (nq,), `standing_state`: zero, or that of a run-up.

    CoM and base move as the plan says, and feet roll without slipping. Raises `InputError`: the
    robot's legs do not let it move so.
    """
    if not plan.jump.speed:
        return np.zeros(robot.model.nv)
    body = WholeBody(robot)
    body.update(q, np.zeros(robot.model.nv))
    turn = np.zeros((3, robot.model.nv))
    turn[:, 3:6] = body.R_world_base
    feet = body.contact_jacobian.reshape(-1, robot.model.nv)
    jacobian = np.vstack([body.momentum_matrix[:3] / body.mass, turn, feet])
    wanted = np.concatenate(
        [plan.com_velocity[0], plan.angular_velocity[0], np.zeros(feet.shape[0])]
    )
    velocity: Array = np.linalg.lstsq(jacobian, wanted, rcond=1e-8)[0]
    left = float(np.abs(jacobian @ velocity - wanted).max())
    if left > _SLOW:
        raise InputError(
            f"plan: {robot.file.title} cannot move as its first knot says: {left:.3g} m/s or "
            "rad/s are left; expected a speed that its legs allow with all feet at rest"
        )
    return velocity


STANDING = 1.0  # s after the plan's end, and after what speed it ends with, in which robots stand


def simulate(
    plan: Plan,
    robot: Robot,
    scenario: Scenario,
    *,
    cancelled: Callable[[], bool] | None = None,
    progress: Callable[[float], None] | None = None,
    so_far: Callable[[Array, Array], None] | None = None,
) -> Rollout:
    """Let the whole robot follow a plan that converged; see `llsrbm.simulate`.

    `robot` is as the controller believes it is; `cancelled`, `progress`, `so_far`: see
    `Episode.run`.

    Raises:
        InputError: a name that is unknown, a board that does not fit under the robot, or a
            push outside of the simulated time.
        Cancelled: on request.
    """
    robot = driven(robot, scenario.drives)
    disturbance = draw_disturbance(robot, scenario)
    duration = plan.duration + braking_time(plan) + STANDING
    tick = 1.0 / robot.file.control.rate
    pushes = Pushes(plan, scenario, duration)
    world = World(robot, surroundings(robot, plan, scenario), disturbance, tick)
    controller = WholeBodyController(robot, plan, scenario)
    recorder = Recorder(robot, disturbance)
    sensors = Sensors(robot, disturbance, scenario, tick)
    start = standing_state(robot, plan)
    world.reset(start, starting_velocity(robot, plan, start))
    hooks: list[Hook] = [pushes]
    if scenario.replan:
        latency = scenario.replan_latency
        hooks.append(interruptible(lambda: Replanning(plan, robot, tick, latency), cancelled))
    episode = Episode(world, sensors, controller, recorder, hooks)
    episode.run(round(duration / tick) + 1, cancelled=cancelled, progress=progress, so_far=so_far)

    if progress is not None:
        progress(1.0)
    columns = recorder.arrays(world.joint_order)
    columns["time"] = np.arange(len(recorder)) * tick
    run = episode.fall, episode.wall_time, episode.replans
    return Rollout(
        jump=plan.jump,
        robot_parameters=robot.parameters(),
        control_parameters=robot.control_parameters(),
        scenario=scenario,
        disturbance=replace(disturbance, random_push=pushes.drawn),
        outcome=judge(robot, plan, recorder, columns, controller, *run),
        plan=plan,
        joint_names=tuple(robot.joint_names[j] for j in world.joint_order),
        detection_threshold=controller.detector.threshold,
        replans=tuple(episode.replans),
        **columns,
    )

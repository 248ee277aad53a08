"""The simulated world as a control loop sees it: torques and pushes in, state and contacts out.

Between the controller and the joints are drives: torques arrive late, and within limits.
"""

from __future__ import annotations

import logging
from collections import deque
from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np

from llsrbm.arrays import Array, BoolArray
from llsrbm.motion.rollout import Disturbance
from llsrbm.motion.surroundings import Surroundings
from llsrbm.robots.drives.torques import torque_in_direction
from llsrbm.robots.robot import Robot
from llsrbm.simulation.contacts import ContactReader, Touch
from llsrbm.simulation.scene import build_scene, hung_posture

_log = logging.getLogger(__name__)

FLAT = Surroundings(ground=0.0, blocks=())
STEP = 5e-4  # s; steps are not longer. Impacts change by less than their scatter below it.


def steps_in(tick: float) -> int:
    """Steps of the simulation in a control period, s."""
    return max(1, int(np.ceil(tick / STEP - 1e-9)))


class JointLaw(Protocol):
    """Torques that follow the joints from step to step, such as a `MotorCommand`."""

    def torque(self, q: Array, dq: Array) -> Array:
        """Torque (J,) Nm or N wanted at positions q (J,) and speeds dq (J,), called once a step."""


class Diverged(Exception):
    """The simulation has become meaningless: numbers are not finite, or huge."""


@dataclass(frozen=True, eq=False)
class TickResult:
    """Contacts and torques of one tick: L legs, J joints."""

    # (L, 3) N, mean of the tick, world frame: on the foot, sum of all it touches.
    contact_force: Array
    contact: BoolArray  # (L,) whether the foot touched in any step of the tick
    first_contact: Array  # (L,) s: start of the first step in which it did; nan if none
    torque: Array  # (J,) Nm or N as applied, mean of the tick
    # (J,) most that the drives could give at their speed, in the torque's direction; mean of the
    # tick.
    torque_limit: Array
    # What else than a foot touched, and when first, s: in the order of these times.
    touches: tuple[tuple[Touch, float], ...]
    obstacle_contact: bool  # whether anything touched what is to be jumped over

    @property
    def trunk_contact(self) -> bool:
        """True if the trunk, or what it carries, touched something that is not the robot."""
        return any(touch.trunk for touch, _ in self.touches)

    @classmethod
    def unknown(cls, legs: int, joints: int) -> TickResult:
        """Result of a tick in which the simulation diverged: no contact, no torque."""
        return cls(
            contact_force=np.zeros((legs, 3)),
            contact=np.zeros(legs, dtype=bool),
            first_contact=np.full(legs, np.nan),
            torque=np.zeros(joints),
            torque_limit=np.zeros(joints),
            touches=(),
            obstacle_contact=False,
        )


class Drives:
    """J drives in the order of `robot.joint_names`; their torques come `late` steps, of `steps` a
    tick.

    `voltage`: share of the voltage for which the speed limits are stated; they fall with it.
    """

    def __init__(self, robot: Robot, late: int = 0, steps: int = 1) -> None:
        self._robot = robot
        self._late, self._steps = late, steps
        self._sent: deque[Array | JointLaw] = deque(maxlen=1 - (-late // steps))  # the last first
        self.voltage = 1.0

    def reset(self) -> None:
        """Forget the commands under way."""
        self._sent.clear()

    def send(self, command: Array | JointLaw) -> None:
        """Take the command of the tick that begins."""
        if not self._sent:
            # Before the first tick nothing was sent; the robot was held as it is from then on.
            self._sent.extend([command] * (self._sent.maxlen or 1))
        self._sent.appendleft(command)

    def acting(self, step: int) -> Array | JointLaw:
        """The command that acts in a step of the tick."""
        return self._sent[max(0, -((step - self._late) // self._steps))]

    def limited(self, torque: Array, speed: Array) -> tuple[Array, Array]:
        """Torque (J,) applied of one at a speed (J,), and the most there is in its direction."""
        limit = torque_in_direction(self._robot, speed / self.voltage, torque)
        return np.copysign(np.minimum(np.abs(torque), limit), torque), limit


class World:
    """The robot and its surroundings, at rest in its default posture until `reset`.

    `hung`: whether something holds its base in the air; `tick`: control period, s; `drives`:
    between commands and joints, with their file's delay or `delay`, s, and that of the disturbance,
    in whole steps; `joint_order`: (J,) where the joints of MuJoCo's qpos are in
    `robot.joint_names`. Raises `RobotFileError`: the URDF cannot be simulated.
    """

    def __init__(
        self,
        robot: Robot,
        surroundings: Surroundings,
        disturbance: Disturbance,
        tick: float,
        delay: float | None = None,
        *,
        hung: bool = False,
    ) -> None:
        self.tick = tick
        self._steps = steps = steps_in(tick)
        self.scene = build_scene(robot, surroundings, disturbance, tick / steps, hung=hung)
        self._model = self.scene.model
        self._data = mujoco.MjData(self._model)
        self._qpos, self._qvel, self._ctrl = self._data.qpos, self._data.qvel, self._data.ctrl
        self._joints, self._angles = self.scene.v_order[6:], self.scene.q_order[7:]
        self.joint_order = np.argsort(self._joints)
        own = robot.drive_delay if delay is None else delay
        late = round(own / tick * steps) + disturbance.torque_delay_ticks * steps
        self.drives = Drives(robot, late, steps)
        self._contacts = ContactReader(
            self._model, self._data, len(robot.legs), len(robot.corners), self._steps
        )
        self._torque, self._limit = np.zeros((2, self._steps, len(robot.joint_names)))
        # MuJoCo's acts on the CoM of the body, whose inertia is that of the trunk alone.
        self._wrench = self._data.xfrc_applied[self._model.jnt_bodyid[0]]
        self._warnings = self._data.warning.number
        self._conjugate = np.empty(4)
        self._ticks = 0
        self.reset(hung_posture(robot) if hung else robot.posture, np.zeros(robot.model.nv))

    @property
    def mass(self) -> float:
        """Total mass (kg) of the simulated robot."""
        return float(self._model.body_subtreemass[self._model.jnt_bodyid[0]])

    @property
    def time(self) -> float:
        """Since the reset, s."""
        return self._ticks * self.tick

    @property
    def qpos(self) -> Array:
        """(7 + J,) MuJoCo's, a copy."""
        return self._qpos.copy()

    @property
    def qvel(self) -> Array:
        """(6 + J,) MuJoCo's, a copy."""
        return self._qvel.copy()

    def reset(self, q: Array, v: Array) -> None:
        """Start over from q (nq,), v (nv,), Pinocchio's conventions, at time 0."""
        mujoco.mj_resetData(self._model, self._data)
        self._qpos[self.scene.q_order] = q
        mujoco.mju_normalize4(self._qpos[3:7])
        self._qvel[self.scene.v_order] = v
        # The base's velocity is in the world frame here, in the base's own there.
        mujoco.mju_rotVecQuat(self._qvel[:3], v[:3], self._qpos[3:7])
        self.drives.reset()
        self._ticks = 0
        self.scene.move_blocks(self._data, 0.0)
        mujoco.mj_forward(self._model, self._data)

    def state(self) -> tuple[Array, Array]:
        """True q (nq,) and v (nv,), Pinocchio's conventions: copies."""
        q, v = self._qpos.take(self.scene.q_order), self._qvel.take(self.scene.v_order)
        mujoco.mju_negQuat(self._conjugate, self._qpos[3:7])
        mujoco.mju_rotVecQuat(v[:3], self._qvel[:3], self._conjugate)
        return q, v

    def push(self, force: Array, moment: Array) -> None:
        """Let a wrench act on the trunk during the next tick, beside what acts already. `force`:
        (3,) N, world frame, on the trunk's CoM; `moment`: (3,) N m, world frame, about it.
        """
        self._wrench[:3] += force
        self._wrench[3:] += moment

    def advance(self, command: Array | JointLaw) -> TickResult:
        """Let a tick pass, with the wrenches that were pushed with since the last.

        `command`: torques (J,) Nm or N, in the order of `robot.joint_names`, or the law by which
        they follow the joints. Raises `Diverged`: the tick is worth nothing, nor is the state until
        a `reset`.
        """
        self.scene.move_blocks(self._data, self.time)
        if isinstance(command, np.ndarray):
            command = np.array(command, dtype=float)
        self.drives.send(command)
        others = mujoco.get_mju_user_warning()
        # By itself MuJoCo prints warnings and writes them to a file in the working directory.
        mujoco.set_mju_user_warning(_log.info)
        try:
            self._let_steps_pass()
        finally:
            mujoco.set_mju_user_warning(others)
        self._wrench[:] = 0.0
        if np.logical_or.reduce(self._warnings):
            # MuJoCo has already put the robot back to where its model was compiled.
            raise Diverged(self._cause())
        touched = self._contacts.touched()
        contact: BoolArray = np.logical_or.reduce(touched)
        start = self.time
        first = start + touched.argmax(axis=0) * (self.tick / self._steps)
        self._ticks += 1
        return TickResult(
            contact_force=self._contacts.mean_force(),
            contact=contact,
            first_contact=np.where(contact, first, np.nan),
            torque=np.add.reduce(self._torque, axis=0) / self._steps,
            torque_limit=np.add.reduce(self._limit, axis=0) / self._steps,
            touches=tuple(
                (touch, start + step * self.tick / self._steps)
                for touch, step in self._contacts.touches().items()
            ),
            obstacle_contact=self._contacts.untouched_touched(),
        )

    def _let_steps_pass(self) -> None:
        acting, limited, read = self.drives.acting, self.drives.limited, self._contacts.read
        model, data = self._model, self._data
        for step in range(self._steps):
            speed = self._qvel.take(self._joints)
            command = acting(step)
            if isinstance(command, np.ndarray):
                wanted = command
            else:
                wanted = command.torque(self._qpos.take(self._angles), speed)
            applied, self._limit[step] = limited(wanted, speed)
            self._ctrl[:] = self._torque[step] = applied
            mujoco.mj_step(model, data)
            read(step)

    def _cause(self) -> str:
        kind = int(self._warnings.argmax())
        text = mujoco.mju_warningText(kind, self._data.warning[kind].lastinfo)
        return f"MuJoCo after {self.time:.4f} s: {text}"

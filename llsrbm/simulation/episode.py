"""`Episode`: the loop of a simulation: measure, decide, advance, record; and what hooks into it."""

import math
import time as wall_clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array, IntArray
from llsrbm.body.momentum import centroidal_states
from llsrbm.control.controller import Tick, WholeBodyController
from llsrbm.control.delay import Measurement
from llsrbm.errors import Cancelled
from llsrbm.motion.replan import Replan
from llsrbm.motion.rollout import Disturbance
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.simulation.sensors import Sensors
from llsrbm.simulation.world import Diverged, TickResult, World


class Recorder:
    """Collects ticks; `arrays` has the columns of a `Rollout`; `mass`: kg, that is simulated."""

    def __init__(self, robot: Robot, disturbance: Disturbance) -> None:
        self._robot = robot
        self._model = disturbance.model(robot)
        self.mass = float(pin.computeTotalMass(self._model))
        self.q: list[Array] = []
        self.v: list[Array] = []
        self.qpos: list[Array] = []
        self.qvel: list[Array] = []
        self.ticks: list[Tick] = []
        self.results: list[TickResult] = []
        self.tick_times: list[float] = []

    def __len__(self) -> int:
        return len(self.results)

    def add(
        self,
        state: tuple[Array, Array],
        mujoco_state: tuple[Array, Array],
        tick: Tick,
        tick_time: float,
        result: TickResult,
    ) -> None:
        """Take one tick: true state at its beginning, decision, wall time of it, what came."""
        self.q.append(state[0])
        self.v.append(state[1])
        self.qpos.append(mujoco_state[0])
        self.qvel.append(mujoco_state[1])
        self.ticks.append(tick)
        self.tick_times.append(tick_time)
        self.results.append(result)

    def so_far(self, tick: float, stride: int) -> tuple[Array, Array]:
        """Instants (K,) s and states (K, 7 + J) of every `stride`-th tick.

        Quaternions w, x, y, z; joints in `Robot.joint_names`' order.
        """
        states = self.q[::stride]
        q: Array = np.array(states).reshape(len(states), self._model.nq)
        time: Array = stride * tick * np.arange(len(states), dtype=np.float64)
        return time, np.concatenate([q[:, :3], q[:, 6:7], q[:, 3:6], q[:, 7:]], axis=1)

    def arrays(self, joint_order: IntArray) -> dict[str, Any]:
        """The columns, joints in the simulator's order: places (J,) in `Robot.joint_names`."""
        ticks, results = self.ticks, self.results
        return {
            "qpos": np.array(self.qpos),
            "qvel": np.array(self.qvel),
            "torque": np.array([result.torque for result in results])[:, joint_order],
            "torque_limit": np.array([result.torque_limit for result in results])[:, joint_order],
            "contact": np.array([result.contact for result in results]).astype(np.int64),
            "contact_force": np.array([result.contact_force for result in results]),
            "average_spatial_velocity_norm": np.array(
                [tick.average_spatial_velocity_norm for tick in ticks]
            ),
            "detection_signal": np.array([tick.detection_signal for tick in ticks]),
            "mode": np.array([tick.mode for tick in ticks], dtype=np.int64),
            "phase": np.array([tick.phase for tick in ticks], dtype=np.int64),
            "reference_com": np.array([tick.target.com for tick in ticks]),
            "reference_base_quat": Rotation.from_matrix(
                np.array([tick.target.R_world_base for tick in ticks])
            ).as_quat(scalar_first=True),
            "reference_foot_position": np.array([tick.foot_target for tick in ticks]),
            "reference_angular_momentum": np.array(
                [tick.target.angular_momentum for tick in ticks]
            ),
            **self._centroidal(),
        }

    def _centroidal(self) -> dict[str, Array]:
        """Columns computed from the states, with the masses that were simulated."""
        model, robot = self._model, self._robot
        data = model.createData()
        contacts = foot_contacts(robot)
        q = np.array(self.q)
        com, inertia, momentum = centroidal_states(model, q, np.array(self.v))
        middles = [contact.middle for contact in contacts]
        foot = np.empty((len(q), len(contacts), 3))
        for k, position in enumerate(self.q):
            pin.forwardKinematics(model, data, position)
            for i, (leg, middle) in enumerate(zip(robot.legs, middles, strict=True)):
                frame = pin.updateFramePlacement(model, data, leg.foot_frame_id)
                foot[k, i] = frame.act(middle)
        foot[..., 2] -= [contact.radius for contact in contacts]
        return {
            "com": com,
            "base_position": q[:, :3].copy(),
            "base_quat": q[:, [6, 3, 4, 5]],
            "linear_momentum": momentum[:, :3],
            "angular_momentum": momentum[:, 3:],
            "inertia": inertia,
            "foot_position": foot,
        }


LEAST_TICKS = 2  # of a rollout: where it diverges before, its last known state is repeated
TOPPLED = np.radians(60.0)  # from the planned attitude: beyond this no robot comes back
_AFTER_FALL = 0.3  # s that are still shown of a robot that has fallen
_LOOK_EVERY = 20  # ticks between two calls of `cancelled` and `progress`
SO_FAR_INTERVAL = 0.2  # s of wall time between two reports of the motion so far
SO_FAR_RATE = 60.0  # instants/s in them: as browsers draw


@dataclass(frozen=True)
class Fall:
    """When and how a robot fell."""

    time: float
    reason: str


def fallen(time: float, q: Array, planned: Array, result: TickResult) -> Fall | None:
    """The fall, if it has fallen in the state q (nq,), with its base planned to be at (3, 3)."""
    if result.trunk_contact:
        return Fall(time, "the trunk touched the ground")
    if result.obstacle_contact:
        return Fall(time, "it touched the hurdle")
    x, y, z, w = q[3:7].tolist()
    up = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    if up.dot(planned[:, 2]) < math.cos(TOPPLED):
        return Fall(time, "it toppled over")
    return None


@dataclass(frozen=True, eq=False)
class Situation:
    """A tick's beginning, as hooks see it."""

    time: float  # s since the plan's start
    # What the controller will decide by; a hook that belongs to the robot knows no more.
    measurement: Measurement
    controller: WholeBodyController  # which feet stand, what is tracked
    world: World  # to push in; it has not advanced yet
    replans: list[Replan]  # to add to; they end up in the rollout


class Hook:
    """Something that takes part in the loop."""

    def before(self, situation: Situation) -> None:
        """Act before the controller decides."""

    def after(self, situation: Situation, tick: Tick, result: TickResult) -> None:
        """Look at what the tick has brought."""


class Episode:
    """One simulation, from the world as it stands; hooks act in their order.

    `fall`: when and how the robot fell, None so far; `replans`: what hooks have added; `wall_time`:
    s, of the whole loop.
    """

    def __init__(
        self,
        world: World,
        sensors: Sensors,
        controller: WholeBodyController,
        recorder: Recorder,
        hooks: Sequence[Hook] = (),
    ) -> None:
        self._world, self._sensors, self._controller = world, sensors, controller
        self._recorder, self._hooks = recorder, tuple(hooks)
        self.fall: Fall | None = None
        self.replans: list[Replan] = []
        self.wall_time = 0.0

    def run(
        self,
        ticks: int,
        *,
        cancelled: Callable[[], bool] | None = None,
        progress: Callable[[float], None] | None = None,
        so_far: Callable[[Array, Array], None] | None = None,
    ) -> None:
        """Let so many ticks pass, or fewer where the robot falls.

        `cancelled` is called every 20 ticks, with `progress` (share done, 0 to 1); `so_far` every
        `SO_FAR_INTERVAL` with instants (K,) s and states (K, 7 + J) until now, see
        `Recorder.so_far`. Raises `Cancelled`: on request.
        """
        tick = self._world.tick
        stride = max(1, round(1.0 / (tick * SO_FAR_RATE)))
        result: TickResult | None = None
        began = reported_at = wall_clock.perf_counter()
        for k in range(ticks):
            if k % _LOOK_EVERY == 0:
                if cancelled is not None and cancelled():
                    raise Cancelled("the simulation was cancelled")
                if progress is not None:
                    progress(k / ticks)
                now = wall_clock.perf_counter()
                if so_far is not None and now - reported_at >= SO_FAR_INTERVAL:
                    reported_at = now
                    so_far(*self._recorder.so_far(tick, stride))
            result = self._pass(k * tick, result)
            if result is None:
                break
            if self.fall is not None and k * tick > self.fall.time + _AFTER_FALL:
                break
        self.wall_time = wall_clock.perf_counter() - began

    def _pass(self, time: float, last: TickResult | None) -> TickResult | None:
        """One tick from `time`, s, on, after that of `last`; None when the simulation diverged."""
        world, controller, recorder = self._world, self._controller, self._recorder
        state, mujoco_state = world.state(), (world.qpos, world.qvel)
        standing = controller.contacts.carrying
        measurement = self._sensors.measure(time, state, last, standing)
        situation = Situation(time, measurement, controller, world, self.replans)
        for hook in self._hooks:
            hook.before(situation)
        began = wall_clock.perf_counter()
        decision = controller.step(measurement)
        tick_time = wall_clock.perf_counter() - began
        try:
            result = world.advance(decision.command.torque)
        except Diverged as error:
            self.fall = self.fall or Fall(time, str(error))
            unknown = TickResult.unknown(len(decision.foot_target), len(measurement.torque))
            while len(recorder) < LEAST_TICKS:
                recorder.add(state, mujoco_state, decision, tick_time, unknown)
            return None
        recorder.add(state, mujoco_state, decision, tick_time, result)
        for hook in self._hooks:
            hook.after(situation, decision, result)
        if self.fall is None:
            self.fall = fallen(time, state[0], decision.target.R_world_base, result)
        return result

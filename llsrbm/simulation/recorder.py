"""Recording a simulation: cheap while it runs, complete afterwards."""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from llsrbm.control.controller import Tick
from llsrbm.robots import Robot
from llsrbm.robots.feet import foot_contacts
from llsrbm.simulation.world import TickResult

Array = NDArray[np.float64]


class Recorder:
    """Collects ticks; `arrays` has the columns of a `Rollout`, in its order of joints.

    Attributes:
        mass: kg, that is simulated.
    """

    def __init__(self, robot: Robot, trunk_mass_factor: float) -> None:
        """For a robot whose simulated trunk differs from the believed one by a factor."""
        self._robot = robot
        self._model = robot.model.copy()
        trunk = self._model.inertias[1]
        self._model.inertias[1] = pin.Inertia(
            trunk.mass * trunk_mass_factor, trunk.lever, trunk.inertia * trunk_mass_factor
        )
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
        """Instants (K,) s and states (K, 7 + J) of every `stride`-th tick that is recorded.

        Quaternions w, x, y, z; joints in `Robot.joint_names`' order.
        """
        states = self.q[::stride]
        q: Array = np.array(states).reshape(len(states), self._model.nq)
        time: Array = stride * tick * np.arange(len(states), dtype=np.float64)
        return time, np.concatenate([q[:, :3], q[:, 6:7], q[:, 3:6], q[:, 7:]], axis=1)

    def arrays(self, joint_order: NDArray[np.int64]) -> dict[str, Any]:
        """The columns, with joints in the simulator's order.

        Args:
            joint_order: (J,) places in `Robot.joint_names` of the simulator's joints.
        """
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
        middles = [contact.centres.mean(axis=0) for contact in contacts]
        frames = [leg.foot_frame_id for leg in robot.legs]
        q = np.array(self.q)
        count, legs = len(q), len(contacts)
        columns = {
            "com": np.empty((count, 3)),
            "base_position": q[:, :3].copy(),
            "base_quat": q[:, [6, 3, 4, 5]],
            "linear_momentum": np.empty((count, 3)),
            "angular_momentum": np.empty((count, 3)),
            "inertia": np.empty((count, 3, 3)),
            "foot_position": np.empty((count, legs, 3)),
        }
        com, inertia, foot = columns["com"], columns["inertia"], columns["foot_position"]
        linear, angular = columns["linear_momentum"], columns["angular_momentum"]
        for k, (position, velocity) in enumerate(zip(self.q, self.v, strict=True)):
            pin.ccrba(model, data, position, velocity)
            com[k], inertia[k] = data.com[0], data.Ig.inertia
            linear[k], angular[k] = data.hg.linear, data.hg.angular
            pin.forwardKinematics(model, data, position)
            for i, (frame, middle) in enumerate(zip(frames, middles, strict=True)):
                foot[k, i] = pin.updateFramePlacement(model, data, frame).act(middle)
        foot[..., 2] -= [contact.radius for contact in contacts]
        return columns

"""`Episode`: the loop of a simulation: measure, decide, advance, record; and what hooks into it.

A hook acts on the world (`Pushes`) or on the controller, each tick anew. What the
loop does without hooks, with hooks that do nothing it does to the bit.
"""

from __future__ import annotations

import time as wall_clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from llsrbm.control.controller import Measurement, Tick, WholeBodyController
from llsrbm.errors import Cancelled
from llsrbm.motion.replan import Replan
from llsrbm.simulation.recorder import Recorder
from llsrbm.simulation.sensors import Sensors
from llsrbm.simulation.verdict import Fall, fallen
from llsrbm.simulation.world import Diverged, TickResult, World

Array = NDArray[np.float64]

LEAST_TICKS = 2  # of a rollout: where it diverges before, its last known state is repeated
_AFTER_FALL = 0.3  # s that are still shown of a robot that has fallen
_LOOK_EVERY = 20  # ticks between two calls of `cancelled` and `progress`
SO_FAR_INTERVAL = 0.2  # s of wall time between two reports of the motion so far
SO_FAR_RATE = 60.0  # instants/s in them: as browsers draw


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
    """One simulation, from the world as it stands.

    Attributes:
        fall: when and how the robot fell; None so far.
        replans: what hooks have added.
        wall_time: s, of the whole loop.
    """

    def __init__(
        self,
        world: World,
        sensors: Sensors,
        controller: WholeBodyController,
        recorder: Recorder,
        hooks: Sequence[Hook] = (),
    ) -> None:
        """Put together what takes part; hooks act in their order."""
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

        Args:
            ticks: at most.
            cancelled: called every 20 ticks; True ends with `Cancelled`.
            progress: called with the share that is done, 0 to 1.
            so_far: called every `SO_FAR_INTERVAL` with the instants (K,) s and the states
                (K, 7 + J) until now, from the start on, see `Recorder.so_far`.

        Raises:
            Cancelled: on request.
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
        measurement = self._sensors.measure(time, state, last)
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

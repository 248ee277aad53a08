"""A simulated Go2 in front of a player, with a wire on which things go wrong."""

from collections import deque
from functools import cache

import numpy as np

import llsrbm
from llsrbm.installed import assets_directory
from llsrbm.player import Player, make_tier
from llsrbm.player.states import LEAST_RAMP, Check, Stand
from llsrbm.robots import load_robot
from llsrbm.wire.simulated_robot import DirectLink, SimulatedRobot

GO2 = load_robot("go2")


@cache
def stored_plan(name="go2"):
    """A quarter turn that comes with the project."""
    return llsrbm.load(assets_directory() / "plans" / f"{name}.npz")


class Wire(DirectLink):
    """Remembers what is sent, and loses or delays readings from a moment on.

    `silent_from`, `late_from`: s by the robot's clock; `late_by`: s.
    """

    def __init__(self, simulated):
        super().__init__(simulated)
        self.simulated = simulated
        self.sent = []
        self.silent_from = self.late_from = np.inf
        self.late_by = 0.02
        self._held = deque()

    def send(self, command):
        self.sent.append((self.simulated.time, command))
        super().send(command)

    def receive(self, timeout):
        readings = super().receive(timeout)
        now = self.simulated.time
        if readings is not None and now < self.silent_from:
            late = self.late_by if now >= self.late_from else 0.0
            self._held.append((now + late, readings))
        if self._held and self._held[0][0] <= now + 1e-9:
            return self._held.popleft()[1]
        return None


class Stage:
    """A player of a tier and its robot; `jump`: s by the robot's clock when the plan begins."""

    def __init__(self, tier="table", seed=1, *, plan=None, clock=None, **options):
        self.simulated = SimulatedRobot(GO2, seed=seed, **options)
        self.wire = Wire(self.simulated)
        self.tier = make_tier(tier, plan or stored_plan(), GO2)
        self.states = []
        self.player = Player(
            self.tier, self.wire, clock or (lambda: self.simulated.time), self.states.append
        )
        self.at = []  # (s, action), in order
        self.simulated.observers.append(self._act)

    def _act(self, tick):
        while self.at and self.at[0][0] <= self.simulated.time:
            self.at.pop(0)[1]()

    @property
    def jump(self):
        return Check.duration + LEAST_RAMP + Stand.duration

    def run(self):
        return self.player.run()

    @property
    def names(self):
        return [state.name for state in self.states]

    def damped_after(self, fault):
        """S from a fault until brakes alone were sent, for good."""
        stopped = [is_brake(command) for _, command in self.wire.sent]
        first = len(stopped) - stopped[::-1].index(False) if False in stopped else 0
        return self.wire.sent[first][0] - fault


def is_brake(command):
    return not (command.kp.any() or command.tau.any() or command.dq.any()) and command.kd.all()

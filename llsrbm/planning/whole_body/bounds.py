"""Bounds of the whole-body problem's rows: what a request allows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from llsrbm.body.knee_room import knee_room
from llsrbm.mechanics import INSCRIBED
from llsrbm.motion.surroundings import SLOPING
from llsrbm.planning.problem.foot_clearance import clearance_line, edge_range
from llsrbm.planning.problem.placement import retargeted
from llsrbm.planning.whole_body.grid import Grid, Knot
from llsrbm.planning.whole_body.legs import LANDING_UNIT
from llsrbm.planning.whole_body.sizes import EQUALITIES, Sizes
from llsrbm.planning.whole_body.start import Start
from llsrbm.robots.robot import STOP_MARGIN, Robot

Array = NDArray[np.float64]

# m by which a foot in the air may be lower than the line: more meets the ground early.
LOWER_FEET = 0.003
LOWER_CORNERS = 0.03  # m, a sole's corners, as soles may lean; near the ground half of its height
# m from which feet come down with the robot's `touchdown_braking`. Feet that come flat meet the
# ground early, which takes from a twist: eight of Go2's jumps turned 9.4 degrees too little at the
# median when feet could come from 3 cm over a fifth of their swing, 4.3 when braked by 120 m/s2.
BRAKED_FROM = 0.04
HIGHER = 0.01  # m by which a landing is raised to see what that changes
SHANKS = 0.75  # of the distance that feet keep
RISING = 1 / 3  # of the knees' margin before a flight; simulated knees come lower as they land


@dataclass(frozen=True, eq=False)
class RowBounds:
    """The rows of one request."""

    robot: Robot
    grid: Grid
    sizes: Sizes
    start: Start

    def __iter__(self) -> Iterator[tuple[str, int, float, Array, Array]]:
        """The rows of g in their order: name, knot, instant (s), lower and upper bounds."""
        for k, knot in enumerate(self.grid.knots):
            time = float(self.start.time[2 * k])
            if not knot.last:
                yield "continuity", k, time, *(np.zeros((2, self.sizes.states)))
            for name, size in self.sizes.rows(knot).items():
                yield name, k, time, *self._bounds(name, size, knot, 2 * k)
            if knot.last:
                break
            for name, share, size in self.sizes.interval_rows(knot):
                at = time + share * float(self.start.time[2 * k + 2] - time)
                yield name, k, at, *self._bounds(name, size, knot, 2 * k + 1)

    def _bounds(self, name: str, size: int, knot: Knot, half: int) -> tuple[Array, Array]:
        """`half`: of the start's instants, the knot or the middle after it."""
        limits = self.start.task.limits
        reserve = self.robot.file.reserve
        landed = self.grid.phase_at(half) >= self.grid.last_landing
        most = {"speed": limits.speed_share, "torque": limits.torque_share, "drive": 1.0}
        if name in EQUALITIES:
            return np.zeros(size), np.zeros(size)
        if name == "torque" and landed:
            most[name] *= reserve.landing_torque
        if name in most:
            return np.full(size, -most[name]), np.full(size, most[name])
        above = np.full(size, np.inf)
        match name:
            case "durations":
                return self.start.duration_bounds
            case "offset":
                return self.start.offset_bounds
            case "stop":
                lower, upper = self.robot.stops_kept_by(self._stop_margin)
                return lower, upper
            case "edge":
                return self._edge(knot, half)
            case "clearance":
                return self._lowest(knot, half), above
            case "shanks":
                return self._apart(knot, half), above
            case "knees":
                return self._knees(knot, half), above
            case "apart":
                return -self.start.apart.at_zero[half], above
        assert name == "friction"
        carried = reserve.landing_carried if landed else reserve.carried
        steep = np.linalg.norm(self.start.tilt[half // 2][list(knot.standing)], axis=-1)
        # On a slope it is a share of what is left beside standing still.
        left = np.clip(1 - steep / limits.friction, 0.0, 1.0).repeat(size // len(steep))
        return carried * limits.friction * INSCRIBED * left, above

    @property
    def _stop_margin(self) -> float:
        """Another one than the robot's file states, which is that of drafts, is a request's."""
        margin = self.start.task.limits.stop_margin
        own = margin == self.robot.file.limits.stop_margin
        return STOP_MARGIN if own else max(STOP_MARGIN, margin)

    def _swinging(self, knot: Knot, half: int) -> list[int]:
        stands = knot.standing if half % 2 else knot.resting
        return [leg for leg in range(self.sizes.legs) if leg not in stands]

    @cached_property
    def _progress(self) -> tuple[Array, Array, Array]:
        """(2 N + 1, L) share of a foot's swing that is over, (N, L) what a half takes of it, and
        (2 N + 1, L) s that are left of it.
        """
        edges, phases = self.start.phase_start, self.grid.phases
        progress = np.zeros((len(self.start.time), self.sizes.legs))
        step, left = np.zeros((len(phases), self.sizes.legs)), np.zeros_like(progress)
        for leg in range(self.sizes.legs):
            for p, (stands, count) in enumerate(phases):
                if leg in stands:
                    continue
                others = [k for k in range(len(phases)) if leg in phases[k][0]]
                lift = edges[max(k for k in others if k < p) + 1]
                touch = edges[min(k for k in others if k > p)]
                here = (self.grid.shares >= p) & (self.grid.shares <= p + 1)
                progress[here, leg] = (self.start.time[here] - lift) / (touch - lift)
                left[here, leg] = touch - self.start.time[here]
                step[p, leg] = (edges[p + 1] - edges[p]) / (touch - lift) / (2 * count)
        return progress, step, left

    def _lowest(self, knot: Knot, half: int) -> Array:
        """Lowest heights, m, of what each swinging foot touches with."""
        task, phase = self.start.task, self.grid.phase_at(half)
        progress = self._progress[0][[half]]
        before, after = (
            place.feet[:, 2]
            for place in (task.footholds_before(phase), task.footholds_after(phase))
        )
        line = clearance_line(task, phase, progress)[0]
        # Feet of a model for comparison come down as that model has them.
        braking = 0.0 if self.start.keeps_own else task.limits.touchdown_braking
        braked = braking / 2 * self._progress[2][half] ** 2
        coming = after + np.minimum(min(BRAKED_FROM, task.limits.clearance), braked)
        line = np.where(progress[0] > 0.5, np.maximum(line, coming), line)
        if task.obstacle is not None and not task.obstacle.is_gap:  # nothing is above a gap
            line = np.maximum(line, self.start.place[half, :, 2])
        line = line + self._sloping(half, phase)
        # How far it is above the lower of the places that it comes from and goes to.
        above = np.maximum(line - np.minimum(before, after), 0.0)
        lean = np.minimum(LOWER_CORNERS, LOWER_FEET + above / 2)
        found = []
        for leg in self._swinging(knot, half):
            found.append([line[leg] - LOWER_FEET])
            if self.sizes.corners > 1:
                found.append([line[leg] - lean[leg]] * self.sizes.corners)
        return np.concatenate(found)

    def rises(self) -> Array:
        """(N + 1, 2, L, H) by how much more feet clear, at a knot and in the middle after it, where
        what they land on is higher by one.
        """
        task = self.start.task
        jump = replace(task.jump, height=task.jump.height + HIGHER)
        above = replace(self, start=replace(self.start, task=retargeted(task, jump)))
        found = np.zeros((len(self.grid.knots), 2, self.sizes.legs, self.sizes.heights))
        for half in range(1, 2 * self.grid.intervals):
            knot = self.grid.knots[half // 2]
            swinging = self._swinging(knot, half)
            if swinging:
                raised = above._lowest(knot, half) - self._lowest(knot, half)
                each = raised.reshape(len(swinging), -1) / HIGHER
                found[half // 2, half % 2, swinging] = each
        return found

    def _sloping(self, half: int, phase: int) -> Array:
        """(L,) m that surfaces rise from where feet stood, or will, to below the start's feet.

        Rows leave that out. Beyond a surface's block there is no ground that rises.
        """
        task, knot = self.start.task, half // 2
        stood, lands = task.footholds_before(phase), task.footholds_after(phase)
        tilt, way = self.start.tilt[knot], self.start.place[2 * knot, :, :2]
        landing = (tilt == lands.tilt).all(axis=1) & (self._progress[0][half] > 0.5)
        place = np.where(landing[:, None], lands.feet[:, :2], stood.feet[:, :2])
        most = SLOPING * np.linalg.norm(tilt, axis=1)
        return np.clip((tilt * (way - place)).sum(axis=1), -most, most)

    def _edge(self, knot: Knot, half: int) -> tuple[Array, Array]:
        phase, swinging = self.grid.phase_at(half), self._swinging(knot, half)
        progress, step, _ = self._progress
        low, high = edge_range(self.start.task, phase, progress[[half]], step[[phase]])
        low, high = (
            np.repeat(bound[0, swinging], self.sizes.corners) / LANDING_UNIT
            for bound in (low, high)
        )
        return low, high

    def _apart(self, knot: Knot, half: int) -> Array:
        """Squared distances of feet and of shanks."""
        stands = knot.standing if half % 2 else knot.resting
        distance = self.start.task.limits.feet_apart / LANDING_UNIT
        each = [distance**2, (SHANKS * distance) ** 2][: 1 + self.sizes.knees]
        return np.tile(each, len(self.sizes.pairs_with(stands)))

    def _knees(self, knot: Knot, half: int) -> Array:
        margin = self.start.task.limits.knee_margin
        margin *= 1.0 if self.grid.landed[half] else RISING
        stands = knot.standing if half % 2 else knot.resting
        return np.full(len(stands), (knee_room(self.robot) + margin) / LANDING_UNIT)

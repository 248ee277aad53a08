"""The row of the whole-body problem that stops a jump from growing, as words that refusals use.

Towards the edge of what can be done the multipliers of the rows that stop it grow without bounds,
while those of rows that a motion merely leans on, such as how feet are put down, stay as they are:
the row is the one whose multiplier has grown most since an easier jump of the same kind.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from llsrbm.arrays import Array
from llsrbm.body.peak_loads import event_beside, when_in_words
from llsrbm.errors import JointNeed, Stop
from llsrbm.ocp.horizon import Iterate
from llsrbm.planning.problem.limits import limits_in
from llsrbm.planning.problem.violations import SCALES
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.legs import LANDING_UNIT
from llsrbm.planning.whole_body.motion import Motion
from llsrbm.planning.whole_body.rows import DRIVE_SLOPE
from llsrbm.planning.whole_body.sizes import EQUALITIES

_BASE = 6  # velocities of the floating base
# What of each kind of rows is as much as one of a share: multipliers are per unit of the rows.
_LENGTH = SCALES["m"]
_SCALES = {
    **dict.fromkeys(("torque", "drive", "speed", "friction"), SCALES["1"]),
    **dict.fromkeys(("clearance", "apart"), _LENGTH),
    **dict.fromkeys(("edge", "shanks", "knees"), _LENGTH / LANDING_UNIT),
    "stop": SCALES["rad"],
    "durations": SCALES["s"],
}
_SIDES = {"max": "long", "min": "short"}
_LIMITS = {"torque": "torque_share", "drive": "torque_share", "speed": "speed_share"}


class _Row(NamedTuple):
    name: str
    knot: int
    time: float  # s
    place: int  # among the rows of that name there
    at_upper: bool  # which of its bounds it leans on
    bound: float  # that one


@dataclass(frozen=True, eq=False)
class Edge:
    """A solution at, or near, the edge of what can be done.

    Attributes:
        rows: of its problem.
        solution: the solver's; before: that of an easier jump on the same grid, None: none.
    """

    rows: RowBounds
    solution: Iterate
    before: Iterate | None = None

    def stop(self) -> Stop | None:
        """The limit that it leans on; None: no row has a multiplier that has grown."""
        row = self._row()
        if row is None:
            return None
        if row.name == "friction":
            return self._of_limit(row, "friction")
        if row.name == "durations":
            of = self.rows.start.task.schedule[row.place]
            end = "max" if row.at_upper else "min"
            if isinstance(of.time, str):
                return self._of_limit(row, f"{of.time}_{end}")
            return self._plain(row, f"{of.name} is as {_SIDES[end]} as it may")
        need = self._need(row)
        if need is None:
            return self._plain(row, self._geometry(row))
        where = self._phase(row), row.time, 0.0
        return Stop(row.name, *where, need.unit, _LIMITS.get(row.name), demand=need)

    def _row(self) -> _Row | None:
        before = 0.0 if self.before is None else np.abs(self.before.multipliers)
        grown = np.abs(self.solution.multipliers) - before
        most, found, at = 0.0, None, 0
        for name, knot, time, low, high in self.rows:
            own = slice(at, at + len(low))
            at = own.stop
            if name in EQUALITIES or name not in _SCALES or not len(low):
                continue
            i = int(np.argmax(grown[own]))
            amount = _SCALES[name] * grown[own][i]
            if amount > most:
                # A solver's multipliers are positive at upper bounds.
                upper = bool(self.solution.multipliers[own][i] > 0)
                most, bound = amount, float((high if upper else low)[i])
                found = _Row(name, knot, time, i, upper, bound)
        return found

    def _need(self, row: _Row) -> JointNeed | None:
        """The joint that is at a limit, and which; None: the row is not of a drive or a stop."""
        if row.name not in ("torque", "drive", "speed", "stop"):
            return None
        robot, joint = self.rows.robot, row.place
        name = robot.joint_names[joint]
        force, angle = ("N", "m") if name in robot.sliding_joints else ("Nm", "rad")
        has, unit, when = abs(row.bound), angle, self._when(row)
        if row.name == "torque":
            has, unit = has * robot.torque_limit[joint], force
        elif row.name == "speed":
            has, unit = has * robot.speed_limit[joint], f"{angle}/s"
        elif row.name == "stop":
            has = row.bound
        else:
            speed, torque = self._drive(row)
            has, unit, when = speed, f"{angle}/s", f"with {torque:.3g} {force} {when}"
        return JointNeed(name, float(has), float(has), unit, when)

    def _drive(self, row: _Row) -> tuple[float, float]:
        """Sizes of speed (rad/s, m/s) and torque (Nm, N) of a joint whose torque falls."""
        rows, limits = self.rows, self.rows.start.task.limits
        motion = Motion.of(self.solution.variables, rows.grid, rows.sizes)
        first, last = rows.start.time[2 * row.knot], rows.start.time[2 * row.knot + 2]
        share = np.array([(row.time - first) / (last - first)])
        at = motion.within(np.array([row.knot]), share)
        speed = float(at.v[0, _BASE + row.place])
        left = row.bound - speed / (limits.speed_share * rows.robot.speed_limit[row.place])
        torque = left * limits.torque_share / DRIVE_SLOPE * rows.robot.torque_limit[row.place]
        return abs(speed), abs(float(torque))

    def _geometry(self, row: _Row) -> str:
        """Which parts come as near to what they keep away from as they may."""
        knot, names, sizes = self.rows.grid.knots[row.knot], self._legs, self.rows.sizes
        of_knot = row.time <= self.rows.start.time[2 * row.knot]
        stands = knot.resting if of_knot else knot.standing
        swings = [leg for leg in range(sizes.legs) if leg not in stands]
        match row.name:
            case "clearance":
                leg = names[swings[row.place // sizes.heights]]
                return f"the foot of {leg} flies as low as it may"
            case "edge":
                leg = names[swings[row.place // sizes.corners]]
                return f"the foot of {leg} comes as near to an edge that it crosses as it may"
            case "knees":
                leg = names[stands[row.place]]
                return f"the knee of {leg} comes as near to the ground as it may"
            case "shanks":
                one, other = sizes.pairs_with(stands)[row.place // (1 + sizes.knees)]
                return f"{names[one]} and {names[other]} come as near to each other as they may"
        return self._near_links(row)

    def _near_links(self, row: _Row) -> str:
        # Distances between links do not change with the base's place; those to solids do.
        half = 2 * row.knot + int(row.time > self.rows.start.time[2 * row.knot])
        slope: Array = self.rows.start.apart.slope[half, row.place]
        joints = np.flatnonzero(slope[_BASE:])
        legs = zip(self._legs, self.rows.robot.leg_joint_index, strict=True)
        near = [name for name, own in legs if np.isin(joints, own).any()]
        if len(near) > 1:
            return f"{' and '.join(near)} come as near to each other as they may"
        if slope[:_BASE].any():
            what = f"leg {near[0]}" if near else "the trunk"
            return f"{what} comes as near to what is stood on as it may"
        what = f"leg {near[0]}" if near else "an arm"
        return f"{what} comes as near to another link as it may"

    @property
    def _legs(self) -> list[str]:
        return [leg.name for leg in self.rows.robot.legs]

    def _of_limit(self, row: _Row, name: str) -> Stop:
        limit, value = limits_in(self.rows.start.task)[name]
        where = self._phase(row), row.time, 0.0
        return Stop(row.name, *where, limit.unit, name, limit.title, value, value)

    def _plain(self, row: _Row, title: str) -> Stop:
        where = self._phase(row), row.time, 0.0
        return Stop(row.name, *where, "1", title=title)

    def _interval(self, row: _Row) -> int:
        return min(row.knot, self.rows.grid.intervals - 1)

    def _phase(self, row: _Row) -> str:
        schedule = self.rows.start.task.schedule
        return schedule[int(self.rows.grid.phase[self._interval(row)])].name

    def _when(self, row: _Row) -> str:
        schedule, grid = self.rows.start.task.schedule, self.rows.grid
        event = event_beside(schedule.stands[grid.phase], self._interval(row))
        return when_in_words(self._phase(row), row.time, event)

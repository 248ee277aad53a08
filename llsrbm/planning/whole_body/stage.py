"""A knot of the whole-body problem, and the interval after it, as expressions.

Dynamics are inverse: accelerations and contact forces are controls, torques follow, and the six
rows of the base, which no drive pushes, have to be zero at the nodes. The durations of the phases
are states that do not change.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from llsrbm.mechanics import GRAVITY, INSCRIBED
from llsrbm.models.rigid_bodies import Effort, RigidBodies
from llsrbm.ocp.horizon import Row, StageExpressions
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.whole_body import costs, legs
from llsrbm.planning.whole_body.grid import Knot
from llsrbm.planning.whole_body.interval import Interval, Pose, turned
from llsrbm.planning.whole_body.sizes import (
    EQUALITIES,
    NODES,
    WEIGHTS,
    Sizes,
    line,
    parts,
    units,
)

MOMENT_ARM = 0.2  # m: moments count as forces with that arm
DRIVE_SLOPE = 0.3  # share of the speed limit over which the torque falls to zero


def stage_expressions(bodies: RigidBodies, knot: Knot, sizes: Sizes) -> StageExpressions:
    """A knot's stage."""
    return _Stage(bodies, knot, sizes).expressions()


class _Stage:
    def __init__(self, bodies: RigidBodies, knot: Knot, sizes: Sizes) -> None:
        self.bodies, self.knot, self.robot, self.sizes = bodies, knot, bodies.robot, sizes
        self.z = ca.SX.sym("z", sizes.states + sizes.controls(knot))
        self.local = ca.SX.sym("own", sum(sizes.own.values()))
        self.near = parts(self.local, sizes.own)
        self.mark = Lifting(self.z)
        values = self.z * ca.DM(sizes.unit(knot))
        self.x = parts(values[: sizes.states], sizes.state)
        of_node = sizes.node(len(knot.standing))
        controls = np.split(np.arange(sizes.states, values.numel()), len(NODES))
        self.u = [] if knot.last else [parts(values[list(at)], of_node) for at in controls]
        step = self.near["step"] * ca.dot(self.near["phase"], self.x["durations"])
        self.step = self.mark(step)
        self.weight = dict(zip(WEIGHTS, ca.vertsplit(self.near["weights"]), strict=True))
        self.over = Interval(self.x, self.u, self.step, self.mark)
        self.pose = Pose.of(self.x, self.mark)

    def expressions(self) -> StageExpressions:
        """Cost, rows and the state at the next knot."""
        rows = self._knot_rows()
        cost = costs.of_knot(self.pose, self.near, self.weight, self.robot)
        expected = list(self.sizes.rows(self.knot).items())
        if self.knot.first:
            cost += costs.of_durations(self.x["durations"], self.weight)
        if self.u:
            over, more = self._over_interval()
            rows, cost = rows + over, cost + more
            of_interval = self.sizes.interval_rows(self.knot)
            expected += [(name, size) for name, _, size in of_interval]
        assert [(name, values.numel()) for name, values in rows] == expected
        return StageExpressions(
            variables=self.z,
            states=self.sizes.states,
            shared=ca.SX(0, 1),
            local=self.local,
            cost=costs.SCALE * cost,
            rows=tuple(Row(values, name in EQUALITIES) for name, values in rows),
            next_state=self._next_state() if self.u else None,
            lift=self.mark,
            exact=False,  # the cost alone: twice the iterations, a third of the time to build
        )

    def _next_state(self) -> Any:
        state = {**self.over.moved(1.0), "durations": self.x["durations"]}
        return ca.vertcat(*state.values()) / ca.DM(units(self.sizes.state, 1.0))

    def _knot_rows(self) -> list[tuple[str, Any]]:
        near, x = self.near, self.x
        if self.knot.first:
            off = [x[name] - near[name] for name in self.sizes.moving]
            return [("start", ca.vertcat(*off)), ("durations", x["durations"])]
        found = self._of_posture(self.pose, self.knot.resting, "apart")
        goal = [x["position"] - near["position"], turned(x["quat"], near["quat"])]
        goal += [x[name] - near[name] for name in ("velocity", "omega")]
        found["goal"] = ca.vertcat(*goal)
        return [(name, found[name]) for name in self.sizes.rows(self.knot)]

    def _ground(self, leg: int) -> legs.Ground:
        place, heading, towards = (self.near[n] for n in ("place", "heading", "towards"))
        pair = slice(2 * leg, 2 * leg + 2)
        return legs.Ground(place[3 * leg : 3 * leg + 3], heading[pair], towards[pair])

    def _of_posture(self, pose: Pose, standing: tuple[int, ...], apart: str) -> dict[str, Any]:
        """Rows of a pose in which these legs stand; `apart`: the parameters of distances."""
        found = legs.legs_of(self.bodies, pose, self.mark)
        grounds = [self._ground(leg) for leg in range(self.sizes.legs)]
        stand = [(found[i], grounds[i]) for i in standing]
        swing = [(found[i], grounds[i]) for i in range(self.sizes.legs) if i not in standing]
        pairs = self.sizes.pairs_with(standing)
        shanks = [legs.squared_distances(found[i], found[j]) for i, j in pairs]
        slopes = ca.reshape(self.near[apart], self.sizes.posture, self.sizes.near)
        place = pose.position, turned(pose.quat, self.near["quat"]), pose.joint_position
        return {
            "stop": pose.joint_position,
            "speed": pose.joint_velocity / ca.DM(self.robot.speed_limit),
            "rest": ca.vertcat(*(legs.rest(*each) for each in stand)),
            "landing": ca.vertcat(*(legs.landing(found[i], grounds[i]) for i in self.knot.landing)),
            "clearance": ca.vertcat(*(legs.heights(leg) for leg, _ in swing)),
            "edge": ca.vertcat(*(legs.along(*each) for each in swing)),
            "shanks": ca.vertcat(*(d for each in shanks for d in each)),
            "knees": ca.vertcat(*(legs.knee_height(*each) for each in stand * self.sizes.knees)),
            # Distances but for constants, which are in the bounds.
            "apart": slopes.T @ ca.vertcat(*place),
        }

    def _over_interval(self) -> tuple[list[tuple[str, Any]], Any]:
        """Rows and cost of the interval."""
        sizes, limit = self.sizes, ca.DM(self.robot.torque_limit)
        efforts = [self._effort(node) for node in range(len(NODES))]
        loads = [self.mark(effort.torque / limit) for effort in efforts]
        torque_share, speed_share, mu = ca.vertsplit(self.near["limits"])
        middle = self._of_posture(self.over.at(0.5), self.knot.standing, "apart_in_middle")
        found: list[tuple[str, Any]] = []
        for name, share, _ in sizes.interval_rows(self.knot):
            load = sum(float(w) * values for w, values in zip(line(share)[0], loads, strict=True))
            if name == "dynamics":
                effort = efforts[NODES.index(share)]
                balance = ca.vertcat(effort.force, effort.moment / MOMENT_ARM)
                found.append((name, balance / sizes.weight))
            elif name == "torque":
                found.append((name, load))
            elif name == "drive":
                velocity = self.over.moved(share)["joint_velocity"]
                speed = velocity / ca.DM(self.robot.speed_limit)
                found.append((name, DRIVE_SLOPE * load / torque_share + speed / speed_share))
            elif name == "friction":
                sides = _pyramid(self.over.mixed("force", share), mu * INSCRIBED)
                found.append((name, sides / sizes.unit_force))
            else:
                found.append((name, middle[name]))
        standing = len(self.knot.standing)
        own = self.weight, sizes, self.robot
        return found, costs.of_interval(self.u, loads, standing, *own)

    def _effort(self, node: int) -> Effort:
        """Inverse dynamics at a node."""
        u, mark, pose = self.u[node], self.mark, self.over.at(NODES[node])
        pushes = ca.reshape(u["force"], 3, -1)
        forces: dict[int, list[Any]] = {}
        for n, leg in enumerate(self.knot.standing):
            own = range(self.sizes.corners * n, self.sizes.corners * (n + 1))
            forces[leg] = [mark(ca.mtimes(pose.R.T, pushes[:, k])) for k in own]
        return self.bodies.inverse_dynamics(
            pose.joint_position,
            pose.joint_velocity,
            u["joint_acceleration"],
            pose.omega,
            u["omega_rate"],
            mark(ca.mtimes(pose.R.T, u["acceleration"] + ca.DM([0, 0, GRAVITY]))),
            pose.R[2, :].T,
            forces,
            mark,
        )


def _pyramid(force: Any, slope: Any) -> Any:
    """(4 n, 1) what is left of friction to four sides, of n forces (3 n, 1)."""
    sides = []
    for k in range(0, force.numel(), 3):
        room = slope * force[k + 2]
        sides += [room - force[k], room + force[k], room - force[k + 1], room + force[k + 1]]
    return ca.vertcat(*sides)

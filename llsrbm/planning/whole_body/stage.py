"""A knot of the second stage, and the interval after it, as expressions.

Dynamics are inverse: accelerations and contact forces are controls, torques follow, and the six
rows of the base, which no drive pushes, have to be zero at the nodes. Standing feet do not move:
their velocity makes up for what they have drifted; only where they land their place is a row, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from llsrbm.mechanics import GRAVITY, INSCRIBED
from llsrbm.models.rigid_bodies import Effort, RigidBodies, cross
from llsrbm.ocp.horizon import Row, StageExpressions
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.problem.rotations import quat_exp, quat_product, rotation_matrix
from llsrbm.planning.whole_body.grid import (
    EQUALITIES,
    NODES,
    Knot,
    Sizes,
    line,
    parts,
    units,
)

SCALE = 1e-3  # of the cost
# What a variable may differ from the plan's for a cost of 1; joint accelerations from zero.
WIDTHS = {
    "position": 0.05,
    "attitude": 0.1,
    "joint_position": 0.3,
    "velocity": 0.5,
    "omega": 1.0,
    "joint_velocity": 3.0,
    "acceleration": 10.0,
    "omega_rate": 30.0,
    "joint_acceleration": 200.0,
}
# By what a joint's acceleration may differ between the nodes for a cost of 1: equations of motion
# hold at these, and elsewhere the less the straighter joints move.
STEEP = 100.0
TORQUE = 0.2  # cost of the whole torque of a drive
DRIFT = 10.0  # 1/s: by how much of it a standing foot's drift falls
MOMENT_ARM = 0.2  # m: moments count as forces with that arm
TURN_UNIT = 5.0  # of rows of soles that turn
LANDING_UNIT = 0.1  # m, of rows of places
DRIVE_SLOPE = 0.3  # share of the speed limit over which the torque falls to zero


def stage_expressions(bodies: RigidBodies, knot: Knot) -> StageExpressions:
    """A knot's stage."""
    return _Stage(bodies, knot).expressions()


class _Foot(NamedTuple):
    """A foot: height and upward direction of its sole, and by how much it is not as it stands."""

    height: Any
    up: Any  # (3,)
    off: Any  # (3,) m
    tilt: list[Any]  # of soles, `_Stage._tilt`
    rest: list[Any]  # rows that are zero where it stands


class _Stage:
    def __init__(self, bodies: RigidBodies, knot: Knot) -> None:
        self.bodies, self.knot, self.robot = bodies, knot, bodies.robot
        self.sizes = sizes = Sizes.of(self.robot)
        self.z = ca.SX.sym("z", sizes.states + sizes.controls(knot))
        self.local = ca.SX.sym("own", sum(sizes.own.values()))
        self.near = parts(self.local, sizes.own)
        self.mark = Lifting(self.z)
        of_node = sizes.node(len(knot.standing))
        unit = np.concatenate(
            [units(sizes.state, 1.0)]
            + (len(NODES) * [units(of_node, sizes.unit_force)] if not knot.last else [])
        )
        values = self.z * ca.DM(unit)
        self.x = parts(values[: sizes.states], sizes.state)
        controls = np.split(np.arange(sizes.states, len(unit)), len(NODES))
        self.u = [] if knot.last else [parts(values[list(at)], of_node) for at in controls]
        self.step = self.near["step"]
        self.R = self.mark(rotation_matrix(self.x["quat"]))

    def expressions(self) -> StageExpressions:
        """Cost, rows and the state at the next knot."""
        rows, cost = [] if self.knot.first else self._knot_rows(), self._knot_cost()
        if self.knot.first:
            rows = [("start", ca.vertcat(*((v - self.near[k]) for k, v in self.x.items())))]
        expected = list(self.sizes.rows(self.knot).items())
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
            cost=SCALE * cost,
            rows=tuple(Row(values, name in EQUALITIES) for name, values in rows),
            next_state=None if self.knot.last else self._next_state(),
            lift=self.mark,
            exact=False,
        )

    # ---- at the knot

    @property
    def _turned(self) -> Any:
        """(3,) rad, about, from the plan's attitude."""
        return self._turned_to(self.x["quat"])

    def _turned_to(self, quat: Any) -> Any:
        q = self.near["quat"]
        return 2 * quat_product(ca.vertcat(q[0], -q[1:]), quat)[1:]

    def _knot_cost(self) -> Any:
        off = {name: self.x[name] - self.near[name] for name in self.x if name != "quat"}
        off["attitude"] = self._turned
        # A knot stands for two of the plan's, as its interval does.
        return len(NODES) * sum(ca.sumsqr(v / WIDTHS[name]) for name, v in off.items())

    def _knot_rows(self) -> list[tuple[str, Any]]:
        knot, sizes, x = self.knot, self.sizes, self.x
        feet = self._feet(self.R, x)
        landing, clearance = [], []
        for leg, foot in enumerate(feet):
            if leg in knot.landing:
                landing += [foot.off / LANDING_UNIT, *foot.tilt]
            if leg not in knot.resting:
                clearance.append(foot.height)
                clearance += [foot.height + ca.dot(foot.up, ca.DM(c)) for c in self._corners]
        goal = [x["position"] - self.near["position"], self._turned]
        goal += [x[name] - self.near[name] for name in ("velocity", "omega")]
        found = {
            "stop": [x["joint_position"]],
            "speed": [x["joint_velocity"] / ca.DM(self.robot.speed_limit)],
            "rest": [row for leg in knot.resting for row in feet[leg].rest],
            "landing": landing,
            "clearance": clearance,
            "apart": [self._apart("apart", x["position"], self._turned, x["joint_position"])],
            "goal": goal,
        }
        return [(name, ca.vertcat(*found[name])) for name in sizes.rows(knot)]

    def _apart(self, name: str, position: Any, turned: Any, joints: Any) -> Any:
        """Distances but for constants, which are in the bounds."""
        slopes = ca.reshape(self.near[name], self.sizes.posture, self.sizes.near)
        return slopes.T @ ca.vertcat(position, turned, joints)

    @property
    def _corners(self) -> Any:
        """(c, 3) m of soles; none of point feet."""
        return self.robot.corners if self.sizes.corners > 1 else ()

    def _feet(self, R: Any, x: Mapping[str, Any]) -> list[_Foot]:
        """All feet with the base's attitude (3, 3) and a state."""
        velocity = self.mark(ca.mtimes(R.T, x["velocity"]))
        seen = self.bodies.feet(x["joint_position"], x["joint_velocity"], x["omega"], velocity)
        found, lift = [], ca.DM([0, 0, self.robot.foot_lift])
        for leg, foot in enumerate(seen):
            place = x["position"] + ca.mtimes(R, foot.position) - lift
            off = place - self.near["place"][3 * leg : 3 * leg + 3]
            rest, tilt = [ca.mtimes(R, foot.velocity) + DRIFT * off], []
            sole = ca.mtimes(R, foot.rotation)
            if self.sizes.corners > 1:
                tilt = [self._tilt(leg, sole)]
                rest.append((ca.mtimes(R, foot.omega) + DRIFT * tilt[0]) / TURN_UNIT)
            found.append(_Foot(place[2], sole[2, :].T, off, tilt, rest))
        return found

    def _rest_within(self, share: float) -> list[Any]:
        """Rows of the standing feet at a share of the interval."""
        x = {
            "position": self._moved("position", "velocity", "acceleration", share),
            "joint_position": self._moved(*_JOINTS, share),
            "velocity": self._sped("velocity", "acceleration", share),
            "omega": self._sped("omega", "omega_rate", share),
            "joint_velocity": self._sped(*_JOINTS[1:], share),
        }
        x = {name: self.mark(values) for name, values in x.items()}
        feet = self._feet(self.mark(rotation_matrix(self._attitude(share))), x)
        return [row for leg in self.knot.standing for row in feet[leg].rest]

    def _apart_within(self, share: float) -> Any:
        position = self._moved("position", "velocity", "acceleration", share)
        turned = self._turned_to(self._attitude(share))
        return self._apart("apart_in_middle", position, turned, self._moved(*_JOINTS, share))

    def _tilt(self, leg: int, sole: Any) -> Any:
        """(3,) rad, about: by how much a sole (3, 3) is not level, and does not look ahead."""
        ahead = self.near["heading"][2 * leg : 2 * leg + 2]
        return ca.vertcat(sole[2, 1], -sole[2, 0], sole[1, 0] * ahead[0] - sole[0, 0] * ahead[1])

    # ---- over the interval

    def _mixed(self, name: str, weights: Any) -> Any:
        """A control of this name, or one of its integrals, with `line`'s weights."""
        return sum(float(w) * u[name] for w, u in zip(weights, self.u, strict=True))

    def _moved(self, position: str, velocity: str, acceleration: str, share: float) -> Any:
        twice = self._mixed(acceleration, line(share)[2])
        return self.x[position] + self.step * share * self.x[velocity] + self.step**2 * twice

    def _sped(self, velocity: str, acceleration: str, share: float) -> Any:
        return self.x[velocity] + self.step * self._mixed(acceleration, line(share)[1])

    def _attitude(self, share: float) -> Any:
        """The quaternion at a share of the interval."""
        turn = self.step * share * self.x["omega"]
        turn += self.step**2 * self._mixed("omega_rate", line(share)[2])
        # Turns in different directions do not add up: Magnus' second term, of the mean rate.
        mean = self._mixed("omega_rate", line(share)[1]) / share
        turn += (self.step * share) ** 3 / 12 * cross(self.x["omega"], mean)
        return quat_product(self.x["quat"], quat_exp(turn))

    def _speed(self, share: float) -> Any:
        """Speeds of the joints, as shares of their drives'."""
        return self._sped(*_JOINTS[1:], share) / ca.DM(self.robot.speed_limit)

    def _next_state(self) -> Any:
        state = {
            "position": self._moved("position", "velocity", "acceleration", 1.0),
            "quat": self._attitude(1.0),
            "joint_position": self._moved(*_JOINTS, 1.0),
            "velocity": self._sped("velocity", "acceleration", 1.0),
            "omega": self._sped("omega", "omega_rate", 1.0),
            "joint_velocity": self._sped(*_JOINTS[1:], 1.0),
        }
        return ca.vertcat(*state.values()) / ca.DM(units(self.sizes.state, 1.0))

    def _over_interval(self) -> tuple[list[tuple[str, Any]], Any]:
        """Rows and cost of the interval."""
        efforts, costs = zip(*(self._at_node(node) for node in range(len(NODES))), strict=True)
        loads = [self.mark(effort.torque / ca.DM(self.robot.torque_limit)) for effort in efforts]
        torque_share, speed_share, mu = ca.vertsplit(self.near["limits"])
        found: list[tuple[str, Any]] = []
        for name, share, _ in self.sizes.interval_rows(self.knot):
            load = sum(float(w) * values for w, values in zip(line(share)[0], loads, strict=True))
            if name == "dynamics":
                effort = efforts[NODES.index(share)]
                balance = ca.vertcat(effort.force, effort.moment / MOMENT_ARM)
                found.append((name, balance / self.sizes.weight))
            elif name == "stop":
                found.append((name, self._moved(*_JOINTS, share)))
            elif name == "apart":
                found.append((name, self._apart_within(share)))
            elif name == "rest":
                found.append((name, ca.vertcat(*self._rest_within(share))))
            elif name == "torque":
                found.append((name, load))
            elif name == "speed":
                found.append((name, self._speed(share)))
            elif name == "drive":
                speed = self._speed(share)
                found.append((name, DRIVE_SLOPE * load / torque_share + speed / speed_share))
            else:
                force = self._mixed("force", line(share)[0])
                found.append((name, _pyramid(force, mu * INSCRIBED) / self.sizes.unit_force))
        steep = self.u[1]["joint_acceleration"] - self.u[0]["joint_acceleration"]
        cost = sum(costs) + ca.sumsqr(steep / STEEP) + TORQUE * sum(map(ca.sumsqr, loads))
        return found, cost

    def _at_node(self, node: int) -> tuple[Effort, Any]:
        """The effort at one of the nodes, and the cost of motion and forces there."""
        sizes, u, mark, share = self.sizes, self.u[node], self.mark, NODES[node]
        near = {name: self.near[f"{name}_{node}"] for name in (*sizes.motion, "force")}
        R = mark(rotation_matrix(self._attitude(share)))
        pushes = ca.reshape(u["force"], 3, -1)
        planned = ca.reshape(near["force"], 3, -1)
        forces: dict[int, list[Any]] = {}
        cost = 0
        for n, leg in enumerate(self.knot.standing):
            own, all_ = (np.arange(sizes.corners) + sizes.corners * k for k in (n, leg))
            forces[leg] = [mark(ca.mtimes(R.T, pushes[:, int(k)])) for k in own]
            off = pushes[:, own.tolist()] - planned[:, all_.tolist()]
            cost += ca.sumsqr(off / sizes.unit_force)
        for name in ("acceleration", "omega_rate"):
            cost += ca.sumsqr((u[name] - near[name]) / WIDTHS[name])
        cost += ca.sumsqr(u["joint_acceleration"] / WIDTHS["joint_acceleration"])
        effort = self.bodies.inverse_dynamics(
            mark(self._moved(*_JOINTS, share)),
            mark(self._sped(*_JOINTS[1:], share)),
            u["joint_acceleration"],
            mark(self._sped("omega", "omega_rate", share)),
            u["omega_rate"],
            mark(ca.mtimes(R.T, u["acceleration"] + ca.DM([0, 0, GRAVITY]))),
            R[2, :].T,
            forces,
            mark,
        )
        return effort, cost


_JOINTS = ("joint_position", "joint_velocity", "joint_acceleration")


def _pyramid(force: Any, slope: Any) -> Any:
    """(4 n, 1) what is left of friction to four sides, of n forces (3 n, 1)."""
    sides = []
    for k in range(0, force.numel(), 3):
        room = slope * force[k + 2]
        sides += [room - force[k], room + force[k], room - force[k + 1], room + force[k + 1]]
    return ca.vertcat(*sides)

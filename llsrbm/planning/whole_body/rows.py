"""Cost and rows of a knot and of the interval after it, of what its functions gave.

Dynamics are inverse: accelerations and contact forces are controls, torques follow, and the six
rows of the base, which no drive pushes, have to be zero at the nodes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from llsrbm.mechanics import INSCRIBED
from llsrbm.ocp.horizon import Row
from llsrbm.planning.problem.rotations import on_surface, quat_product
from llsrbm.planning.whole_body import costs, legs
from llsrbm.planning.whole_body.chain import split
from llsrbm.planning.whole_body.grid import Knot
from llsrbm.planning.whole_body.interval import turned
from llsrbm.planning.whole_body.sizes import EQUALITIES, NODES, WEIGHTS, Sizes, line

MOMENT_ARM = 0.2  # m: moments count as forces with that arm
DRIVE_SLOPE = 0.3  # share of the speed limit over which the torque falls to zero


@dataclass(frozen=True, eq=False)
class Stage:
    """A stage's quantities as symbols, and what it makes of them.

    Attributes:
        state: name -> symbols, SI units; forces in `nodes` are in units of `Sizes.unit_force`.
        nodes: of each node name -> controls; none at the end.
        middle: name -> symbols of the state in the middle; later: joint velocities at the end.
        poses, poses_in_middle: what `leg_pose` gave of each leg.
        efforts: of each node, what `trunk_effort` and each limb's `limb_effort` gave.
        numbers: name -> the stage's parameters: `Sizes.robot` and `Sizes.own`.
    """

    knot: Knot
    sizes: Sizes
    state: Mapping[str, Any]
    nodes: tuple[Mapping[str, Any], ...]
    middle: Mapping[str, Any]
    later: Any
    poses: tuple[Any, ...]
    poses_in_middle: tuple[Any, ...]
    efforts: tuple[tuple[Any, ...], ...]
    numbers: Mapping[str, Any]

    @cached_property
    def weight(self) -> dict[str, Any]:
        """Each cost's weight."""
        return dict(zip(WEIGHTS, ca.vertsplit(self.numbers["weights"]), strict=True))

    def cost(self) -> Any:
        """The stage's cost."""
        found = costs.of_knot(self.state, self.numbers, self.weight, self.sizes)
        if self.knot.first:
            found += costs.of_durations(self.state["durations"], self.weight)
            wanted, price = self.numbers["wanted"], self.numbers["price"]
            found += costs.of_offset(self.state["offset"], wanted, price)
        if self.nodes:
            standing = len(self.knot.standing)
            found += costs.of_interval(self.nodes, self.loads, standing, self.weight, self.sizes)
        return costs.SCALE * found

    def rows(self) -> tuple[Row, ...]:
        """The stage's rows, in the order of `Sizes.rows` and `Sizes.interval_rows`."""
        found = self._knot_rows()
        expected = list(self.sizes.rows(self.knot).items())
        if self.nodes:
            found += self._interval_rows()
            expected += [(name, size) for name, _, size in self.sizes.interval_rows(self.knot)]
        assert [(name, values.numel()) for name, values in found] == expected
        return tuple(Row(values, name in EQUALITIES) for name, values in found)

    @cached_property
    def loads(self) -> list[Any]:
        """(J,) torques at each node, as shares of the drives'."""
        found = []
        for _, *limbs in self.efforts:
            torque = ca.SX(self.sizes.joints, 1)
            for effort, joints in zip(limbs, self.sizes.limb_joints, strict=True):
                torque[list(joints)] = effort[6:]
            found.append(torque / self.numbers["torque_limit"])
        return found

    def _knot_rows(self) -> list[tuple[str, Any]]:
        near, x = self.numbers, self.state
        if self.knot.first:
            off = [x[name] - near[name] for name in self.sizes.moving]
            still = [(name, x[name]) for name in ("durations", "offset")]
            return [("start", ca.vertcat(*off)), *still]
        found = self._of_posture(x, self.poses, self.knot.resting, "")
        goal = [x["position"] - self._moved(near["position"])]
        goal.append(turned(x["quat"], self._turned(near["quat"])))
        goal += [x[name] - near[name] for name in ("velocity", "omega")]
        found["goal"] = ca.vertcat(*goal)
        return [(name, found[name]) for name in self.sizes.rows(self.knot)]

    def _interval_rows(self) -> list[tuple[str, Any]]:
        torque_share, speed_share, mu = ca.vertsplit(self.numbers["limits"])
        standing = self.knot.standing
        middle = self._of_posture(self.middle, self.poses_in_middle, standing, "_in_middle")
        speeds = {0.0: self.state, 0.5: self.middle, 1.0: {"joint_velocity": self.later}}
        found: list[tuple[str, Any]] = []
        for name, share, _ in self.sizes.interval_rows(self.knot):
            at = [float(w) for w in line(share)[0]]
            load = sum(w * values for w, values in zip(at, self.loads, strict=True))
            if name == "dynamics":
                found.append((name, self._balance(NODES.index(share))))
            elif name == "torque":
                found.append((name, load))
            elif name == "drive":
                speed = speeds[share]["joint_velocity"] / self.numbers["speed_limit"]
                found.append((name, DRIVE_SLOPE * load / torque_share + speed / speed_share))
            elif name == "friction":
                force = sum(w * node["force"] for w, node in zip(at, self.nodes, strict=True))
                found.append((name, _pyramid(self._on_surfaces(force), mu * INSCRIBED)))
            else:
                found.append((name, middle[name]))
        return found

    def _edge(self, ground: legs.Ground) -> Any:
        """An edge's way, in units of rows; it is taken not to turn."""
        moved = ca.dot(ground.towards, self._offset[1:3])
        return self.numbers["edges"] * moved / legs.LANDING_UNIT

    def _balance(self, node: int) -> Any:
        """(6,) force and moment that the base lacks, as shares of the weight."""
        total = sum(effort[:6] for effort in self.efforts[node])
        return ca.vertcat(total[:3], total[3:] / MOMENT_ARM) / self.numbers["weight"]

    def _on_surfaces(self, force: Any) -> Any:
        """Forces of the feet that stand, in axes of what they stand on."""
        corners = self.sizes.corners
        each = zip(np.repeat(self.knot.standing, corners), ca.vertsplit(force, 3), strict=True)
        return ca.vertcat(*(ca.mtimes(self._ground(int(leg)).axes.T, f) for leg, f in each))

    def _ground(self, leg: int) -> legs.Ground:
        pair = slice(2 * leg, 2 * leg + 2)
        heading, tilt, towards = (self.numbers[n][pair] for n in ("heading", "tilt", "towards"))
        place, moves = self.numbers["place"][3 * leg : 3 * leg + 3], self.numbers["moves"][leg]
        place += moves * (self._moved(place) - place)
        heading += moves * (ca.mtimes(self._turn[:2, :2], heading) - heading)
        return legs.Ground(place, heading, on_surface(tilt), tilt, towards)

    @cached_property
    def _offset(self) -> Any:
        """(4,) what counts of the landing's."""
        return self.numbers["free"] * self.state["offset"]

    @cached_property
    def _turn(self) -> Any:
        """(3, 3) of the offset's twist."""
        c, s = ca.cos(self._offset[0]), ca.sin(self._offset[0])
        return ca.blockcat([[c, -s, 0], [s, c, 0], [0, 0, 1]])

    def _moved(self, place: Any) -> Any:
        """A place where the motion ends, moved by the offset."""
        pivot = self.numbers["pivot"]
        return pivot + ca.mtimes(self._turn, place - pivot) + self._offset[1:]

    def _turned(self, quat: Any) -> Any:
        """An attitude there, turned by it."""
        half = self._offset[0] / 2
        return quat_product(ca.vertcat(ca.cos(half), 0, 0, ca.sin(half)), quat)

    def _legs(self, poses: tuple[Any, ...]) -> list[legs.Leg]:
        found = []
        for i, pose in enumerate(poses):
            kind = self.sizes.limbs[i]
            radius = split(self.numbers[f"limb {i}"], kind.numbers)["radius"]
            found.append(legs.Leg.of(kind, pose, radius))
        return found

    def _of_posture(
        self, x: Mapping[str, Any], poses: tuple[Any, ...], standing: tuple[int, ...], when: str
    ) -> dict[str, Any]:
        """Rows of a pose in which these legs stand; `when`: how names of its parameters end."""
        found = self._legs(poses)
        grounds = [self._ground(leg) for leg in range(self.sizes.legs)]
        stand = [(found[i], grounds[i]) for i in standing]
        swings = [i for i in range(self.sizes.legs) if i not in standing]
        pairs = self.sizes.pairs_with(standing)
        rises = self._offset[3] * ca.reshape(self.numbers[f"rises{when}"], self.sizes.heights, -1)
        shanks = [legs.squared_distances(found[i], found[j]) for i, j in pairs]
        slopes = ca.reshape(self.numbers[f"apart{when}"], self.sizes.posture, self.sizes.near)
        place = x["position"], turned(x["quat"], self.numbers["quat"]), x["joint_position"]
        return {
            "stop": x["joint_position"],
            "speed": x["joint_velocity"] / self.numbers["speed_limit"],
            "rest": ca.vertcat(*(legs.rest(*each) for each in stand)),
            "landing": ca.vertcat(*(legs.landing(found[i], grounds[i]) for i in self.knot.landing)),
            "clearance": ca.vertcat(
                *(legs.heights(found[i], grounds[i]) - rises[:, i] for i in swings)
            ),
            "edge": ca.vertcat(
                *(legs.along(found[i], grounds[i]) - self._edge(grounds[i]) for i in swings)
            ),
            "shanks": ca.vertcat(*(d for each in shanks for d in each)),
            "knees": ca.vertcat(*(legs.knee_height(*each) for each in stand * self.sizes.knees)),
            # Distances but for constants, which are in the bounds.
            "apart": slopes.T @ ca.vertcat(*place),
        }


def _pyramid(force: Any, slope: Any) -> Any:
    """(4 n, 1) what is left of friction to four sides, of n forces (3 n, 1)."""
    sides = []
    for k in range(0, force.numel(), 3):
        room = slope * force[k + 2]
        sides += [room - force[k], room + force[k], room - force[k + 1], room + force[k + 1]]
    return ca.vertcat(*sides)

"""Distances between links and from them to the ground and boxes, straight about a motion.

They are functions of the base's place, its small turn from the plan's attitude, and the joints.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from llsrbm.motion.block import Block
from llsrbm.robots.near_links import NearLinks, away_from
from llsrbm.robots.robot import Robot

Array = NDArray[np.float64]

# m: what is farther apart is not measured, which takes time; what comes nearer all the same is seen
# in the next round.
NEAR = 0.08
PAIRS = 2  # a limb, of links, or of a link and a box, that are kept apart: the soonest
FAR = 1.0  # m, of rows that no pair needs: all rows have bounds (`llsrbm.ocp.horizon.Problem`)
TRUNK = 1  # Pinocchio's joint
BETWEEN = 0.008  # m more, for what is between the instants that are looked at
# m that trunk and limbs keep where legs stand from what is not to be touched, as simulated bodies
# sink deeper: astride of a hurdle of 50 cm ANYmal's thigh touched it in four of four simulations
# without, in none with 2 cm or 3.5; with 5 Go2's of 40 cm is not found.
ASTRIDE = 0.03
STANDING = 0.75  # most of it, as a share of the room that a robot has as it stands


class Row(NamedTuple):
    """A distance that a posture leaves beyond the least, m, how much of it is to be kept, and its
    derivatives (6 + J,).
    """

    room: float
    kept: float
    slope: Array


@dataclass(frozen=True, eq=False)
class Apart:
    """At the knots of N intervals and in the middles between them, of n pairs.

    Attributes:
        least: (2 N + 1,) m of the nearest pair, beyond what it may be; infinite where nothing is
            near.
        at_zero: (2 N + 1, n) m that a pair would be apart, beyond what it should be, where the
            state is zero.
        slope: (2 N + 1, n, 6 + J) m per m, rad or m.
    """

    least: Array
    at_zero: Array
    slope: Array

    @classmethod
    def near(
        cls,
        q: Array,
        time: Array,
        planned: Array,
        robot: Robot,
        solids: tuple[Block, ...],
        trunk: Array,
        before: Apart | None = None,
        others: Mapping[int, tuple[Row, ...]] | None = None,
    ) -> Apart:
        """About postures q (2 N + 1, nq) at times (2 N + 1,) s; `planned`: attitudes (N + 1, 4).

        `trunk`: (2 N + 1,) m that the trunk keeps from what may be stood on, other links nothing;
            from what is not to be touched all links keep as much, but no more than `ASTRIDE`.
        Rows that are free have what `before` says: about another posture the same pair may be kept
        apart along another direction, and without the former one motions go from one to the other.
        `others`: rows of instants beside those of the pairs, the last ones.
        """
        most = PAIRS * (len(robot.legs) + len(robot.arms))
        least = np.full(len(q), np.inf)
        at_zero = np.full((len(q), most), FAR)
        slope = np.zeros((*at_zero.shape, robot.model.nv))
        links = NearLinks.of(robot)
        data = robot.model.createData()
        boxes = [_Solid.of(block, links, q) for block in solids]
        for t in range(1, len(q)):  # the first knot is given
            pin.computeJointJacobians(robot.model, data, q[t])
            here = [box for box in boxes if box.block.from_s <= time[t] < box.block.until_s]
            own = (others or {}).get(t, ())
            near = sorted(_found(links, data, q[t], here, t, trunk[t]), key=_soon)
            found = near[: most - len(own)]
            turned = _turned(planned[t // 2], q[t, 3:7])
            state = np.concatenate([q[t, :3], turned, q[t, 7:]])
            free = slice(len(found), most - len(own))
            if before is not None:
                at_zero[t, free] = before.at_zero[t, : free.stop - free.start]
                slope[t, free] = before.slope[t, : free.stop - free.start]
            places = [*range(free.start), *range(free.stop, most)]
            for i, row in zip(places, (*found, *own), strict=True):
                least[t] = min(least[t], row.room)
                at_zero[t, i] = row.room - row.kept - row.slope @ state
                slope[t, i] = row.slope
        return cls(least, at_zero, slope)

    @property
    def holds(self) -> bool:
        """True if nothing is nearer than it may be."""
        return bool((self.least >= 0).all())


class _Solid(NamedTuple):
    """A block, and how far the links are from it at least."""

    block: Block
    shape: coal.Box
    placement: pin.SE3
    bounds: Array  # (2 N + 1, S) m

    @classmethod
    def of(cls, block: Block, links: NearLinks, q: Array) -> _Solid:
        shape = coal.Box(*block.size)
        placement = pin.SE3(block.rotation, block.centre)
        return cls(block, shape, placement, links.shapes.least_from(q, shape, placement))


def _found(
    links: NearLinks, data: pin.Data, q: Array, solids: list[_Solid], t: int, trunk: float
) -> Iterator[Row]:
    """Distances of all that is near at a knot; from a solid the trunk's, and the nearest limb's."""
    least, standing = links.shapes.apart, links.shapes.standing
    for near in links.at(data, q, links.within(NEAR)):
        at_least = least[near.pair]
        kept = min(BETWEEN, STANDING * (standing[near.pair] - at_least))
        slope = np.concatenate([np.zeros(6), near.slope])
        yield Row(near.distance - at_least, kept, slope)
    R_world_base = data.oMi[1].rotation
    of_trunk = np.array([shape.joint == TRUNK for shape in links.shapes.shapes])
    for solid in solids:
        astride = min(trunk, ASTRIDE)
        rooms = (astride, astride) if solid.block.untouched else (trunk, 0.0)
        for own, kept in zip((of_trunk, ~of_trunk), rooms, strict=True):
            bounds, within = np.where(own, solid.bounds[t], np.inf), NEAR + kept
            distance, slope = away_from(
                links.shapes, data, solid.shape, solid.placement, bounds, within
            )
            if distance < within:
                moved = np.concatenate([R_world_base @ slope[:3], slope[3:]])
                yield Row(distance - kept, BETWEEN, moved)


def _soon(row: Row) -> float:
    """Smallest step of base and joints that closes the gap, m and rad.

    No joint brings a trunk to what the feet stand on: counted by joints alone that row was the last
    one and left out, and landings went on from one that sank too deep to another.
    """
    return row.room / max(float(np.linalg.norm(row.slope)), 1e-6)


def _turned(planned: Array, quat: Array) -> Array:
    """(3,) rad, about, from an attitude w, x, y, z to one x, y, z, w, as the stage has it."""
    w, v = planned[0], planned[1:]
    turned: Array = 2 * (w * quat[:3] - quat[3] * v - np.cross(v, quat[:3]))
    return turned * np.sign(w * quat[3] + v @ quat[:3])  # both signs are the same attitude

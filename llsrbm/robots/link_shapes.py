"""Pairs of a robot's links that can meet, and their distances.

Links can meet if they belong to bodies that are not neighbours, come near each other in random
postures within the joints' stops, and do not touch in the default posture or in most of the others,
as hulls do of links that lie in one another's hollows. A robot's file may add and exclude pairs
(`llsrbm.robots.schema.LinkPairs`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations

import coal
import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array, IntArray
from llsrbm.cache import cache_path, content_key, read_arrays, write_arrays
from llsrbm.errors import RobotFileError
from llsrbm.mechanics import apply
from llsrbm.request.messages import choices
from llsrbm.robots.least_distance import least_distance, way_of
from llsrbm.robots.placements import placements
from llsrbm.robots.robot import Robot
from llsrbm.robots.shapes import Shape, link_shapes

Pair = tuple[str, str]  # names of links

_SAMPLES = 4000  # random postures
AT_ONCE = 1000  # postures whose distances are bounded at once: a second of a motion at 1 kHz
_NEAR = 0.03  # m: links that never come so near cannot meet
_OFTEN = 0.5  # share of the postures: links that touch in more only seem to
_APART = 0.005  # m that links are kept apart; less where a robot stands with less between them
_WIDEST = np.pi  # rad to which joints without stops are turned
_METHOD = "pairs 5"  # a new one makes cached pairs old


@dataclass(frozen=True, eq=False)
class LinkShapes:
    """A robot's shapes, and P pairs of links that can meet."""

    robot: Robot
    shapes: tuple[Shape, ...]
    pairs: tuple[Pair, ...]

    @staticmethod
    def of(robot: Robot) -> LinkShapes:
        """A robot's. Raises `RobotFileError`: its URDF's geometry cannot be read, or its file names
        links that have no shapes.
        """
        return _of(robot)

    def distances(self, postures: Array) -> Array:
        """(..., P) m, negative where links are inside each other, in postures q (..., nq)."""
        q = np.reshape(postures, (-1, self.robot.model.nq))
        return self.near_distances(q, np.inf).reshape(*np.shape(postures)[:-1], -1)

    def near_distances(self, postures: Array, within: float) -> Array:
        """(T, P) m, as `distances` of q (T, nq); infinite of pairs not seen to be `within` (m)."""
        found = np.full((len(postures), len(self.pairs)), np.inf)
        place, measure = self._by_pinocchio()
        bounds = self._bounds(self._sphere_centres(placements(self.robot.model, postures)))
        for t in range(len(postures)):
            place(postures[t])
            for k in np.flatnonzero(bounds[t] < within):
                pair = self.pair_of[k]
                found[t, pair] = min(found[t, pair], measure(int(k)).min_distance)
        return found

    def least(self, postures: Array, beyond: Array | None = None) -> tuple[float, int, Pair]:
        """The least distance in postures q (T, nq) that follow each other, m; in which, of whom.

        `beyond`: (P,) m of each pair; least is what exceeds it least. Many times as fast as
        `distances`: few are measured. There are pairs.
        """
        needed = np.zeros(len(self.pairs)) if beyond is None else beyond
        needed = needed[self.pair_of]
        room, instant, k = np.inf, 0, 0
        for first in range(0, len(postures), AT_ONCE):
            some = postures[first : first + AT_ONCE]
            least, at, pair = self._least_room(some, needed, room)
            if least < room:
                room, instant, k = least, first + at, pair
        return float(room + needed[k]), instant, self.pairs[self.pair_of[k]]

    def _least_room(self, postures: Array, needed: Array, known: float) -> tuple[float, int, int]:
        """The least by which a distance exceeds what is `needed` (K,) m, in which posture, of which
        of the geometry's pairs; `known` where none does so by less.
        """
        place, measure = self._by_pinocchio()
        placed = placements(self.robot.model, postures)
        centres, (_, radius) = self._sphere_centres(placed), self.spheres

        def measured(t: int, k: int) -> float:
            place(postures[t])
            return float(measure(k).min_distance - needed[k])

        def way(k: int) -> Array:
            """The smaller one's way, seen from the larger one."""
            small, large = sorted(self.shape_pairs[k], key=radius.__getitem__)
            turn, origin = (each[:, self.shapes[large].joint] for each in placed)
            back = np.swapaxes(turn, -1, -2)
            seen = back @ placed[0][:, self.shapes[small].joint]
            return way_of(seen, apply(back, centres[:, small] - origin), radius[small])

        return least_distance(self._bounds(centres) - needed, measured, way, known)

    @cached_property
    def apart(self) -> Array:
        """(P,) m that links are to be apart: 5 mm, or half of what they are as the robot stands."""
        return np.minimum(_APART, self.standing / 2)

    @cached_property
    def standing(self) -> Array:
        """(P,) m, distances in the default posture; infinite of pairs that are not near there."""
        found: Array = self.near_distances(self.robot.posture[None], _NEAR)[0]
        return found

    def clearance(self, postures: Array, shape: coal.ShapeBase, placement: pin.SE3) -> Array:
        """(T,) m: least distance of links that are no feet to a shape that stands in the world."""
        model, data = self.robot.model, self.robot.model.createData()
        least = np.empty(len(postures))
        bounds = self.least_from(postures, shape, placement)
        for t, q in enumerate(postures):
            pin.forwardKinematics(model, data, q)
            least[t] = self.nearest_to(shape, placement, data, bounds[t])[0].min_distance
        return least

    def least_from(self, postures: Array, shape: coal.ShapeBase, placement: pin.SE3) -> Array:
        """(T, S) m: what each link's shape is away at least from one in the world; feet are far."""
        shape.computeLocalAABB()
        low, high = shape.aabb_local.min_, shape.aabb_local.max_
        centres = self._sphere_centres(placements(self.robot.model, postures))
        at = (centres - placement.translation) @ placement.rotation
        bounds: Array = np.linalg.norm(at - np.clip(at, low, high), axis=-1) - self.spheres[1]
        bounds[:, [own.foot for own in self.shapes]] = np.inf
        return bounds

    def nearest_to(
        self,
        shape: coal.ShapeBase,
        placement: pin.SE3,
        data: pin.Data,
        bounds: Array,
        within: float = np.inf,
    ) -> tuple[coal.DistanceResult, int]:
        """The link nearest to a shape in the world, feet aside; its joint's index second.

        `data`: with the bodies placed; `bounds`: (S,) m of `least_from`. Those that cannot be
        `within` (m) are not measured; without any the result's distance is the largest number there
        is.
        """
        request, there = coal.DistanceRequest(), _transform(placement)
        nearest, joint = coal.DistanceResult(), 0
        for k in np.flatnonzero(bounds <= within).tolist():
            if bounds[k] > nearest.min_distance:
                continue
            own, placed = self.shapes[k], self._placed_in_joints[k]
            found, link = coal.DistanceResult(), self.geometry.geometryObjects[k].geometry
            body = _transform(data.oMi[own.joint] * placed)
            coal.distance(link, body, shape, there, request, found)
            if found.min_distance < nearest.min_distance:
                nearest, joint = found, own.joint
        return nearest, joint

    @cached_property
    def _placed_in_joints(self) -> list[pin.SE3]:
        return [placed.placement for placed in self.geometry.geometryObjects]

    @cached_property
    def geometry(self) -> pin.GeometryModel:
        """Pinocchio's, the shapes in their order; its K pairs are the shapes of `pairs`."""
        model = pin.GeometryModel()
        for k, shape in enumerate(self.shapes):
            placement = pin.SE3(shape.rotation, shape.centre)
            geometry = shape.geometry()
            model.addGeometryObject(
                pin.GeometryObject(f"{shape.link}/{k}", shape.joint, placement, geometry)
            )
        for one, other in self.shape_pairs:
            model.addCollisionPair(pin.CollisionPair(one, other))
        return model

    @cached_property
    def pair_of(self) -> IntArray:
        """(K,) place in `pairs` of each of the geometry's pairs."""
        place = {frozenset(pair): k for k, pair in enumerate(self.pairs)}
        links = [shape.link for shape in self.shapes]
        return np.array(
            [place[frozenset((links[one], links[other]))] for one, other in self.shape_pairs],
            dtype=np.int64,
        )

    @cached_property
    def shape_pairs(self) -> list[tuple[int, int]]:
        """(K,) places of two in `shapes` whose links are one of `pairs`."""
        wanted = {frozenset(pair) for pair in self.pairs}
        links = [shape.link for shape in self.shapes]
        return [
            (one, other)
            for one in range(len(links))
            for other in range(one + 1, len(links))
            if frozenset((links[one], links[other])) in wanted
        ]

    def _by_pinocchio(
        self,
    ) -> tuple[Callable[[Array], None], Callable[[int], coal.DistanceResult]]:
        """To place the shapes in a posture, and to measure one of the geometry's pairs there."""
        model, geometry = self.robot.model, self.geometry
        data, placed = model.createData(), geometry.createData()

        def place(q: Array) -> None:
            pin.updateGeometryPlacements(model, data, geometry, placed, q)

        def measure(pair: int) -> coal.DistanceResult:
            return pin.computeDistance(geometry, placed, pair)

        return place, measure

    def _bounds(self, centres: Array) -> Array:
        """(T, K) m: what the distance of each of the geometry's pairs is at least."""
        radius = self.spheres[1]
        one, other = np.reshape(np.array(self.shape_pairs, dtype=np.int64), (-1, 2)).T
        between = centres[:, one] - centres[:, other]
        # A norm of NumPy's takes several times as long for as little.
        apart = np.sqrt(np.einsum("tki,tki->tk", between, between))
        return apart - radius[one] - radius[other]

    def _sphere_centres(self, placed: tuple[Array, Array]) -> Array:
        """(T, S, 3) m, in the world; `placed`: of `placements`."""
        joints = [shape.joint for shape in self.shapes]
        turn, origin = (each[:, joints] for each in placed)
        return origin + np.einsum("tsij,sj->tsi", turn, self.spheres[0])

    @cached_property
    def spheres(self) -> tuple[Array, Array]:
        """Around each shape: centre (S, 3) m in its joint's frame, radius (S,) m."""
        centres, radii = [], []
        for placed in self.geometry.geometryObjects:
            placed.geometry.computeLocalAABB()
            centres.append(placed.placement.act(placed.geometry.aabb_center))
            radii.append(placed.geometry.aabb_radius)
        return np.array(centres), np.array(radii)


@lru_cache(maxsize=16)
def _of(robot: Robot) -> LinkShapes:
    shapes = link_shapes(robot)
    stated = robot.file.link_pairs
    links = sorted({shape.link for shape in shapes})
    for key, pairs in (("add", stated.add), ("exclude", stated.exclude)):
        for link in (link for pair in pairs for link in pair):
            if link not in links:
                raise RobotFileError(
                    f'{robot.path}: link_pairs.{key}: no link "{link}" of {robot.urdf_path} has a '
                    f"shape; {choices(link, links)}"
                )
    excluded = {frozenset(pair) for pair in stated.exclude}
    found = {frozenset(pair): pair for pair in (*_that_can_meet(robot, shapes), *stated.add)}
    kept = [pair for both, pair in found.items() if both not in excluded]
    return LinkShapes(robot, shapes, tuple(kept))


def _transform(placement: pin.SE3) -> coal.Transform3s:
    return coal.Transform3s(placement.rotation, placement.translation)


def _that_can_meet(robot: Robot, shapes: tuple[Shape, ...]) -> list[Pair]:
    """Found by random postures, or taken from the cache."""
    posture = " ".join(repr(float(angle)) for angle in robot.posture[7:])
    key = content_key(_METHOD, robot.urdf.content, posture, *robot.urdf.mesh_stamps())
    path = cache_path(f"link-pairs-{robot.name}", key, ".npz")
    stored = read_arrays(path)
    if stored is None:
        pairs = _found(robot, shapes)
        write_arrays(path, {"pairs": np.reshape(np.array(pairs, dtype=str), (-1, 2))})
        return pairs
    return [(str(one), str(other)) for one, other in stored["pairs"]]


def _found(robot: Robot, shapes: tuple[Shape, ...]) -> list[Pair]:
    joint = {shape.link: shape.joint for shape in shapes}
    parents = robot.model.parents
    apart = [
        (one, other)
        for one, other in combinations(joint, 2)
        if joint[one] != joint[other]
        and parents[joint[one]] != joint[other]
        and parents[joint[other]] != joint[one]
    ]
    every = LinkShapes(robot, shapes, tuple(apart))
    postures = np.concatenate([robot.posture[None], _random_postures(robot)])
    least = every.near_distances(postures, _NEAR)
    touching = least < 0
    meet = (least < _NEAR).any(axis=0) & ~touching[0] & (touching.mean(axis=0) < _OFTEN)
    return [pair for pair, can in zip(apart, meet, strict=True) if can]


def _random_postures(robot: Robot) -> Array:
    """(n, nq) joints anywhere within their stops, the base at rest."""
    model = robot.model
    low, high = (
        np.clip(limit[7:], -_WIDEST, _WIDEST)
        for limit in (model.lowerPositionLimit, model.upperPositionLimit)
    )
    postures = np.tile(robot.posture, (_SAMPLES, 1))
    postures[:, 7:] = np.random.default_rng(0).uniform(low, high, (_SAMPLES, len(low)))
    return postures

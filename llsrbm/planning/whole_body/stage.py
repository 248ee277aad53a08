"""A stage of the whole-body problem: which functions are called, of what.

The durations of the phases, and the landing's offset, are states that do not change.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.ocp.composition import Composed, Composition, Derived, Part
from llsrbm.ocp.lifting import Lifting
from llsrbm.planning.whole_body.chain import split
from llsrbm.planning.whole_body.effort import limb_effort, trunk_effort
from llsrbm.planning.whole_body.grid import Knot
from llsrbm.planning.whole_body.interval import pose_at
from llsrbm.planning.whole_body.leg_pose import leg_pose
from llsrbm.planning.whole_body.rows import Stage
from llsrbm.planning.whole_body.sizes import NODES, Sizes, units

LATER = 1.0  # shares of the interval
MIDDLE = 0.5


def composed_stage(knot: Knot, sizes: Sizes) -> Composed:
    """A knot's stage."""
    return _Builder(knot, sizes).composed()


class _Builder:
    def __init__(self, knot: Knot, sizes: Sizes) -> None:
        self.knot, self.sizes = knot, sizes
        z = ca.MX.sym("z", sizes.states + sizes.controls(knot))
        numbers = ca.MX.sym("own", sum(sizes.robot.values()) + sum(sizes.own.values()))
        self.numbers = split(numbers, sizes.robot | sizes.own)
        self.calls = Composition(z, self._unit(), numbers)
        self.state = _named(self.calls.start, sizes.state)
        self.nodes = list(self._nodes())

    def _unit(self) -> Any:
        """(n, 1) MX: one unit of each variable, in SI units."""
        sizes = self.sizes
        found = [ca.DM(units(sizes.state, 1.0))]
        force = self.numbers["weight"] / (sizes.legs * sizes.corners)
        for _ in NODES if not self.knot.last else ():
            of_node = sizes.node(len(self.knot.standing))
            motion = {name: n for name, n in of_node.items() if name != "force"}
            found += [ca.DM(units(motion, 1.0)), ca.repmat(force, of_node["force"], 1)]
        return ca.vertcat(*found)

    def _nodes(self) -> Iterator[dict[str, Part]]:
        of_node = self.sizes.node(len(self.knot.standing))
        size, at = sum(of_node.values()), self.sizes.states
        while at < self.calls.start.size:
            yield _named(self.calls.start.cut(at, at + size), of_node)
            at += size

    def composed(self) -> Composed:
        """All calls, and what the stage gives."""
        knot, sizes = self.knot, self.sizes
        moving = {name: self.state[name] for name in sizes.moving}
        poses = {} if knot.last else self._poses(moving)
        legs = () if knot.first else self._legs(moving)
        inputs = {"variables": self.calls.start}
        inputs |= {f"leg {i}": part for i, part in enumerate(legs)}
        if not knot.last:
            middle = _named(poses[MIDDLE], sizes.moving)
            inputs |= {"middle": poses[MIDDLE], "later": poses[LATER]}
            inputs |= {f"middle leg {i}": part for i, part in enumerate(self._legs(middle))}
            for n, share in enumerate(NODES):
                efforts = self._efforts(_named(poses[share], sizes.moving), n)
                inputs |= {f"effort {n} {i}": part for i, part in enumerate(efforts)}
        v, n, stage = _symbols(knot, sizes, {name: part.size for name, part in inputs.items()})
        rows = stage.rows()
        g = ca.vertcat(*(ca.vec(row.expression) for row in rows))
        return Composed(
            calls=self.calls,
            states=sizes.states,
            cost=self._called("cost", stage.cost(), inputs, v, n),
            rows=self._called("rows", g, inputs, v, n),
            next_state=None if knot.last else self._next(poses[LATER]),
            equality=tuple(row.equality for row in rows for _ in range(row.expression.numel())),
        )

    def _called(
        self, name: str, values: Any, inputs: dict[str, Part], v: dict[str, Any], n: Any
    ) -> Part:
        """Values of symbols, as a function of those parts that count."""
        every = ca.vertcat(*v.values())
        counts = _counts(values, every)
        used, at = [], 0
        for part, symbols in v.items():
            if counts[at : at + symbols.numel()].any():
                used.append(part)
            at += symbols.numel()
        variables = ca.vertcat(*(v[part] for part in used))
        function = Derived(name, variables, n, values, Lifting(variables))
        return self.calls(function, [inputs[part] for part in used], self.calls.numbers)

    def _step(self) -> Part:
        """The interval's length, s: its share of its phase's duration."""
        return self.calls(
            _step(self.sizes.phases),
            [self.state["durations"]],
            ca.vertcat(self.numbers["step"], self.numbers["phase"]),
        )

    def _poses(self, moving: dict[str, Part]) -> dict[float, Part]:
        """Share of the interval -> what moves then."""
        rates = [node[name] for node in self.nodes for name in self.sizes.motion]
        inputs = [*moving.values(), *rates, self._step()]
        shares = (*NODES, MIDDLE, LATER)
        joints, none = self.sizes.joints, ca.MX(0, 1)
        return {share: self.calls(pose_at(joints, share), inputs, none) for share in shares}

    def _next(self, later: Part) -> Part:
        """The next state, in its units."""
        still = [self.state[name] for name in ("durations", "offset")]
        return self.calls(_scaled(self.sizes), [later, *still], ca.MX(0, 1))

    def _legs(self, pose: dict[str, Part]) -> tuple[Part, ...]:
        found = []
        base = [pose[name] for name in ("position", "quat", "velocity", "omega")]
        for i in range(self.sizes.legs):
            joints = [*self._of_limb(pose["joint_position"], i)]
            joints += self._of_limb(pose["joint_velocity"], i)
            of = leg_pose(self.sizes.limbs[i])
            found.append(self.calls(of, [*base, *joints], self._numbers_of(i)))
        return tuple(found)

    def _efforts(self, pose: dict[str, Part], node: int) -> tuple[Part, ...]:
        u, knot, sizes = self.nodes[node], self.knot, self.sizes
        base = [pose["quat"], pose["omega"], u["acceleration"], u["omega_rate"]]
        found = [self.calls(trunk_effort(), base, self.numbers["trunk"])]
        for i, kind in enumerate(sizes.limbs):
            inputs = list(base)
            rates = pose["joint_position"], pose["joint_velocity"], u["joint_acceleration"]
            for each in rates:
                inputs += self._of_limb(each, i)
            stands = i in knot.standing
            if stands:
                place, size = knot.standing.index(i), 3 * sizes.corners
                inputs.append(u["force"].cut(place * size, (place + 1) * size))
            of = limb_effort(kind, stands)
            found.append(self.calls(of, inputs, self._numbers_of(i)))
        return tuple(found)

    def _numbers_of(self, limb: int) -> Any:
        """A limb's numbers, of a leg with the normal of what its foot stands on."""
        own = [self.numbers[f"limb {limb}"]]
        if limb < self.sizes.legs:
            own.append(self.numbers["normal"][3 * limb : 3 * limb + 3])
        return ca.vertcat(*own)

    def _of_limb(self, joints: Part, limb: int) -> Iterator[Part]:
        """A limb's of all joints' values."""
        places = np.array(self.sizes.limb_joints[limb])
        for run in np.split(places, np.flatnonzero(np.diff(places) != 1) + 1):
            yield joints.cut(int(run[0]), int(run[-1]) + 1)


def _named(part: Part, sizes: dict[str, int]) -> dict[str, Part]:
    found, at = {}, 0
    for name, size in sizes.items():
        found[name] = part.cut(at, at + size)
        at += size
    return found


@lru_cache
def _step(phases: int) -> Derived:
    v, n = ca.SX.sym("v", phases), ca.SX.sym("n", phases + 1)
    return Derived("step", v, n, n[0] * ca.dot(n[1:], v), Lifting(v))


@lru_cache(maxsize=16)
def _scaled(sizes: Sizes) -> Derived:
    v = ca.SX.sym("v", sizes.states)
    return Derived("next", v, ca.SX(0, 1), v / ca.DM(units(sizes.state, 1.0)), Lifting(v))


def _counts(values: Any, variables: Any) -> NDArray[np.bool_]:
    """(n,) of variables, on which some values depend."""
    pattern = ca.jacobian_sparsity(values, variables)
    return np.diff(pattern.colind()) > 0


def _symbols(knot: Knot, sizes: Sizes, widths: dict[str, int]) -> tuple[dict[str, Any], Any, Stage]:
    """Symbols of parts with these names and sizes, of the parameters, and the stage of them."""
    part = {name: ca.SX.sym(name, size) for name, size in widths.items()}
    n = ca.SX.sym("n", sum(sizes.robot.values()) + sum(sizes.own.values()))
    numbers = split(n, sizes.robot | sizes.own)
    unit_force = numbers["weight"] / (sizes.legs * sizes.corners)
    nodes = []
    of_node = sizes.node(len(knot.standing))
    for k in range(0 if knot.last else len(NODES)):
        at = sizes.states + k * sum(of_node.values())
        node = split(part["variables"][at : at + sum(of_node.values())], of_node)
        nodes.append(node | {"force": node["force"] / unit_force})
    legs, limbs = range(sizes.legs), range(1 + len(sizes.limbs))
    stage = Stage(
        knot=knot,
        sizes=sizes,
        state=split(part["variables"][: sizes.states], sizes.state),
        nodes=tuple(nodes),
        middle={} if knot.last else split(part["middle"], sizes.moving),
        later=None if knot.last else split(part["later"], sizes.moving)["joint_velocity"],
        poses=() if knot.first else tuple(part[f"leg {i}"] for i in legs),
        poses_in_middle=() if knot.last else tuple(part[f"middle leg {i}"] for i in legs),
        efforts=tuple(tuple(part[f"effort {k} {i}"] for i in limbs) for k in range(len(nodes))),
        numbers=numbers,
    )
    return part, n, stage

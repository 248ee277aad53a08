"""The jumps of a spec in their order: counted without listing them, made when they are needed.

Robots, models and types are the slowest to change, then drives, limits and the jump's own axes. A
drawn sweep takes the same shares of its ranges of every robot, model and type, so that they can be
compared jump by jump.
"""

import hashlib
import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np

from llsrbm.arrays import Array
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.request.jump_types import load_type, with_defaults
from llsrbm.request.messages import choices, look_up
from llsrbm.robots import load_robot
from llsrbm.sweep.spec import COUNTED, ROBOT_RANGES, Ranges, Spec

REQUEST = tuple(n for n in Jump.__dataclass_fields__ if n not in ("payload", "stones", "route"))
"""The fields of a jump that a sweep varies or states."""

MOST_ROWS = 10**8
"""Rows of a sweep at most: two workers take a year for that."""

_BLOCK = 4096  # points of a Sobol sequence drawn at a time; a power of two, as it wants
_LARGEST_SOBOL = 2**30  # points that SciPy's 32 bits hold
_ID_DIGITS = 16  # hexadecimal, of an id: two of 10^8 jumps are alike once in 4,000 sweeps


@dataclass(frozen=True)
class Point:
    """One jump of a sweep, by its number in it.

    Attributes:
        seeds: of its simulations, one a row; None: undisturbed, or planned only.
    """

    number: int
    jump: Jump
    limits: dict[str, float]  # limit name -> value, in place of the robot's
    drive_torque: float  # factors of the robot file's
    drive_speed: float  # factors of the robot file's
    seeds: tuple[int | None, ...]

    @property
    def rows(self) -> range:
        """Its places in the table."""
        return range(self.number * len(self.seeds), (self.number + 1) * len(self.seeds))

    @property
    def id(self) -> str:
        """The same for the same request in every sweep."""
        request = [request_in(self.jump), self.limits, self.drive_torque, self.drive_speed]
        text = json.dumps(request, sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:_ID_DIGITS]


def request_in(jump: Jump) -> dict[str, Any]:
    """The fields of a jump that sweeps vary or state."""
    values = jump.as_dict()
    return {name: values[name] for name in REQUEST}


class Points:
    """The jumps of a spec by their number, `count` of them in `rows` rows of the table. Raises
    `InputError`: too many jumps, an unknown robot, model, type or limit, or a wrong robot file.
    """

    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        self._dimensions = list(spec.dimensions())
        self._groups = list(product(spec.robots, spec.models, spec.types))
        sizes = [dimension.size for dimension in self._dimensions]
        self._of_group = math.prod(sizes) if spec.sampling == "grid" else spec.count or 0
        self.count = len(self._groups) * self._of_group
        self._seeds = spec.rows_a_jump()
        self.rows = self.count * self._seeds
        if self.rows > MOST_ROWS or (spec.sampling == "sobol" and self._of_group > _LARGEST_SOBOL):
            raise InputError(
                f"the spec asks for {self.rows:.3g} rows; expected at most {MOST_ROWS:.0e}: fewer "
                "values an axis, or a count with random sampling"
            )
        from llsrbm.models import MODELS

        for model in spec.models:
            look_up("model", model, MODELS)
        for kind in spec.types:
            load_type(kind)
        self._ranges = {robot: _checked_ranges(robot, spec) for robot in spec.robots}

    def __getitem__(self, number: int) -> Point:
        if not 0 <= number < self.count:
            raise IndexError(number)
        return self._point(number, self._values(number))

    def __iter__(self) -> Iterator[Point]:
        return (self[number] for number in range(self.count))

    def kinds(self) -> Iterator[Point]:
        """A jump of everything that solvers are built for: robot, model, type, turns, drives."""
        listed = [
            [((each.where, each.name), each.value(n, {})) for n in range(each.size)]
            for each in self._dimensions
            if each.where == "drives" or each.name in COUNTED
        ]
        for first in range(0, self.count, self._of_group):
            for values in product(*listed):
                yield self._point(first, self._values(first) | dict(values))

    def _point(self, number: int, values: dict[tuple[str, str], float]) -> Point:
        robot, model, kind = self._groups[number // self._of_group]
        fields: dict[str, Any] = {name: v for (where, name), v in values.items() if where == "axes"}
        if "hops" in fields:
            fields["hops"] = int(fields["hops"])
        arms = self.spec.arms or Jump.arms
        jump = Jump(robot=robot, model=model, type=kind, arms=arms, **fields)
        rows = range(number * self._seeds, (number + 1) * self._seeds)
        return Point(
            number=number,
            jump=with_defaults(jump, fields),
            limits={name: v for (where, name), v in values.items() if where == "limits"},
            drive_torque=values.get(("drives", "torque"), 1.0),
            drive_speed=values.get(("drives", "speed"), 1.0),
            seeds=tuple(self.spec.simulation_seed(row) for row in rows),
        )

    def _values(self, number: int) -> dict[tuple[str, str], float]:
        """Table and name of what varies -> value, SI."""
        group, place = divmod(number, self._of_group)
        ranges = self._ranges[self._groups[group][0]]
        if self.spec.sampling != "grid":
            shared = zip(self._dimensions, self._shares(place), strict=True)
            return {(d.where, d.name): d.drawn(float(share), ranges) for d, share in shared}
        found = {}
        for dimension in reversed(self._dimensions):
            place, value = divmod(place, dimension.size)
            found[dimension.where, dimension.name] = dimension.value(value, ranges)
        return dict(reversed(found.items()))

    def _shares(self, place: int) -> Array:
        """(d,) of each axis' range, 0 to 1."""
        dimensions, seed = len(self._dimensions), self.spec.seed
        if self.spec.sampling == "random":
            # A generator for each point: any of them can be drawn without those before it.
            return np.random.default_rng([seed, place]).random(dimensions)
        return _sobol(dimensions, seed, place // _BLOCK)[place % _BLOCK]


@lru_cache(maxsize=4)
def _sobol(dimensions: int, seed: int, block: int) -> Array:
    """(_BLOCK, d) of a scrambled Sobol sequence."""
    from scipy.stats import qmc

    if dimensions == 0:
        return np.zeros((_BLOCK, 0))
    sequence = qmc.Sobol(dimensions, scramble=True, rng=np.random.default_rng(seed))
    if block:
        sequence.fast_forward(block * _BLOCK)
    return sequence.random(_BLOCK)


def _checked_ranges(robot: str, spec: Spec) -> Ranges:
    """The ranges of the robot's file, once limits and scenario have been checked."""
    loaded = load_robot(robot)
    if spec.limits:
        from llsrbm.planning.problem.placement import limits_of

        known = limits_of(loaded)
        for name in spec.limits:
            if name not in known:
                raise InputError(f'limits: {robot} has no limit "{name}"; {choices(name, known)}')
    if (scenario := spec.scenario()) is not None:
        from llsrbm.simulation.checks import check_scenario

        check_scenario(scenario, loaded)
    return {name: getattr(loaded.file.task, name) for name in ROBOT_RANGES}

"""A sweep's spec: which jumps of which robots, as a TOML file says it.

    title = "ANYmal: twist and distance"
    robots = ["anymal"]              # names or paths of robot files
    models = ["llsrbm-plus"]         # if left out: this one
    types = ["together"]             # likewise

    [axes]                           # in SI units; angles in rad, or in degrees as twist_deg
    twist_deg = { from = -180, to = 180, count = 25 }
    forward = [0.0, 0.2, 0.4]
    height = { range = "robot", count = 7 }      # all that the robot's file says may be asked

    [limits]                         # limit name -> values, see `llsrbm tuning`
    friction = [0.3, 0.5]

    [drives]                         # times what the robot's file says
    torque = [0.8, 1.0, 1.2]

    [simulate]                       # without: plan only
    seeds = 3                        # of each jump, all different; a list: these for every jump

A grid has every value of every axis with every other. With `sampling = "random"` or `"sobol"` there
are `count` jumps a robot, model and type, drawn by `seed`, and ranges have no `count`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from llsrbm.errors import InputError, printable
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tables import Table, with_tuples
from llsrbm.sweep.axes import (
    DEGREES,
    Axis,
    AxisTable,
    Dimension,
    DriveAxes,
    JumpAxes,
    check_axis,
    check_drives,
    names_of,
    wrong,
)

_LARGEST_SEED = 2**63 - 1  # what the table's column holds


def _printable(text: str) -> str:
    if not text.isprintable():
        raise PydanticCustomError("text", "expected one line of printable text")
    return text


_OneLine = AfterValidator(_printable)
_Name = Annotated[str, Field(min_length=1, max_length=1000), _OneLine]
_Names = Annotated[tuple[_Name, ...], Field(min_length=1)]


class Spec(Table):
    """A sweep's spec.

    Attributes:
        title: one line.
        robots, models, types: names or paths, as a `Jump` has them.
        sampling: how axes are combined; count: jumps a robot, model and type of a drawn sweep.
        seed: draws jumps, and numbers the disturbances of simulations (`seeds`).
        axes, limits, drives: what varies; what is not named is as the robot has it.
        simulate: fields of a `Scenario`, with `seeds`; None or false: plan only.
        patient: whether plans are tried from other guesses where the analytic one fails.
        diagnose: whether the limit that stops a jump is looked for, which takes some seconds each.
        trajectories: whether planned motions are kept, as zarr.
    """

    title: Annotated[str, Field(min_length=1, max_length=200), _OneLine]
    robots: _Names
    models: _Names = (Jump.model,)
    types: _Names = (Jump.type,)
    sampling: Literal["grid", "random", "sobol"] = "grid"
    count: Annotated[int, Field(ge=1)] | None = None
    seed: Annotated[int, Field(ge=0, le=_LARGEST_SEED)] = 0
    axes: JumpAxes = JumpAxes()
    limits: dict[_Name, Axis] = Field(default_factory=dict)
    drives: DriveAxes = DriveAxes()
    simulate: Literal[False] | dict[str, Any] | None = None
    patient: bool = True
    diagnose: bool = False
    trajectories: bool = False

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("robots", "models", "types"):
            given = getattr(self, name)
            if len(set(given)) < len(given):
                raise wrong(f"{name}: one is named twice; expected each once")
        if self.sampling == "grid" and self.count is not None:
            raise wrong('count: a grid has its axes\' counts; expected it with "random" or "sobol"')
        if self.sampling != "grid" and self.count is None:
            raise wrong(f'count: missing; expected how many jumps to draw with "{self.sampling}"')
        for where, name, axis in self._given():
            check_axis(f"{where}.{name}", name, axis, self.sampling)
        for name in ("twist", "roll", "pitch"):
            if getattr(self.axes, name) and getattr(self.axes, name + DEGREES):
                raise wrong(f"axes: {name} and {name}{DEGREES} are the same; expected one of them")
        check_drives(self.drives)
        self.scenario()
        return self

    def _given(self) -> Iterator[tuple[str, str, AxisTable]]:
        """Table, name and axis of all that are given, the slowest of a grid first."""
        for where, table in (("drives", self.drives), ("limits", None), ("axes", self.axes)):
            named = (
                self.limits if table is None else {n: getattr(table, n) for n in names_of(table)}
            )
            for name, axis in named.items():
                if axis is not None:
                    yield where, name, axis

    def dimensions(self) -> list[Dimension]:
        """What varies, in SI units, the slowest of a grid first."""
        return [Dimension(where, name, axis) for where, name, axis in self._given()]

    def scenario(self) -> Scenario | None:
        """What simulations are asked for, seeds aside; None: plan only."""
        if not self.simulated:
            return None
        table: dict[str, Any] = dict(self.simulate or {})
        seeds = table.pop("seeds", None)
        _check_seeds(seeds)
        if "seed" in table:
            raise wrong('simulate.seed: expected "seeds", a number of them or a list')
        try:
            scenario = Scenario().but(**table)
            return scenario if seeds is None else scenario.but(seed=0)
        except InputError as error:
            raise wrong(f"simulate: {error}") from error

    @property
    def simulated(self) -> bool:
        """Whether plans are simulated, too."""
        return self.simulate is not None and self.simulate is not False

    def rows_a_jump(self) -> int:
        """One a seed."""
        seeds = self.simulate.get("seeds") if isinstance(self.simulate, dict) else None
        return len(seeds) if isinstance(seeds, tuple) else seeds or 1

    def simulation_seed(self, row: int) -> int | None:
        """Of the row with that number; None: undisturbed, or not simulated."""
        seeds = self.simulate.get("seeds") if isinstance(self.simulate, dict) else None
        if isinstance(seeds, tuple):
            return int(seeds[row % len(seeds)])
        return None if seeds is None else self.seed + row

    def as_json(self) -> str:
        """The whole of it, to be sent or compared."""
        return self.model_dump_json(by_alias=True, exclude_none=True)

    @classmethod
    def from_json(cls, text: str) -> Spec:
        """What `as_json` wrote."""
        return cls.model_validate(with_tuples(json.loads(text)))

    def digest(self) -> str:
        """The same for specs that ask the same, whatever their comments, and for those alone."""
        return hashlib.sha256(self.as_json().encode()).hexdigest()


def _check_seeds(seeds: Any) -> None:
    """Whether they are a number of seeds or a list of them; None: none."""
    listed = seeds if isinstance(seeds, tuple) else (seeds,)
    whole = all(isinstance(seed, int) and not isinstance(seed, bool) for seed in listed)
    if seeds is None or (
        whole
        and listed
        and len(set(listed)) == len(listed)
        and min(listed) >= (0 if listed is seeds else 1)
        and max(listed) <= _LARGEST_SEED
    ):
        return
    raise wrong(
        "simulate.seeds: expected how many of each jump, from 1 on, or a list of different seeds "
        f"from 0 on, got {printable(repr(seeds))}"
    )

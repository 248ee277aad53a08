"""Layout, stages, constraints and costs as an optimal control problem, and a task's numbers."""

from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from llsrbm.arrays import Array
from llsrbm.models.base import CentroidalModel
from llsrbm.ocp.horizon import Horizon, Problem, Row, Run, StageExpressions
from llsrbm.planning.problem.constraints import CONSTRAINTS, Constraint
from llsrbm.planning.problem.costs import COSTS, weight_parameter
from llsrbm.planning.problem.knots import DYNAMICS, RowValues
from llsrbm.planning.problem.layout import BODY, BODY_PLACES, Layout
from llsrbm.planning.problem.parameters import (
    OWN,
    local_parameters,
    parameter_places,
    parameter_sizes,
    parameter_symbols,
    parameters,
)
from llsrbm.planning.problem.roles import Role
from llsrbm.planning.problem.stage import Stage
from llsrbm.planning.problem.task import Task

_BODY = np.zeros(max(place.stop for place in BODY_PLACES.values()))


def constraints_of(role: Role) -> tuple[Constraint, ...]:
    """The constraints that apply to a role, in the order of their rows."""
    return tuple(c for c in CONSTRAINTS if c.applies(role))


def make_horizon(model: CentroidalModel, layout: Layout) -> Horizon:
    """The stages of a model's jumps; one run is a block of knots of the same role."""
    symbols, places = parameter_symbols(layout), parameter_places(layout)

    def builder(role: Role, following: Role | None) -> Callable[[], StageExpressions]:
        return lambda: _expressions(Stage(role, layout, model, symbols), symbols, following)

    def own(knot: int) -> slice:
        start = places[OWN].start + layout.own_numbers * knot
        return slice(start, start + layout.own_numbers)

    runs = []
    for role, knots in layout.blocks():
        following = None if role.terminal else layout.roles[knots[-1] + 1]
        runs.append(
            Run(
                family=_family(role, following, layout),
                count=len(knots),
                build=builder(role, following),
                local=tuple(places[name] for name in local_parameters(role.phase)),
                own=() if role.terminal else tuple(own(knot) for knot in knots),
            )
        )
    return Horizon(tuple(runs), sum(parameter_sizes(layout).values()))


def _expressions(
    stage: Stage, symbols: Mapping[str, ca.SX], following: Role | None
) -> StageExpressions:
    """A stage's expressions; `following` is the next knot's role, None at the end."""
    own = ca.SX(0, 1) if stage.role.terminal else stage.own
    cost = stage.penalty
    for term in COSTS:
        if term.applies(stage.role):
            cost += stage.parameters[weight_parameter(term)] * term.term(stage)
    rows = tuple(Row(c.rows(stage), c.equality) for c in constraints_of(stage.role))
    return StageExpressions(
        variables=stage.variables,
        states=stage.layout.state_size(stage.role),
        shared=ca.vertcat(*symbols.values()),
        local=ca.vertcat(stage.local, own),
        cost=cost,
        rows=rows,
        next_state=None if following is None else stage.next_state(following),
        lift=stage.lift,
    )


def _family(role: Role, following: Role | None, layout: Layout) -> Hashable:
    """Equal for stages with the same expressions: inner ones of take-off and landing are."""
    # The phase as such does not enter an expression, nor which interval of it this is.
    kind = replace(role, phase=0, first=False, last=False, final=False)
    names = layout.states(role), layout.controls(role)
    states = None
    if following is not None:
        sets = following.standing, following.in_air
        states = layout.states(following), sets
    return kind, names, states, tuple(cost.applies(role) for cost in COSTS), constraints_of(role)


def make_problem(layout: Layout, task: Task) -> Problem:
    """A task's numbers."""
    lower, upper = row_bounds(layout, task)
    return Problem(np.concatenate(list(parameters(layout, task).values())), lower, upper)


def row_bounds(layout: Layout, task: Task) -> tuple[Array, Array]:
    """Lower and upper bounds of g for a task, (rows,): gaps, then each stage's constraints."""
    *_, lower, upper = _listed(layout, task)
    return lower.copy(), upper.copy()


def row_places(layout: Layout, task: Task) -> tuple[dict[Hashable, NDArray[Any]], NDArray[Any]]:
    """Places of the rows of g by the constraint that they are of, and each row's knot."""
    places, knot, *_ = _listed(layout, task)
    return places, knot


@lru_cache(maxsize=2)
def _listed(
    layout: Layout, task: Task
) -> tuple[dict[Hashable, NDArray[Any]], NDArray[Any], Array, Array]:
    """Places of the rows by what they are; of all rows their knots, lower and upper bounds."""
    keys, knots, lower, upper = zip(*_rows(layout, task), strict=True)
    sizes = [len(low) for low in lower]
    numbers = {key: number for number, key in enumerate(dict.fromkeys(keys))}
    owner = np.repeat([numbers[key] for key in keys], sizes)
    places = {key: np.flatnonzero(owner == number) for key, number in numbers.items()}
    knot = np.repeat(np.array(knots), sizes)
    return places, knot, np.concatenate(lower), np.concatenate(upper)


def _rows(layout: Layout, task: Task) -> Iterator[tuple[Hashable, int, Array, Array]]:
    """The rows of g in their order: what they are, the knot, lower and upper bounds."""
    for role, knots in layout.blocks():
        constraints = constraints_of(role)
        differ = {c for c in constraints if c.by_knot or c.name in task.agreed_bounds}
        alike = {c: c.bounds(task, layout, knots[0]) for c in constraints if c not in differ}
        for knot in knots:
            if not role.terminal:
                yield DYNAMICS, knot, _BODY, _BODY
                following = layout.roles[knot + 1]
                for name in layout.states(following):
                    if name not in BODY:
                        gap = np.zeros(layout.size(name, following))
                        yield name, knot, gap, gap
            for constraint in constraints:
                yield (
                    constraint,
                    knot,
                    *(alike.get(constraint) or constraint.bounds(task, layout, knot)),
                )


def evaluated_rows(
    layout: Layout, g: Callable[[Array, Array], Array], task: Task, w: Array
) -> dict[Hashable, RowValues]:
    """Values of all rows of g under a task, as `Knots.rows` has them.

    Args:
        layout: of the variables.
        g: rows of variables and parameters, as the solver evaluates them.
        task: whose parameters and bounds count.
        w: all variables.
    """
    places, knot, low, high = _listed(layout, task)
    values = g(w, np.concatenate([*parameters(layout, task).values()]))
    return {
        key: RowValues(values[mine], low[mine], high[mine], knot[mine])
        for key, mine in places.items()
    }


def rolled_out(layout: Layout, evaluate: Callable[[Array], RowValues], w: Array) -> Array:
    """The same forces and rates, with r, H and L integrated from the start.

    A solver leaves defects of its tolerance; so they all show at the end, against the target.

    Args:
        layout: of the variables.
        evaluate: variables -> rows of the `DYNAMICS`.
        w: all variables.
    """
    w = layout.normalised(w)
    # Positions follow from velocities, and momenta from positions.
    for name in ("velocity", "position", "momentum"):
        gaps = evaluate(w).values.reshape(-1, len(_BODY))[:, BODY_PLACES[name]]
        w[layout.places(name)] -= np.cumsum(gaps, axis=0)
    return w

"""Problem in, solution out: interior-point solvers through CasADi's nlpsol, chosen by name.

Adding one is one module here, and its class in `_SOLVERS`.
"""

from llsrbm.ocp.fatrop_patches import WITHIN
from llsrbm.ocp.solvers.base import FROM_GUESS, MAX_FOLLOW_MISS, SolveOptions, Solver
from llsrbm.ocp.solvers.fatrop import Fatrop
from llsrbm.ocp.solvers.ipopt import Ipopt
from llsrbm.request.messages import look_up

__all__ = [
    "FROM_GUESS",
    "MAX_FOLLOW_MISS",
    "WITHIN",
    "Fatrop",
    "Ipopt",
    "SolveOptions",
    "Solver",
    "by_name",
    "names",
]

_SOLVERS: dict[str, type[Solver]] = {solver.name: solver for solver in (Fatrop, Ipopt)}


def names() -> tuple[str, ...]:
    """The solvers' names, the default first."""
    return tuple(_SOLVERS)


def by_name(name: str) -> type[Solver]:
    """The solver called `name`. Raises `InputError`: no solver has that name."""
    return look_up("solver", name, _SOLVERS)

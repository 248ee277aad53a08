"""Planners and others that hold solvers are kept for the next request, within a bound of memory.

A solver takes 100 to 450 MB of a process with all that its solves leave behind. Planners,
replanners' formulations and refiners are kept in one list, the last used; what has not been used
for longest goes first.
"""

import ctypes
import gc
import logging
import os
import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from typing import Protocol, TypeVar, cast

from llsrbm.ocp.solvers import Solver

_log = logging.getLogger(__name__)

MOST = 650.0
"""MB of all solvers that are kept; the last used holder stays, whatever it takes."""


class Holder(Protocol):
    """An object that holds solvers."""

    @property
    def solvers(self) -> tuple[Solver, ...]:
        """All that it holds."""


Kind = TypeVar("Kind", bound=Holder)

_holders: OrderedDict[Hashable, Holder] = OrderedDict()  # the last used at the end
_lock = threading.RLock()


def kept(key: Hashable, make: Callable[[], Kind]) -> Kind:
    """The holder that was made for a key, or a new one."""
    with _lock:
        found = _holders.get(key)
        if found is not None:
            _holders.move_to_end(key)
            make_room()  # solvers grow as they are used
            return cast("Kind", found)
    made = make()
    with _lock:
        _holders[key] = made
        _holders.move_to_end(key)
        make_room()
    return made


def make_room(more: float = 0.0) -> None:
    """Drop holders, those not used for longest first, until `more` MB fit in beside the others."""
    with _lock:
        dropped = 0
        while len(_holders) > 1 and size() + more > MOST:
            _holders.popitem(last=False)
            dropped += 1
    if dropped:
        _log.info("%d planners were dropped to make room for others", dropped)
        give_back()


def size() -> float:
    """MB of the solvers that are kept."""
    with _lock:
        return sum(solver.megabytes for each in _holders.values() for solver in each.solvers)


def give_back() -> None:
    """Return memory that nothing uses any more to the system; glibc holds on to it by itself."""
    gc.collect()  # CasADi's callbacks and what they refer to are cycles
    library = ctypes.CDLL(None) if os.name == "posix" else None
    trim = getattr(library, "malloc_trim", None)
    if trim is not None:
        trim(0)

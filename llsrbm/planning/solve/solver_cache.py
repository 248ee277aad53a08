"""Solvers are built once on a machine, some ten seconds each: the cache has text and a library."""

import logging
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path
from weakref import WeakKeyDictionary

import casadi as ca

from llsrbm.abandon import go_on
from llsrbm.cache import cache_path, cached_bytes, content_key
from llsrbm.models.base import CentroidalModel
from llsrbm.ocp import fatrop_patches
from llsrbm.ocp.compiled import Library, c_files, compiler, packed
from llsrbm.ocp.horizon import Horizon
from llsrbm.ocp.progress import solving
from llsrbm.ocp.solvers import Solver
from llsrbm.ocp.transcription import MEMORY_OF_TEXT, Transcribed, Transcription
from llsrbm.planning.problem.jump_horizon import make_horizon
from llsrbm.planning.problem.layout import Layout
from llsrbm.planning.solve.kept import give_back, make_room
from llsrbm.robots.robot import Robot

_log = logging.getLogger(__name__)

_PACKAGE = Path(__file__).parents[2]

# Modules on which the functions of a solver depend, beside the problem's expressions.
_MAKERS = tuple(
    f"ocp/{name}.py"
    for name in (
        *("horizon", "lifting", "derivatives", "composition"),
        *("stage_functions", "transcription"),
    )
)
_PIECE = 2**20
BUILDING = 450.0  # MB that building a solver takes for a while: 210 of ANYmal's, 450 of G1's draft

# Of solvers that work without one so far.
_libraries: WeakKeyDictionary[Solver, Library] = WeakKeyDictionary()


def is_compiling(solver: Solver) -> bool:
    """True while a solver is being compiled: until then it takes about twice as long."""
    library = _libraries.get(solver)
    return library is not None and library.is_in_work()


@dataclass(frozen=True, eq=False)
class Subject:
    """A problem of which there is a solver.

    Attributes:
        of, variant: the robot and model, and the layout, in the cache's names; title: for people.
        numbers: all that its expressions depend on, beside the package.
    """

    of: str
    variant: str
    title: str
    numbers: str
    horizon: Callable[[], Horizon]


def of_jumps(model: CentroidalModel, layout: Layout, robot: Robot) -> Subject:
    """A model's jumps."""
    return Subject(
        of=f"{robot.name}-{model.name}",
        variant=layout.name,
        title=f"{model.name} solver of {robot.name}",
        numbers=repr((robot.parameters(), model.numbers(), layout)),
        horizon=lambda: make_horizon(model, layout),
    )


def cached_solver(kind: type[Solver], subject: Subject) -> Solver:
    """A problem's solver, from the cache if it is there, compiled if that is there.

    Otherwise, where there is a compiler, it is compiled in the background, and the solver takes
    what comes of it in the first solve after that.
    """
    with solving:
        return _cached_solver(kind, subject)


def _cached_solver(kind: type[Solver], subject: Subject) -> Solver:
    horizon = cache(subject.horizon)  # for its fingerprint, and what is made of it

    @cache
    def transcription() -> Transcription:
        _log.info("building the %s, once on this machine", subject.title)
        make_room(BUILDING)
        return Transcription(horizon())

    @cache
    def text() -> str:
        found = transcription().serialize()
        go_on()
        return found

    name, key = _entry(replace(subject, horizon=horizon))
    key_in_c = content_key(key, sources("ocp/compiled.py"))
    tool = compiler() if kind.compiled else None
    source, library = b"", None
    if tool is not None:
        fatrop_patches.load(tool)
        library = Library(cache_path(name, content_key(key_in_c, tool.identity), ".so"))
        if (loaded := library.load()) is not None:
            return kind(loaded)
    stored = cached_bytes(name, key, ".casadi.z", lambda: _compressed(text()))
    if library is not None:
        source = cached_bytes(name, key_in_c, ".c.z", lambda: packed(c_files(transcription())))
    if text.cache_info().currsize:
        made, megabytes = transcription(), MEMORY_OF_TEXT * len(text())
        transcribed = Transcribed(made.functions, made.structure, megabytes)
    else:
        transcribed = Transcribed.deserialize(zlib.decompress(stored).decode("ascii"))
    if horizon.cache_info().currsize:
        for each in (horizon, transcription, text):
            each.cache_clear()
        give_back()
    make_room(transcribed.megabytes)
    solver = kind(transcribed)
    if tool is not None and library is not None:
        library.compile(tool, source)
        solver.replace_by(library.load, library.wait)
        _libraries[solver] = library
    return solver


def _compressed(text: str) -> bytes:
    """Piece by piece: no second copy of a text of some 150 MB."""
    packer = zlib.compressobj(level=1)
    pieces = (text[k : k + _PIECE].encode("ascii") for k in range(0, len(text), _PIECE))
    return b"".join([*map(packer.compress, pieces), packer.flush()])


def is_built(subject: Subject) -> bool:
    """Whether the cache has a solver, so that it takes next to no time."""
    with solving:
        name, key = _entry(subject)
        return cache_path(name, key, ".casadi.z").exists()


def _entry(subject: Subject) -> tuple[str, bytes]:
    """Name and key of a problem in the cache, which is the same whatever solves it."""
    name = f"solver-{subject.of}-{subject.variant}"
    numbers, ours = _fingerprint(name, subject), (sources(module) for module in _MAKERS)
    return name, content_key(ca.__version__, *ours, numbers)


def _fingerprint(name: str, subject: Subject) -> bytes:
    """Fingerprint of the problem's expressions, wherever their numbers come from.

    To build them takes some seconds, so it is kept under all that they may depend on:
    every line of the package, and the numbers of robot and model.
    """
    key = content_key(ca.__version__, sources(), subject.numbers)
    return cached_bytes(name, key, ".key", lambda: subject.horizon().fingerprint().encode("ascii"))


@lru_cache
def sources(module: str = "") -> bytes:
    """Key of all modules of the package, or of one of them."""
    modules = [_PACKAGE / module] if module else sorted(_PACKAGE.rglob("*.py"))
    return content_key(*(str(path.relative_to(_PACKAGE)) for path in modules), *modules)

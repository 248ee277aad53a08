"""Solvers are built once on a machine, half a minute each: the cache has text and a library."""

from __future__ import annotations

import ast
import logging
import zlib
from collections.abc import Iterator
from functools import cache, lru_cache
from pathlib import Path

import casadi as ca

from llsrbm.cache import cache_path, cached_bytes, content_key, program
from llsrbm.models.base import CentroidalModel
from llsrbm.ocp.c_code import NotInC, c_files
from llsrbm.ocp.compiled import Library, compiler, packed
from llsrbm.ocp.direction_guard import load_guard
from llsrbm.ocp.kernel import load_kernel
from llsrbm.ocp.solvers import Solver
from llsrbm.ocp.transcription import Transcription
from llsrbm.planning.problem.horizon import make_horizon
from llsrbm.planning.problem.layout import Layout
from llsrbm.robots.robot import Robot

_log = logging.getLogger(__name__)

_PACKAGE = Path(__file__).parents[2]
# A solver depends on this module and what it imports of these rooms. Beyond them it sees numbers.
_ROOMS = tuple(f"{_PACKAGE.name}.{room}." for room in ("models", "ocp", "planning"))


def cached_solver(
    kind: type[Solver], model: CentroidalModel, layout: Layout, robot: Robot
) -> Solver:
    """The solver of a model's jumps, from the cache if it is there, compiled if that is there.

    Otherwise, where there is a compiler, it is compiled in the background, and the solver takes
    what comes of it in the first solve after that.
    """

    @cache
    def transcription() -> Transcription:
        _log.info("building the %s solver of %s, once on this machine", model.name, robot.name)
        return Transcription(make_horizon(model, layout))

    def text() -> bytes:
        solver = kind.build(transcription())
        return zlib.compress(solver.serialize().encode("ascii"), level=1)

    key = content_key(
        ca.__version__,
        f"{kind.name} {model.name} {layout}",
        repr(robot.parameters()),
        repr(model.numbers()),
        *programs(),
    )
    name = f"solver-{robot.name}-{model.name}-{kind.name}-{layout.name}"
    library, tool = None, compiler() if kind.compiled else None
    if tool is not None:
        load_guard(tool)
        load_kernel(tool)
        library = Library(cache_path(name, content_key(key, tool.identity), ".so"))
        if (loaded := library.load()) is not None:
            return kind.build(loaded)
    stored = cached_bytes(name, key, ".casadi.z", text)
    solver = kind.deserialize(zlib.decompress(stored).decode("ascii"))
    if tool is not None and library is not None:
        try:
            source = cached_bytes(name, key, ".c.z", lambda: packed(c_files(transcription())))
        except NotInC as error:
            _log.info("the solver is not compiled: %s", error)
        else:
            library.compile(tool, source)
            solver.replace_by(library.load, library.wait)
    return solver


@lru_cache(maxsize=1)
def programs() -> tuple[str, ...]:
    """Of the modules on which a solver depends: all models, and what this module imports."""
    paths = {*(_PACKAGE / "models").rglob("*.py")}
    pending = {Path(__file__), *paths}
    while pending:
        path = pending.pop()
        paths.add(path)
        pending |= {*_imported(path)} - paths
    return tuple(program(path) for path in sorted(paths))


def _imported(path: Path) -> Iterator[Path]:
    """Modules of the rooms that a module imports to run, not for types alone."""
    pending: list[ast.AST] = [ast.parse(path.read_text(encoding="utf-8"))]
    while pending:
        node = pending.pop()
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            continue
        for block in ("body", "orelse", "handlers", "finalbody"):
            pending += getattr(node, block, [])
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        for name in names:
            yield from _files(name)


def _files(name: str) -> Iterator[Path]:
    """Of a module of the rooms, with the package's own that it is in; of another name, none."""
    if not f"{name}.".startswith(_ROOMS):
        return
    place = _PACKAGE.joinpath(*name.split(".")[1:])
    for path in (place.with_suffix(".py"), place / "__init__.py", place.parent / "__init__.py"):
        if path.is_file() and path.parent != _PACKAGE:
            yield path

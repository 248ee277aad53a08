"""Solvers are built once on a machine, half a minute each: the cache has text and a library."""

from __future__ import annotations

import logging
import zlib
from functools import cache, lru_cache
from pathlib import Path

import casadi as ca

from llsrbm.cache import cache_path, cached_bytes, content_key
from llsrbm.models.base import CentroidalModel
from llsrbm.ocp import fatrop_patches
from llsrbm.ocp.compiled import Library, c_files, compiler, packed
from llsrbm.ocp.progress import solving
from llsrbm.ocp.solvers import Solver
from llsrbm.ocp.transcription import Transcription
from llsrbm.planning.problem.horizon import make_horizon
from llsrbm.planning.problem.layout import Layout
from llsrbm.robots.robot import Robot

_log = logging.getLogger(__name__)

_PACKAGE = Path(__file__).parents[2]


def cached_solver(
    kind: type[Solver], model: CentroidalModel, layout: Layout, robot: Robot
) -> Solver:
    """The solver of a model's jumps, from the cache if it is there, compiled if that is there.

    Otherwise, where there is a compiler, it is compiled in the background, and the solver takes
    what comes of it in the first solve after that.
    """
    with solving:
        return _cached_solver(kind, model, layout, robot)


def _cached_solver(
    kind: type[Solver], model: CentroidalModel, layout: Layout, robot: Robot
) -> Solver:
    @cache
    def transcription() -> Transcription:
        _log.info("building the %s solver of %s, once on this machine", model.name, robot.name)
        return Transcription(make_horizon(model, layout))

    def text() -> bytes:
        solver = kind(transcription())
        return zlib.compress(solver.serialize().encode("ascii"), level=1)

    name = f"solver-{robot.name}-{model.name}-{kind.name}-{layout.name}"
    key = content_key(
        ca.__version__, kind.name, sources("ocp"), _fingerprint(name, model, layout, robot)
    )
    library, tool = None, compiler() if kind.compiled else None
    if tool is not None:
        fatrop_patches.load(tool)
        library = Library(cache_path(name, content_key(key, tool.identity), ".so"))
        if (loaded := library.load()) is not None:
            return kind(loaded)
    stored = cached_bytes(name, key, ".casadi.z", text)
    solver = kind.deserialize(zlib.decompress(stored).decode("ascii"))
    if tool is not None and library is not None:
        library.compile(
            tool, cached_bytes(name, key, ".c.z", lambda: packed(c_files(transcription())))
        )
        solver.replace_by(library.load, library.wait)
    return solver


def _fingerprint(name: str, model: CentroidalModel, layout: Layout, robot: Robot) -> bytes:
    """Of the problem's expressions, wherever their numbers come from.

    To build them takes a quarter of a second, so it is kept under all that they may depend on:
    every line of the package, and the numbers of robot and model.
    """
    numbers = repr((robot.parameters(), model.numbers(), layout))
    key = content_key(ca.__version__, sources(), numbers)
    return cached_bytes(
        name, key, ".key", lambda: make_horizon(model, layout).fingerprint().encode("ascii")
    )


@lru_cache
def sources(room: str = "") -> bytes:
    """Key of all modules of the package, or of one of its rooms."""
    modules = sorted((_PACKAGE / room).rglob("*.py"))
    return content_key(*(str(path.relative_to(_PACKAGE)) for path in modules), *modules)

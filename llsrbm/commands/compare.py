"""`llsrbm compare`."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from llsrbm.commands import console, options
from llsrbm.errors import printable

if TYPE_CHECKING:
    from collections.abc import Sequence

    from llsrbm.analysis.figures import DesignFigures
    from llsrbm.motion.trajectory import Trajectory
    from llsrbm.motion.whole_body import WholeBodyMotion

_WIDEST = 10_000  # characters of a line


def compare_command(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Native files, or other tools' (`llsrbm formats`)."),
    ],
    robot: options.Mover = "anymal",
    fps: options.Fps = None,
    as_json: options.AsJson = False,
) -> int:
    """Print the figures of plans, simulations and other motions beside each other, a row a file.

    A plan's figures are of the planned motion, a simulation's of the whole body; another tool's are
    those that follow from how the robot moves. Where all are of one kind, the best of a
    column has an asterisk; what fell or did not converge has none.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.formats import load_any, remarks_of
        from llsrbm.motion.trajectory import json_value

        motions = [load_any(file, robot, fps) for file in files]
        for file, motion in zip(files, motions, strict=True):
            console.print_remarks(f"{file}: {remark}" for remark in remarks_of(motion))
        rows, titles = [_row(motion) for motion in motions], _titles(motions)
        if as_json:
            designs: list[dict[str, Any]] = [
                {"file": str(file), "title": title, "request": _request(motion), **asdict(row)}
                for file, title, motion, row in zip(files, titles, motions, rows, strict=True)
            ]
            print(json.dumps({"designs": json_value(designs)}, allow_nan=False), file=stdout)
        else:
            of_one_kind = len({type(motion) for motion in motions}) == 1
            for line in _table([str(file) for file in files], titles, rows, mark=of_one_kind):
                # A stranger's file may hold what would control the terminal.
                print(printable(line, _WIDEST), file=stdout)
    return console.DONE


def _row(motion: Trajectory | WholeBodyMotion) -> DesignFigures:
    from llsrbm.analysis.figures import figures_of_motion, figures_of_plan, figures_of_rollout
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout

    if isinstance(motion, Plan):
        return figures_of_plan(motion)
    return figures_of_rollout(motion) if isinstance(motion, Rollout) else figures_of_motion(motion)


def _titles(motions: Sequence[Trajectory | WholeBodyMotion]) -> list[str]:
    from llsrbm.look.titles import Decisions, titles_of
    from llsrbm.motion.plan import Plan
    from llsrbm.motion.rollout import Rollout

    designs: list[Decisions] = []
    for motion in motions:
        if isinstance(motion, Plan):
            designs.append((motion.jump, motion.tuning, None))
        elif isinstance(motion, Rollout):
            designs.append((motion.jump, motion.plan.tuning, motion.scenario))
    named = iter(titles_of(designs))
    return [next(named) if isinstance(m, Plan | Rollout) else m.origin for m in motions]


def _request(motion: Trajectory | WholeBodyMotion) -> dict[str, Any] | None:
    from llsrbm.motion.whole_body import WholeBodyMotion

    return None if isinstance(motion, WholeBodyMotion) else motion.jump.as_dict()


def _table(
    files: Sequence[str], titles: Sequence[str], rows: Sequence[DesignFigures], *, mark: bool
) -> list[str]:
    """Head of two lines, names and units, and a line a design; figures to the right."""
    from llsrbm.analysis.figure_table import FIGURES

    columns = [["file", "", *files], ["design", "", *titles], ["", "", *(r.status for r in rows)]]
    lines = [[f"{cell:<{max(map(len, column))}}" for cell in column] for column in columns]
    for figure in FIGURES:
        best = figure.best(rows) if mark else frozenset()
        # The asterisk stands behind the number, so that numbers stay below each other.
        cells = [
            f"{figure.shown(row)}{'*' if index in best else ' '}" for index, row in enumerate(rows)
        ]
        column = [f"{figure.short} ", f"{figure.unit} ", *cells]
        lines.append([f"{cell:>{max(map(len, column))}}" for cell in column])
    return ["  ".join(cells).rstrip() for cells in zip(*lines, strict=True)]

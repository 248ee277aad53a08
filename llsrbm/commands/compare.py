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

_WIDEST = 10_000  # characters of a line


def compare_command(
    files: Annotated[list[Path], typer.Argument(metavar="FILE.npz...", help="Native files.")],
    as_json: options.AsJson = False,
) -> int:
    """Print the figures of plans and simulations beside each other, a row a file.

    A plan's file tells what was planned, a simulation's what the whole body did. Where all are of
    one kind, the best of a column has an asterisk; what fell or did not converge has none.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.analysis.figures import figures_of_plan, figures_of_rollout
        from llsrbm.motion.description import json_value
        from llsrbm.motion.files import load
        from llsrbm.motion.plan import Plan
        from llsrbm.titles import titles_of
        from llsrbm.tuning import Tuning

        trajectories = [load(file) for file in files]
        rows = [
            figures_of_plan(t) if isinstance(t, Plan) else figures_of_rollout(t)
            for t in trajectories
        ]
        titles = titles_of(
            [
                (t.jump, t.tuning, None) if isinstance(t, Plan) else (t.jump, Tuning(), t.scenario)
                for t in trajectories
            ]
        )
        if as_json:
            designs: list[dict[str, Any]] = [
                {"file": str(file), "title": title, "request": t.jump.as_dict(), **asdict(row)}
                for file, title, t, row in zip(files, titles, trajectories, rows, strict=True)
            ]
            print(json.dumps({"designs": json_value(designs)}, allow_nan=False), file=stdout)
        else:
            of_one_kind = len({type(t) for t in trajectories}) == 1
            for line in _table([str(file) for file in files], titles, rows, mark=of_one_kind):
                # A stranger's file may hold what would control the terminal.
                print(printable(line, _WIDEST), file=stdout)
    return console.DONE


def _table(
    files: Sequence[str], titles: Sequence[str], rows: Sequence[DesignFigures], *, mark: bool
) -> list[str]:
    """Head of two lines, names and units, and a line a design; figures to the right."""
    from llsrbm.analysis.figures import FIGURES

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

"""`llsrbm dataset`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from llsrbm.commands import console, options


def dataset_command(
    sweep: Annotated[
        Path, typer.Argument(metavar="DIR", help="What `llsrbm sweep` wrote, with simulations.")
    ],
    format_: Annotated[
        str,
        typer.Option("--format", metavar="F", help="lerobot, or one of `llsrbm formats`."),
    ],
    out: Annotated[Path, typer.Option(metavar="OUT", help="Folder of the data set.")],
    robot: Annotated[str | None, typer.Option(help="Motions of this robot alone.")] = None,
    source: Annotated[
        str, typer.Option(help="rollout: what the robot did; plan: what was planned.")
    ] = "rollout",
    limit: Annotated[int | None, typer.Option(metavar="N", help="Motions at most.")] = None,
    fps: Annotated[
        float | None, typer.Option(help="Frames per second [default: the format's own].")
    ] = None,
    as_json: options.AsJson = False,
) -> int:
    """Write the strict jumps of a sweep as files for training, with an index.

    Motions are computed again from the sweep's table. A data set that was cut off goes on where it
    was: run the same command again.
    """
    with console.result_stream(as_json=as_json) as stdout:
        from llsrbm.sweep.dataset import make_dataset

        with console.counting("motions") as progress:
            done = make_dataset(
                sweep,
                out,
                format_,
                robot=robot,
                source=source,
                limit=limit,
                fps=fps,
                progress=progress,
            )
        if done.left_out:
            console.print_error(
                f"{len(done.left_out)} rows are not strict when computed again, and are left out: "
                f"{', '.join(map(str, done.left_out[:10]))}"
            )
        result = {
            "motions": done.motions,
            "computed": done.computed,
            "left_out": list(done.left_out),
            "index": str(done.index),
        }
        motions = f"{done.motions}, of them {done.computed} computed now"
        lines = {"motions": motions, "index": str(done.index)}
        console.print_result(result, lines, stdout, as_json=as_json)
    return console.DONE

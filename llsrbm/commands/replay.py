"""`llsrbm replay`."""

from __future__ import annotations

import tempfile
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from llsrbm.commands import console


def replay_command(
    file: Annotated[Path, typer.Argument(metavar="FILE.npz", help="A native file.")],
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE.html", help="Where to; default: a temporary file."),
    ] = None,
    open_: Annotated[
        bool, typer.Option("--open/--no-open", help="Open it in the default browser.")
    ] = True,
) -> int:
    """Look at a plan or a rollout in the browser: one page, without a server.

    Prints the page's path. It stays where it is and may be passed on.
    """
    from llsrbm.formats import export
    from llsrbm.formats.exporting import stem
    from llsrbm.motion.trajectory import load

    trajectory = load(file)
    if out is None:
        out = Path(tempfile.mkdtemp(prefix="llsrbm-")) / f"{stem(trajectory)}.html"
    export(trajectory, out, format="html")
    out = out.resolve()
    print(out)
    if open_ and not webbrowser.open(out.as_uri()):
        console.complain(f"no browser was found; expected one that opens {out}")
        return console.FAILED
    return console.DONE

"""`llsrbm serve`, found by the command line through the entry points "llsrbm.commands"."""

from __future__ import annotations

from contextlib import closing
from typing import Annotated

import typer


def serve(
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port; 0 takes any free one.")] = 8080,
    allow_host: Annotated[
        list[str] | None,
        typer.Option(help="Further name under which browsers may reach the page; repeatable."),
    ] = None,
) -> None:
    """Serve the designer, a page where jumps are planned and looked at, until Ctrl-C."""
    from app.worker_pool import WorkerPool

    # Its first process imports CasADi and loads a solver while this one imports the page.
    with closing(WorkerPool()) as pool:
        from app.server import serve as serve_designer

        serve_designer(host, port, allowed_hosts=allow_host or (), pool=pool)

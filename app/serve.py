"""`llsrbm serve`, found by the command line through the entry points "llsrbm.commands"."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.signals import stop_on_signal

if TYPE_CHECKING:
    from app.workers.opened_file import OpenedFile


_Token = Annotated[
    str | None,
    typer.Option(
        metavar="TOKEN|none",
        envvar="LLSRBM_TOKEN",
        help="Needed to enter; generated at each start by default, printed in the page's "
        "address. An option is seen in the list of processes, the variable is not.",
    ),
]
_Hosts = Annotated[
    list[str] | None,
    typer.Option(help="Further name under which browsers may reach the page; repeatable."),
]
_Proxies = Annotated[
    list[str] | None,
    typer.Option(
        metavar="ADDRESS",
        help="Reverse proxy, or network of such, whose X-Forwarded-For says who visits; "
        "repeatable.",
    ),
]
_File = Annotated[
    Path | None,
    typer.Option(
        "--open", metavar="FILE", help="A design, plan, simulation or motion to begin with."
    ),
]
_Rate = Annotated[
    float | None, typer.Option(help="Frames per second of such a file, if it does not say.")
]
_Workers = Annotated[
    int | None,
    typer.Option(
        help="Computing processes, some 0.3 GB each; by default as many as this machine has "
        "cores, from 2 to 4."
    ),
]
_Atlases = Annotated[
    list[Path] | None,
    typer.Option(metavar="DIR", help="A sweep for the page's atlas; repeatable."),
]


def serve(
    host: Annotated[str, typer.Option(help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(help="Port; 0 takes any free one.")] = 8080,
    allow_host: _Hosts = None,
    proxy: _Proxies = None,
    token: _Token = None,
    token_file: Annotated[
        Path | None, typer.Option(metavar="FILE", help="A file that holds the token.")
    ] = None,
    browser: Annotated[
        bool, typer.Option(help="Open the page in a browser, where there is a display.")
    ] = True,
    open_: _File = None,
    robot: Annotated[
        str | None,
        typer.Option(
            metavar="R",
            help=f"Robot of the motion, if FILE is another tool's [default: {Jump().robot}].",
        ),
    ] = None,
    fps: _Rate = None,
    workers: _Workers = None,
    scheduler: Annotated[str | None, typer.Option(hidden=True)] = None,
    atlas: _Atlases = None,
) -> None:
    """Serve the designer, a page where jumps are planned and shown, until Ctrl-C."""
    with stop_on_signal() as stop:
        from app.workers.crew import MOST_PROCESSES, PROCESSES
        from app.workers.pool import WorkerPool

        if workers is not None and not 1 <= workers <= MOST_PROCESSES:
            raise InputError(f"--workers: expected 1 to {MOST_PROCESSES}, got {workers}")
        if scheduler is not None:
            raise InputError(
                "--scheduler: the page computes on this machine alone; expected --workers N for "
                "more processes (llsrbm sweep takes --scheduler)"
            )
        file = _opened(open_, robot, fps)
        # Its first process imports CasADi and loads a solver while this one imports the page.
        with closing(WorkerPool(processes=workers or PROCESSES)) as pool:
            from app.designer import serve as serve_designer
            from app.tab.atlas import Atlases

            serve_designer(
                host,
                port,
                stop,
                allowed_hosts=allow_host or (),
                proxies=proxy or (),
                token=token if token_file is None else _token_in(token_file, token),
                pool=pool,
                file=file,
                atlases=Atlases(atlas or ()),
                browser=browser,
            )


def _token_in(path: Path, other: str | None) -> str:
    """The token in a file, if it can be read and there is no other token."""
    if other is not None:
        raise InputError("--token-file: expected no --token or LLSRBM_TOKEN beside it")
    try:
        return path.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"--token-file: {path}: cannot be read ({error})") from error


def _opened(path: Path | None, robot: str | None, fps: float | None) -> OpenedFile | None:
    """The content of a file, if it can be opened, its robot ready to be drawn; None: no file."""
    if path is None:
        for name, value in (("--robot", robot), ("--fps", fps)):
            if value is not None:
                raise InputError(
                    f"{name}: is of the motion in a file; expected --open FILE beside it (the "
                    "page's own robot is chosen in the page)"
                )
        return None
    robot = Jump().robot if robot is None else robot
    from app.workers.tasks import OpenFile
    from app.workers.worker import LibraryPlanner
    from llsrbm.robots import names

    if robot not in names():
        raise InputError(f"--robot: expected one of {', '.join(names())}, got {robot!r:.80}")
    try:
        if path.exists() and not path.is_file():
            raise InputError(f"--open: {path}: expected a file")
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"--open: {path}: cannot be read ({error.strerror})") from error
    return LibraryPlanner().open(OpenFile(path.name, content, robot, fps), lambda *_, **__: None)

"""The server: binds an address or raises an error, runs a session for each tab, ends cleanly."""

import contextlib
import errno
import ipaddress
import os
import shutil
import socket
import sys
import tempfile
import threading
import webbrowser
from collections.abc import Collection
from pathlib import Path
from typing import Any

import viser

from app.guard.limits import Limits
from app.guard.policy import Guard
from app.guard.start_check import check
from app.guard.token import NONE, Access
from app.page_template import page
from app.panel.view_controls import configure_theme
from app.picture.bounds import extents
from app.picture.lighting import configure_world
from app.picture.robot_nodes import meshes
from app.tab.atlas import Atlases
from app.tab.session import Session
from app.tab.start.initial_plan import InitialPlans, example
from app.tab.tabs import Tabs
from app.viser_private import DesignerServer
from app.workers.opened_file import OpenedFile
from app.workers.pool import WorkerPool
from app.workers.reports import Failed, Planned, Prepared, Progress, Refused, Report
from app.workers.tasks import LoadSolver, PlanJump, PlannerFactory, Prepare
from app.workers.worker import LibraryPlanner
from llsrbm import models
from llsrbm.errors import InputError
from llsrbm.ocp.compiled import ENVIRONMENT_VARIABLE
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot, read_robot_file
from llsrbm.robots.schema import robot_files

_BROWSER_STARTS = 30.0
"""s until a browser that was just started has read the file that leads to the page."""


class Designer:
    """A running designer: the web server, the computing processes and the sessions of all tabs."""

    def __init__(
        self,
        host: str = "127.0.0.1",  # address or name of this machine to bind to
        port: int = 8080,  # 1 to 65535, or 0 for any free one
        *,
        # further names under which browsers may reach the page
        allowed_hosts: Collection[str] = (),
        proxies: Collection[str] = (),  # addresses and networks of trusted reverse proxies
        token: str | None = None,  # needed to enter; "none": anybody may; None: one is generated
        limits: Limits | None = None,  # of everything that visitors may do
        # computes, and is its maker's to close; None: one of its own, with this planner
        pool: WorkerPool | None = None,
        planner: PlannerFactory = LibraryPlanner,
        file: OpenedFile | None = None,  # with which every tab begins
        atlases: Atlases | None = None,  # of sweeps to choose from; None: what ships
    ) -> None:
        """Bind and let tabs in; raises as `serve`."""
        check_bindable(host, port)
        loopback = is_loopback(host)
        self._access = Access.chosen(token)
        names = {socket.gethostname(), host, *allowed_hosts}
        self._guard = Guard(self._access, names, loopback=loopback, proxies=proxies, limits=limits)
        self._server = DesignerServer(host, port, self._guard, page)
        self.port: int = self._server.get_port()
        self._access.port = self.port
        try:
            if port not in (0, self.port):
                raise _in_use(host, port)
            with self._guard.refusals.unlogged():
                check(host, self.port, token=self._access.required)
        except BaseException:
            self._server.stop()
            raise
        self.host = host
        self.open_to_all = not loopback and not self._access.required
        self._owns_pool = pool is None
        self.pool = pool or WorkerPool(planner)
        self.initial = InitialPlans(self.pool.planner, file, _on_compiler())
        files = {name: read_robot_file(path) for name, path in robot_files().items()}
        self.tabs = Tabs(
            self.pool,
            self.initial,
            files,
            atlases or Atlases(),
            most_kept=self._guard.limits.tabs,
        )
        _configure(self._server)
        self._server.on_client_connect(self.tabs.connect)
        self._server.on_client_disconnect(self.tabs.disconnect)

    @property
    def url(self) -> str:
        """Address of the page for a browser on this machine, with the token that opens it."""
        host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(self.host, self.host)  # noqa: S104
        if ":" in host and not host.startswith("["):
            host = f"[{host}]"
        return f"http://{host}:{self.port}{self._access.query}"

    @property
    def sessions(self) -> tuple[Session, ...]:
        """Sessions of the tabs that are open."""
        return self.tabs.sessions

    def warm_up(self, robot: str) -> None:
        """Prepare a robot, load the solver of every model, and show each step on the terminal."""
        first = example(robot)
        others = [name for name in models.MODELS if name != first.model]
        jumps = [Jump(robot=robot, model=name) for name in others]
        self.initial.recall(robot)
        if self.initial.note:
            _print(f"{self.initial.note} (apt-get install gcc libc6-dev, or CC=...)")

        last = ""

        def announce(report: Report) -> None:
            nonlocal last
            match report:
                case Progress() if report.text != last:
                    last = report.text
                    _print(f"  {last} ...")
                case Failed():
                    _print(f"  {report.message}")
                case Refused():
                    _print(f"  {report.reason}")
                case Prepared():
                    threading.Thread(target=_get_drawn, args=(robot,), daemon=True).start()
                case Planned() if report.plan.jump == first:
                    self.initial.keep(report.plan)

        tasks: list[Prepare | PlanJump] = [Prepare(robot), LoadSolver(first), *map(PlanJump, jumps)]
        self.pool.warm_up(tasks, announce, lambda: _print("ready"))

    def close(self) -> None:
        """End the sessions, the server and the computing processes that are its own."""
        self.tabs.close()
        self._server.stop()
        self._guard.refusals.summarise()
        if self._owns_pool:
            self.pool.close()


def serve(
    host: str, port: int, stop: threading.Event, *, browser: bool = False, **options: Any
) -> None:
    """Serve a `Designer` with these options until `stop` is set; its address is printed.

    With `browser` the page is opened in one, where there is a display.

    Raises:
        InputError: the address cannot be bound, the port is in use, or no such token can be.
        GuardMissing: the server would let in what it must refuse.
    """
    with contextlib.closing(Designer(host, port, **options)) as designer:
        print(f"llsrbm designer: {designer.url}", flush=True)
        if browser and _has_display():
            threading.Thread(target=_open, args=(designer.url, stop), daemon=True).start()
        if designer.open_to_all:
            _print(f"warning: --token {NONE}: anybody who reaches this address may use it")
        designer.warm_up(Jump().robot)
        stop.wait()


def check_bindable(host: str, port: int) -> None:
    """Raise `InputError` unless it can be bound: viser would take another port, or hang."""
    if not 0 <= port <= 65535:
        raise InputError(f"--port: expected 0 to 65535, got {port}")
    try:
        addresses = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
    except (socket.gaierror, UnicodeError) as error:
        raise InputError(f"--host: {host!r} is no address or name of this machine") from error
    for family, kind, protocol, _, address in addresses:
        with socket.socket(family, kind, protocol) as probe:
            # As the server itself does: a port that merely lingers after a restart is free.
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if family == socket.AF_INET6:
                probe.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
            try:
                probe.bind(address)
                probe.listen(1)
            except PermissionError as error:
                raise InputError(
                    f"--port: {port} needs more rights than this user has; try 1024 or above"
                ) from error
            except OSError as error:
                if error.errno == errno.EADDRINUSE:
                    raise _in_use(host, port) from error
                raise InputError(
                    f"--host: cannot listen on {host!r} ({error.strerror}); "
                    "expected an address of this machine, for example 127.0.0.1"
                ) from error


def is_loopback(host: str) -> bool:
    """True if only this machine reaches an address, or all that a name stands for."""
    found = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)
    addresses = (str(address[0]).partition("%")[0] for *_, address in found)
    return all(ipaddress.ip_address(address).is_loopback for address in addresses)


def _on_compiler() -> str:
    """The sentence on a C compiler that is missing; "": there is one, or it is switched off."""
    off = os.environ.get(ENVIRONMENT_VARIABLE) == "0"
    if off or shutil.which(os.environ.get("CC") or "cc"):
        return ""
    return "This server has no C compiler: planning takes twice as long as with one."


def _has_display() -> bool:
    shown = any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    return sys.stdout.isatty() and (shown or sys.platform == "darwin")


def _open(url: str, stop: threading.Event) -> None:
    """Open the page by a file of this user's, for the process list shows a browser's address."""
    with contextlib.suppress(Exception), tempfile.TemporaryDirectory(prefix="llsrbm-") as folder:
        page = Path(folder) / "designer.html"  # the folder is this user's alone
        page.write_text(f'<!doctype html><script>location.replace("{url}")</script>', "utf-8")
        webbrowser.open(page.as_uri())
        stop.wait(_BROWSER_STARTS)


def _get_drawn(robot: str) -> None:
    """Load what a tab draws of a robot, so that the first one need not wait for it."""
    loaded = load_robot(robot)
    meshes(loaded)
    extents(loaded)


def _print(line: str) -> None:
    """To the terminal, if it still listens: the server outlives `llsrbm serve 2>&1 | head`."""
    with contextlib.suppress(OSError):
        print(line, file=sys.stderr, flush=True)


def _in_use(host: str, port: int) -> InputError:
    return InputError(
        f"--port: {port} on {host} is in use; choose another with --port, or 0 for any free one"
    )


def _configure(server: viser.ViserServer) -> None:
    configure_theme(server.gui, dark=False)
    configure_world(server)
    server.gui.main_panel.dock_right()
    server.gui.set_panel_label("Jump designer")

"""Starting and ending: ports, addresses, signals, the terminal."""

import contextlib
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import pytest

import app.designer
from app.designer import Designer, check_bindable, serve
from llsrbm import cli
from llsrbm.errors import InputError
from llsrbm.request.jump import Jump
from llsrbm.signals import stop_on_signal
from tests.app import planners
from tests.app.planners import SyntheticPlanner
from tests.app.raw_http import asked
from tests.app.raw_tab import RawTab
from tests.app.waits import wait_until

PROGRAM = """
import sys
from app.designer import serve
from llsrbm.signals import stop_on_signal
from tests.app.planners import SyntheticPlanner
if __name__ == "__main__":
    with stop_on_signal() as stop:
        serve("127.0.0.1", int(sys.argv[1]), stop, planner=SyntheticPlanner)
"""


def children(pid):
    listed = subprocess.run(
        ["ps", "-o", "pid=,args=", "--ppid", str(pid)], capture_output=True, text=True, check=False
    )
    return [int(line.split()[0]) for line in listed.stdout.splitlines()]


def alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.fixture
def taken():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        yield listener.getsockname()[1]


def test_a_port_in_use_is_refused_not_replaced(taken):
    with pytest.raises(InputError, match=f"--port: {taken} on 127.0.0.1 is in use; choose another"):
        Designer(port=taken)


@pytest.mark.parametrize(
    ("host", "port", "message"),
    [
        ("127.0.0.1", 70000, "--port: expected 0 to 65535, got 70000"),
        ("127.0.0.1", -1, "--port: expected 0 to 65535, got -1"),
        ("192.0.2.1", 0, "--host: cannot listen on '192.0.2.1'"),
        ("no such name", 0, "--host: 'no such name' is no address or name of this machine"),
        ("nosuch.invalid", 0, "--host: 'nosuch.invalid' is no address or name of this machine"),
        ("a" * 70 + ".x", 0, "is no address or name of this machine"),
    ],
)
def test_an_address_that_cannot_be_bound_is_refused(host, port, message):
    with pytest.raises(InputError, match=re.escape(message)) as refused:
        check_bindable(host, port)
    assert "\n" not in str(refused.value)


def test_the_terminal_hears_of_steps_not_of_iterations(monkeypatch):
    lines, ready = [], threading.Event()

    def take(line, **_):
        lines.append(line)
        if line == "ready":
            ready.set()

    monkeypatch.setattr("builtins.print", take)
    monkeypatch.setattr("app.designer.example", lambda robot: Jump(twist=planners.ITERATING))
    with closing(Designer(port=0, planner=SyntheticPlanner)) as designer:
        designer.warm_up("anymal")
        assert ready.wait(30)
    assert lines == ["  preparing anymal ...", "  solving ...", "ready"]


@pytest.mark.parametrize(
    ("switch", "compiler", "noted"), [("1", "", 1), ("0", "", 0), ("1", "cc", 0)]
)
def test_a_missing_compiler_is_one_line_and_a_note_on_the_page(
    monkeypatch, tmp_path, capfd, switch, compiler, noted
):
    if compiler:
        (tmp_path / compiler).touch(mode=0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("LLSRBM_COMPILE", switch)
    monkeypatch.delenv("CC", raising=False)
    with closing(Designer(port=0, token="none", planner=SyntheticPlanner)) as designer:
        designer.warm_up("anymal")
        with RawTab(designer.port) as tab:
            tab.wait_for_status("Feasible")
            assert designer.sessions[0].state.note.count("no C compiler") == noted
    assert capfd.readouterr().err.count("This server has no C compiler: planning takes") == noted


TOKEN = "a-token-of_32-characters-exactly"


@pytest.mark.parametrize(
    ("host", "token", "address", "open_to_all"),
    [
        ("127.0.0.1", None, "127.0.0.1", False),
        ("::1", None, "[::1]", False),
        ("127.0.0.1", "none", "127.0.0.1", False),
        ("localhost", TOKEN, "localhost", False),
        ("0.0.0.0", None, "127.0.0.1", False),
        ("0.0.0.0", "none", "127.0.0.1", True),
    ],
)
def test_the_address_holds_the_token_unless_none_is_chosen(host, token, address, open_to_all):
    needed = token != "none"
    with closing(Designer(host, 0, token=token, planner=SyntheticPlanner)) as designer:
        base = f"http://{address}:{designer.port}"
        found = re.fullmatch(re.escape(base) + r"(?:/\?token=([\w-]{16,}))?", designer.url)
        assert bool(found[1]) is needed
        assert designer.open_to_all is open_to_all
        assert token != TOKEN or found[1] == TOKEN
        family = "::1" if ":" in host else "127.0.0.1"
        path = designer.url.removeprefix(base) or "/"
        answer = asked(designer.port, path, address=family, host=f"{address}:{designer.port}")
        assert answer.status == (303 if needed else 200)
        assert asked(designer.port, address=family).status == (401 if needed else 200)


@pytest.mark.parametrize("given", ["variable", "file", "both"])
def test_the_token_need_not_be_in_the_list_of_processes(monkeypatch, tmp_path, capfd, given):
    served = []
    monkeypatch.setattr("app.designer.serve", lambda *_, **options: served.append(options["token"]))
    monkeypatch.setattr("app.workers.pool.WorkerPool", lambda **_: SimpleNamespace(close=int))
    path = tmp_path / "token"
    path.write_text(TOKEN + "\n")
    if given != "file":
        monkeypatch.setenv("LLSRBM_TOKEN", TOKEN)
    arguments = [] if given == "variable" else ["--token-file", str(path)]
    status = cli.main(["serve", "--port", "0", *arguments])
    assert (status, served) == ((2, []) if given == "both" else (0, [TOKEN]))


def test_a_browser_is_led_to_the_page_by_a_file_of_this_user(monkeypatch):
    shown = []

    def show(address):
        path = Path(address.removeprefix("file://"))
        shown.append((address, path.parent.stat().st_mode & 0o077, path.read_text()))

    monkeypatch.setattr("webbrowser.open", show)
    stop = threading.Event()
    stop.set()
    app.designer._open(f"http://127.0.0.1:1/?token={TOKEN}", stop)
    ((address, rights, content),) = shown
    assert TOKEN not in address  # it is seen in the list of processes
    assert rights == 0
    assert f'"http://127.0.0.1:1/?token={TOKEN}"' in content
    monkeypatch.setattr("webbrowser.open", lambda _: 1 / 0)
    app.designer._open("http://127.0.0.1:1", stop)


def port_that_stays_free():
    """Below those that systems give to other tests' sockets between a stop and a start."""
    for port in range(21_000, 21_100):
        with socket.socket() as tried:
            if tried.connect_ex(("127.0.0.1", port)):
                return port
    raise AssertionError("no free port")


def test_a_fixed_token_lets_a_page_come_back_after_a_restart():
    port = port_that_stays_free()
    with closing(Designer(port=port, token=TOKEN, planner=SyntheticPlanner)):
        cookie = {"Cookie": asked(port, f"/?token={TOKEN}").cookie}
    with closing(Designer(port=port, token=TOKEN, planner=SyntheticPlanner)):
        assert asked(port, headers=cookie).status == 200
    with closing(Designer(port=port, token=TOKEN[::-1], planner=SyntheticPlanner)):
        assert asked(port, headers=cookie).status == 401


@pytest.mark.parametrize(
    ("host", "token", "warned"),
    [("0.0.0.0", "none", True), ("127.0.0.1", "none", False), ("0.0.0.0", TOKEN, False)],
)
def test_only_a_server_for_everybody_warns(monkeypatch, capfd, host, token, warned):
    monkeypatch.setattr("app.designer.Designer.warm_up", lambda *_: None)
    stopped = threading.Event()
    stopped.set()
    serve(host, 0, stopped, token=token, planner=SyntheticPlanner)
    out, err = capfd.readouterr()
    assert out.startswith("llsrbm designer: http://127.0.0.1:")
    assert (out.count("\n"), err.count("\n")) == (1, int(warned))
    assert err.startswith("warning: --token none: anybody who reaches") is warned


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ["--token", "short"],
            "--token: expected 16 to 256 letters, digits, '-' or '_', or 'none'",
        ),
        (["--proxy", "nginx"], "--proxy: expected an address or a network, for example 127.0.0.1"),
        (["--workers", "0"], "--workers: expected 1 to 64, got 0"),
        (["--workers", "65"], "--workers: expected 1 to 64, got 65"),
        (["--scheduler", "tcp://127.0.0.1:8786"], "expected --workers N for more processes"),
    ],
)
def test_options_that_cannot_be_are_one_line_and_nothing_is_served(
    arguments, line, refused, monkeypatch
):
    monkeypatch.setattr("app.workers.pool.WorkerPool", MagicMock())
    assert line in refused("serve", "--port", "0", *arguments)


@contextlib.contextmanager
def serving(tmp_path):
    """A server in a process of its own; killed at the end, if it is still there."""
    (tmp_path / "program.py").write_text(PROGRAM)
    server = subprocess.Popen(
        [sys.executable, str(tmp_path / "program.py"), "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    )
    try:
        yield server
    finally:
        server.kill()
        server.communicate()


def lines_until_ready(server):
    """The terminal's."""
    return list(iter(server.stderr.readline, "ready\n"))


def test_it_serves_says_where_and_ends_cleanly(tmp_path):
    with serving(tmp_path) as server:
        line = server.stdout.readline()
        pattern = r"llsrbm designer: (http://127\.0\.0\.1:\d+/\?token=[\w-]{43})\n"
        url = re.fullmatch(pattern, line).group(1)
        opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        with opener.open(url, timeout=10) as page:
            assert page.status == 200
        assert lines_until_ready(server)[0] == "  preparing anymal ...\n"
        processes = children(server.pid)
        assert processes
        server.send_signal(signal.SIGINT)
        out, err = server.communicate(timeout=15)
        assert (server.returncode, out, err) == (0, "", "")
    wait_until(lambda: not any(map(alive, processes)), "the end of its processes")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_both_signals_stop_it(number):
    former = signal.getsignal(number)
    with stop_on_signal() as stop:
        signal.raise_signal(number)
        assert stop.is_set()
    assert signal.getsignal(number) is former


@pytest.mark.nightly
def test_the_computing_processes_end_when_the_server_is_killed(tmp_path):
    with serving(tmp_path) as server:
        lines_until_ready(server)
        processes = children(server.pid)
    assert processes
    wait_until(lambda: not any(map(alive, processes)), "the end of its processes")

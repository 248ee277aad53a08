"""Starting and ending: ports, addresses, signals, the terminal."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from contextlib import closing

import pytest

from app.compute.pool import WorkerPool
from app.server.server import Designer, check_bindable
from app.session.initial_plan import example
from llsrbm.errors import InputError
from llsrbm.jump import Jump
from tests.app import planners
from tests.app.planners import SyntheticPlanner

PROGRAM = """
import sys
from app.server.server import serve
from app.compute.pool import WorkerPool
from tests.app.planners import SyntheticPlanner
if __name__ == "__main__":
    serve("127.0.0.1", int(sys.argv[1]), pool=WorkerPool(SyntheticPlanner))
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


def test_the_plan_that_tabs_begin_with_is_there_at_once_the_second_time(tmp_path, monkeypatch):
    # Apart from the cache of fits, which takes long to fill.
    entry = tmp_path / "opening.npz"
    monkeypatch.setattr("app.session.initial_plan.cache_path", lambda *_: entry)
    ready = threading.Event()
    monkeypatch.setattr("builtins.print", lambda *words, **_: words == ("ready",) and ready.set())
    with closing(Designer(port=0, pool=WorkerPool(SyntheticPlanner))) as designer:
        assert designer.opening.plan("anymal") is None
        designer.warm_up("anymal")
        assert ready.wait(20)
        plan = designer.opening.plan("anymal")
    assert plan.jump == example("anymal")
    with closing(Designer(port=0, pool=WorkerPool(SyntheticPlanner))) as designer:
        designer.warm_up("anymal")
        assert designer.opening.plan("anymal").jump == plan.jump
        assert designer.opening.plan("go2") is None


def test_the_terminal_hears_of_steps_not_of_iterations(monkeypatch):
    lines, ready = [], threading.Event()

    def take(line, **_):
        lines.append(line)
        if line == "ready":
            ready.set()

    monkeypatch.setattr("builtins.print", take)
    monkeypatch.setattr("app.session.initial_plan.InitialPlans.recall", lambda *_: None)
    monkeypatch.setattr("app.session.initial_plan.InitialPlans.keep", lambda *_: None)
    monkeypatch.setattr("app.server.server.example", lambda robot: Jump(twist=planners.ITERATING))
    with closing(Designer(port=0, pool=WorkerPool(SyntheticPlanner))) as designer:
        designer.warm_up("anymal")
        assert ready.wait(30)
    assert lines == ["  preparing anymal ...", "  solving ...", "ready"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_serves_says_where_and_ends_cleanly(tmp_path, number):
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    server = subprocess.Popen(
        [sys.executable, str(program), "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    )
    try:
        line = server.stdout.readline()
        url = re.fullmatch(r"llsrbm designer: (http://127\.0\.0\.1:\d+)\n", line).group(1)
        with urllib.request.urlopen(url, timeout=10) as page:
            assert page.status == 200
        terminal = []
        while (told := server.stderr.readline()) != "ready\n":
            terminal.append(told)
        assert terminal[0] == "  preparing anymal ...\n"
        processes = children(server.pid)
        assert processes
        server.send_signal(number)
        out, err = server.communicate(timeout=15)
    finally:
        if server.poll() is None:
            server.kill()
            server.communicate()
    assert (server.returncode, out, err) == (0, "", "")
    deadline = time.monotonic() + 5
    while any(map(alive, processes)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(alive, processes))


def test_the_computing_processes_end_when_the_server_is_killed(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    server = subprocess.Popen(
        [sys.executable, str(program), "0"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
    )
    while server.stderr.readline() != "ready\n":
        pass
    processes = children(server.pid)
    server.kill()
    server.communicate()
    deadline = time.monotonic() + 5
    while any(map(alive, processes)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(map(alive, processes))

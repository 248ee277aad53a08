"""A server of its own, as anybody starts it, and how much memory it takes."""

import contextlib
import os
import subprocess
import sys
import threading
from pathlib import Path


@contextlib.contextmanager
def serving(*options):
    """A server, once its page answers, and the page's address."""
    program = [sys.executable, "-m", "llsrbm.cli", "serve", "--port", "0", "--no-browser", *options]
    server = subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        words = (word for line in server.stdout for word in line.split())
        yield server, next(word for word in words if word.startswith("http"))
    finally:
        server.terminate()
        server.communicate()


def wait_until_ready(server):
    """Until everything is loaded: on a machine's first start solvers are built."""
    while server.stderr.readline() not in ("ready\n", ""):
        pass
    threading.Thread(target=server.stderr.read, daemon=True).start()


def resident(pid):
    """Memory of a process, and of its children together, MB."""
    children = Path(f"/proc/{pid}/task").glob("*/children")
    pids = [pid, *(int(child) for each in children for child in each.read_text().split())]
    pages = [int(Path(f"/proc/{each}/statm").read_text().split()[1]) for each in pids]
    own, *others = (count * os.sysconf("SC_PAGE_SIZE") / 1e6 for count in pages)
    return own, sum(others)

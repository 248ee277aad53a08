"""A `robot-sim` in a process of its own."""

import contextlib
import json
import signal
import subprocess
import sys

STARTS = 120.0  # s in which a process surely has begun on a busy machine


@contextlib.contextmanager
def simulator(domain, *options):
    """A simulated Go2 in a domain; gives a function that ends it and returns its result."""
    program = [sys.executable, "-m", "llsrbm.cli", "robot-sim", "--robot", "go2", "--json"]
    command = [*program, "--domain", str(domain), *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)

    def ended():
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=STARTS)
        return json.loads(out)

    try:
        yield ended
    finally:
        process.kill()
        process.wait()

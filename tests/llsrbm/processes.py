"""The command line, and Python programs, in processes of their own."""

import subprocess
import sys


def run(*arguments, **options):
    """`llsrbm` in a process of its own."""
    return _ended("-m", "llsrbm.cli", *arguments, **options)


def printed(program, *arguments, **options):
    """What a Python program prints, which ends well; what it replaces stays so in this process."""
    done = _ended("-c", program, *arguments, **options)
    assert done.returncode == 0, done.stderr
    return done.stdout


def assert_spares(program, *modules):
    """A Python program imports none of some modules."""
    found = f"import sys\nprint(*({set(modules)} & sys.modules.keys()))"
    assert printed(f"{program}\n{found}").splitlines()[-1] == ""


def _ended(*arguments, **options):
    command = [sys.executable, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100, **options)

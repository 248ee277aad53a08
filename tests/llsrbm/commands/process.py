"""The command line in a process of its own."""

import subprocess
import sys


def run(*arguments, **options):
    """`llsrbm` in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "llsrbm.cli", *map(str, arguments)],
        capture_output=True,
        text=True,
        timeout=100,
        **options,
    )

"""Compiles C files into a library, in a process of its own: `compile_job.py TARGET COMMAND...`.

The files come on standard input, as JSON of name -> content, compressed. One job runs at a time on
a machine, and one for each library; others of the same end at once. A library appears at TARGET
once it is whole and can be loaded; otherwise TARGET.failed says why not. Run by its path, for it
needs nothing of the package.
"""

from __future__ import annotations

import ctypes
import fcntl
import json
import os
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

LEAST_PRIORITY = 19
# Of a compiler's complaints, characters that are kept.
COMPLAINT = 500


def main(target: Path, command: list[str]) -> None:
    """Make the library, unless it is there or being made."""
    os.nice(LEAST_PRIORITY)
    mine = Path(f"{target}.lock")
    with mine.open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:  # another process makes the same
            return
        try:
            # Of the whole cache, and without a file to leave behind: it ends with the process.
            fcntl.flock(os.open(target.parents[1], os.O_RDONLY), fcntl.LOCK_EX)
            if not target.exists() and not failed(target).exists():
                compile_files(target, command)
        finally:
            mine.unlink(missing_ok=True)


def failed(target: Path) -> Path:
    """Where the reason lies when there is no library."""
    return Path(f"{target}.failed")


def compile_files(target: Path, command: list[str]) -> None:
    """Compile what comes on standard input, its files appended to the command."""
    files = json.loads(zlib.decompress(sys.stdin.buffer.read()))
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=target.stem) as folder:
        for name, content in files.items():
            Path(folder, name).write_text(content, encoding="ascii")
        made = Path(folder, target.name)
        done = subprocess.run(
            [*command, "-o", made.name, *files, "-lm"],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        try:
            if done.returncode != 0:
                raise OSError(f"{command[0]}: {done.stderr[:COMPLAINT]}")
            ctypes.CDLL(str(made))
        except OSError as error:
            failed(target).write_text(str(error), encoding="utf-8")
        else:
            made.replace(target)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])

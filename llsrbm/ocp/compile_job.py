"""Compiles C files into a library, in a process of its own: `compile_job.py TARGET COMMAND...`.

The files come on standard input, as JSON of name -> content, compressed. One job runs at a time on
a machine; those that wait for it find its library there. A library appears at TARGET once it is
whole and can be loaded; otherwise TARGET.failed says why not. Run by its path, for it needs nothing
of the package.
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
    """Compile what comes on standard input, with all of its files appended to the command."""
    os.nice(LEAST_PRIORITY)
    files = json.loads(zlib.decompress(sys.stdin.buffer.read()))
    # Of the whole cache, and without a file to leave behind: it ends with the process.
    fcntl.flock(os.open(target.parents[1], os.O_RDONLY), fcntl.LOCK_EX)
    if target.exists():
        return
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
            Path(f"{target}.failed").write_text(str(error), encoding="utf-8")
        else:
            made.replace(target)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])

"""A few lines of C as a library of the cache, to be loaded before Fatrop is.

The linker takes the first definition of a name: one compiled here comes before that of Fatrop, or
of what Fatrop uses, if it is loaded earlier.
"""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

from llsrbm.cache import cache_path, content_key, forget_old
from llsrbm.ocp.compiled import Compiler

_OPTIONS = ("-O2", "-march=native", "-fPIC", "-shared", "-w", "-x", "c", "-")
_PATIENCE = 10.0  # s; it takes a fifth of one


def compiled_library(compiler: Compiler, source: str) -> Path:
    """The library of a source, made if it is not there yet.

    Raises:
        OSError, subprocess.SubprocessError: it cannot be made.
    """
    path = cache_path("kernel", content_key(source, repr(_OPTIONS), compiler.identity), ".so")
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            made = Path(folder, path.name)
            subprocess.run(
                [compiler.command[0], *_OPTIONS, "-o", str(made)],
                input=source.encode("ascii"),
                capture_output=True,
                timeout=_PATIENCE,
                check=True,
            )
            made.replace(path)
        forget_old(path)
    return path

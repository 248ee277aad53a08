"""Libraries of compiled functions: made in the background, loaded when they are there.

Nobody waits for a compiler: the solver at hand works at once, and takes the compiled functions when
it solves next. The C is CasADi's own, a file a stage function, so that a compiler never has all of
them in memory, and one for all that are composed, as they call the same functions; one more loops
over the stages and puts the results where they belong.
"""

import json
import logging
import os
import shutil
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import casadi as ca

from llsrbm.abandon import go_on
from llsrbm.cache import forget_old, mark_used
from llsrbm.file_locks import lock
from llsrbm.ocp.compile_job import failed, is_sealed
from llsrbm.ocp.transcription import FUNCTIONS, Structure, Transcribed, Transcription

_log = logging.getLogger(__name__)

ENVIRONMENT_VARIABLE = "LLSRBM_COMPILE"  # 0: never compile, and use nothing that is compiled

# For both of Go2's solvers -Og takes 57 s of processor, -O1 100, for 0 to 9 % less time to solve;
# -O2 takes five times as long as that, for 5 % less again. Without contraction every machine gets
# the numbers that CasADi's own evaluation gives.
_OPTIONS = (
    *("-Og", "-march=native", "-fno-math-errno", "-ffp-contract=off"),
    *("-fPIC", "-shared", "-w"),
)
_JOB = Path(__file__).with_name("compile_job.py")
# s that a compiler may take to list its macros.
_MACROS_WITHIN = 10.0
COMPILED = 30.0  # MB that a solver takes beside its library
# s between looks whether another process has finished.
_LOOK_EVERY = 0.2
# s for which a compilation that failed is not tried again.
_RETRY_AFTER = 86_400.0


@dataclass(frozen=True)
class Compiler:
    """A compiler of this machine."""

    command: tuple[str, ...]  # with its options
    identity: str  # all that its results depend on: its version, the processor, the options


def compiler() -> Compiler | None:
    """The system's C compiler, if there is one, and unless it is switched off."""
    if os.environ.get(ENVIRONMENT_VARIABLE) == "0" or os.name != "posix":
        return None
    path = shutil.which(os.environ.get("CC") or "cc")
    if path is None:
        _log.info("no C compiler (cc): solvers work as they are, at half the speed")
        return None
    try:
        macros = _macros(path)
    except (OSError, subprocess.SubprocessError) as error:
        _log.warning("the C compiler %s cannot be used now: %s", path, error)
        return None
    return Compiler((path, *_OPTIONS), f"{_OPTIONS} {macros}")


@lru_cache(maxsize=4)  # of those that answered: one that was too slow is tried again
def _macros(path: str) -> str:
    return subprocess.run(
        [path, "-march=native", "-dM", "-E", "-x", "c", os.devnull],
        capture_output=True,
        text=True,
        encoding="utf-8",
        timeout=_MACROS_WITHIN,
        check=True,
    ).stdout


def c_files(transcription: Transcription) -> dict[str, str]:
    """Name -> content of the C files of a library with a transcription's functions."""
    # CasADi compiles what stands for functions elsewhere as it makes it, or it cannot be called.
    with tempfile.TemporaryDirectory() as scratch:
        return _written(transcription, scratch)


def _written(transcription: Transcription, scratch: str) -> dict[str, str]:
    files: dict[str, str] = {}
    composed: dict[str, ca.Function] = {}

    def write(name: str, *functions: ca.Function) -> None:
        go_on()
        generator = ca.CodeGenerator(name)
        for function in functions:
            generator.add(function)
        files[f"{name}.c"] = generator.dump()

    def mapped_in_c(function: ca.Function, count: int, *arguments: Any) -> list[Any]:
        if function.is_a("SXFunction"):
            write(function.name(), function)
        else:
            composed[function.name()] = function
        loop = _loop(function, [argument.shape[1] for argument in arguments], count, scratch)
        return list(loop.call(arguments))

    functions = transcription.assembled(mapped_in_c)
    if composed:  # in one file, as they call the same functions
        write("stages", *composed.values())
    structure = ca.Function("structure", [], [ca.DM(n) for n in transcription.structure.as_lists()])
    write("problem", *functions.values(), structure)
    return files


def _loop(function: ca.Function, columns: Sequence[int], count: int, scratch: str) -> ca.Function:
    """In generated code, the loop over `count` stages of a function in another file.

    On one core: on both of two it takes a tenth less when nothing else runs, and three times as
    long beside two busy processes, for each loop waits for its last thread.

    `columns`: of each argument, one where all stages share it. CasADi's own files of it go into the
    folder `scratch`.
    """
    name, n_in, n_out = function.name(), function.n_in(), function.n_out()
    steps = [function.numel_in(i) if n == count else 0 for i, n in enumerate(columns)]
    # What stands for the function has no room for what it works with. CasADi has moved both
    # pointers past the arguments before the body begins.
    takes = [
        f"args[{i}] = arg[{i - n_in}] ? arg[{i - n_in}] + k * {step} : 0;"
        for i, step in enumerate(steps)
    ]
    gives = [
        f"results[{i}] = res[{i - n_out}] ? res[{i - n_out}] + k * {function.numel_out(i)} : 0;"
        for i in range(n_out)
    ]
    body = "\n".join(
        [
            f"int {name}(const double **, double **, long long *, double *, int);",
            "int k, wrong = 0;",
            f"for (k = 0; k < {count}; ++k) {{",
            f"const double *args[{function.sz_arg()}]; double *results[{function.sz_res()}];",
            f"long long whole[{function.sz_iw() + 1}]; double work[{function.sz_w() + 1}];",
            *takes,
            *gives,
            f"wrong = {name}(args, results, whole, work, mem) || wrong;",
            "}",
            "return wrong;",
        ]
    )
    names = function.name_in(), function.name_out()
    sparsities = (
        [ca.Sparsity.dense(function.size1_in(i), n) for i, n in enumerate(columns)],
        [ca.Sparsity.dense(function.size1_out(i), count) for i in range(n_out)],
    )
    # It may live longer than that folder, and would complain that its files are gone.
    own = {"directory": f"{scratch}/", "cleanup": False}
    options = {"buffered": False, "jit_cleanup": False, "jit_options": own}
    return ca.Function.jit(f"each_{name}", body, *names, *sparsities, options)


def packed(files: Mapping[str, str]) -> bytes:
    """C files as `Library.compile` takes them."""
    return zlib.compress(json.dumps(files).encode("ascii"), level=1)


@cache
def asker() -> int:
    """The end of a pipe for processes that are to end with this one, which holds the other."""
    theirs, _ = os.pipe()
    return theirs


def is_whole(library: Path) -> bool:
    """Whether a compiled library is there and undamaged; a damaged one is removed, with a warning,
    so that it is made anew.
    """
    try:
        if is_sealed(library):
            return True
        _log.warning("%s is damaged; it is made anew", library)
        library.unlink()
    except FileNotFoundError:
        pass
    except OSError as error:
        _log.warning("%s cannot be used (%s); going on without", library, error)
    return False


@dataclass(eq=False)
class Library:
    """A library of compiled functions, there or yet to come."""

    path: Path  # where it is, or will be
    _job: subprocess.Popen[bytes] | None = None

    def load(self) -> Transcribed | None:
        """Its functions and their structure; None while there are none."""
        if self._job is not None and self._job.poll() is not None:
            self._report(self._job)
            self._job = None
        if not is_whole(self.path):
            return None
        try:
            functions = {name: ca.external(name, str(self.path)) for name in FUNCTIONS}
            lists = ca.external("structure", str(self.path)).call([])
        except RuntimeError as error:
            _log.warning("compiled functions cannot be loaded (%s); going on without", error)
            return None
        mark_used(self.path)
        megabytes = COMPILED + self.path.stat().st_size / 1e6
        return Transcribed(functions, Structure.of_lists(*(n.nonzeros() for n in lists)), megabytes)

    def compile(self, compiler: Compiler, source: bytes) -> None:
        """Begin to make it in the background, from `packed` files."""
        reason = failed(self.path)
        with suppress(OSError):
            if time.time() - reason.stat().st_mtime < _RETRY_AFTER:
                text = reason.read_text(encoding="utf-8", errors="replace")
                _log.warning("going on without compiled functions: %s (%s)", text, reason)
                return
        _log.info("compiling %s in the background", self.path.parent.name)
        forget_old(self.path)
        with tempfile.TemporaryFile() as file:
            file.write(source)
            file.seek(0)
            self._job = subprocess.Popen(
                [sys.executable, "-I", str(_JOB), str(self.path), str(asker()), *compiler.command],
                stdin=file,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
                pass_fds=(asker(),),
                start_new_session=True,  # a terminal's Ctrl-C is for this program
            )

    def wait(self) -> None:
        """Until it has been made, or could not be, by this process or by another."""
        if self._job is not None:
            self._job.wait()
        while not failed(self.path).exists() and self.is_in_work():
            time.sleep(_LOOK_EVERY)

    def is_in_work(self) -> bool:
        """True while it is being made: this process's job runs, or another holds the lock."""
        if self.path.exists():
            return False
        if self._job is not None and self._job.poll() is None:
            return True
        try:
            with Path(f"{self.path}.lock").open("rb") as file:
                return not lock(file, shared=True)
        except OSError:
            return False

    def _report(self, job: subprocess.Popen[bytes]) -> None:
        _, printed = job.communicate()
        if job.returncode != 0:
            reason = printed.decode(errors="replace").strip() or f"exit status {job.returncode}"
            _log.warning("going on without compiled functions: %s", reason)

"""Libraries of compiled functions: made in the background, loaded when they are there.

Nobody waits for a compiler: the solver at hand works at once, and takes the compiled functions when
it solves next. Without a compiler nothing happens.
"""

from __future__ import annotations

import ctypes
import fcntl
import json
import logging
import os
import shutil
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import casadi as ca

from llsrbm.cache import forget_old
from llsrbm.ocp.c_code import EVALUATED
from llsrbm.ocp.transcription import Structure, Transcribed

_log = logging.getLogger(__name__)

ENVIRONMENT_VARIABLE = "LLSRBM_COMPILE"  # 0: never compile, and use nothing that is compiled

# -O2 takes half as long again to compile, for 15 % less time to evaluate. Without contraction every
# machine gets the numbers that CasADi's own evaluation gives.
_OPTIONS = (
    "-O1",
    "-march=native",
    "-fno-math-errno",
    "-ffp-contract=off",
    "-fPIC",
    "-shared",
    "-w",
)
_JOB = Path(__file__).with_name("compile_job.py")
# s that a compiler may take to say which one it is.
_PATIENCE = 10.0
# s between looks whether another process has finished.
_LOOK_EVERY = 0.2


@dataclass(frozen=True)
class Compiler:
    """A compiler of this machine.

    Attributes:
        command: with its options.
        identity: all that its results depend on: its version, the processor, the options.
    """

    command: tuple[str, ...]
    identity: str


def compiler() -> Compiler | None:
    """The system's C compiler, if there is one, and unless it is switched off."""
    if os.environ.get(ENVIRONMENT_VARIABLE) == "0" or os.name != "posix":
        return None
    path = shutil.which(os.environ.get("CC") or "cc")
    if path is None:
        _log.info("no C compiler (cc): solvers work as they are, at half the speed")
        return None
    return _identified(path)


@lru_cache(maxsize=4)
def _identified(path: str) -> Compiler | None:
    command = (path, *_OPTIONS)
    try:
        macros = subprocess.run(
            [path, "-march=native", "-dM", "-E", "-x", "c", os.devnull],
            capture_output=True,
            text=True,
            timeout=_PATIENCE,
            check=True,
        ).stdout
    except (OSError, subprocess.SubprocessError) as error:
        _log.info("the C compiler %s is of no use: %s", path, error)
        return None
    return Compiler(command, f"{_OPTIONS} {macros}")


@dataclass(eq=False)
class Library:
    """A library of compiled functions, there or yet to come.

    Attributes:
        path: where it is, or will be.
    """

    path: Path
    _job: subprocess.Popen[bytes] | None = None

    def load(self) -> Transcribed | None:
        """Its functions and their structure; None while there are none."""
        if self._job is not None and self._job.poll() is not None:
            self._job = None
            self._report()
        if not self.path.exists():
            return None
        try:
            functions = {name: ca.external(name, str(self.path)) for name in EVALUATED}
            structure = _structure(self.path)
            os.utime(self.path)  # used now: others are forgotten first
        except (OSError, RuntimeError, ValueError) as error:
            _log.warning("compiled functions cannot be loaded (%s); going on without", error)
            return None
        return Transcribed(_completed(functions), structure)

    def compile(self, compiler: Compiler, source: bytes) -> None:
        """Begin to make it in the background, from `packed` files."""
        if self._failed.exists():
            self._report()
            return
        _log.info("compiling %s in the background", self.path.parent.name)
        forget_old(self.path)
        with tempfile.TemporaryFile() as file:
            file.write(source)
            file.seek(0)
            self._job = subprocess.Popen(
                [sys.executable, "-I", str(_JOB), str(self.path), *compiler.command],
                stdin=file,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # goes on when this program ends or is interrupted
            )

    def wait(self) -> None:
        """Until it has been made, or could not be, by this process or by another."""
        if self._job is not None:
            self._job.wait()
        while not (self.path.exists() or self._failed.exists()) and self._is_in_work():
            time.sleep(_LOOK_EVERY)

    def _is_in_work(self) -> bool:
        """Whether some process holds the job's lock, see `llsrbm.ocp.compile_job`."""
        try:
            with Path(f"{self.path}.lock").open("rb") as lock:
                fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return True
        except OSError:
            return False
        return False

    @property
    def _failed(self) -> Path:
        return self.path.with_name(f"{self.path.name}.failed")

    def _report(self) -> None:
        if self._failed.exists():
            text = self._failed.read_text(encoding="utf-8", errors="replace").strip()
            _log.info("going on without compiled functions: %s", text)


def packed(files: Mapping[str, str]) -> bytes:
    """C files as `Library.compile` takes them."""
    return zlib.compress(json.dumps(files).encode("ascii"), level=1)


def _structure(path: Path) -> Structure:
    library = ctypes.CDLL(str(path))

    def numbers(field: str) -> list[int]:
        size = ctypes.c_int.in_dll(library, f"structure_{field}_size").value
        return list((ctypes.c_int * size).in_dll(library, f"structure_{field}"))

    return Structure(
        states=numbers("states"),
        controls=numbers("controls"),
        rows=numbers("rows"),
        equality=[bool(flag) for flag in numbers("equality")],
    )


def _completed(functions: dict[str, ca.Function]) -> dict[str, ca.Function]:
    """With those that solvers want to have but do not evaluate in every iteration."""
    hessian = functions["nlp_hess_l"]
    arguments = [ca.MX.sym(hessian.name_in(i), hessian.sparsity_in(i)) for i in range(4)]
    xp, (lam_f, lam) = arguments[:2], arguments[2:]
    f, g, df = (functions[name](*xp) for name in ("nlp_f", "nlp_g", "nlp_grad_f"))
    _, J = functions["nlp_jac_g"](*xp)
    names = [hessian.name_in(i) for i in range(4)]
    return {
        **functions,
        "nlp": ca.Function("nlp", xp, [f, g], names[:2], ["f", "g"]),
        "nlp_grad": ca.Function(
            "nlp_grad",
            arguments,
            [f, g, lam_f * df + ca.mtimes(J.T, lam), ca.MX(xp[1].numel(), 1)],
            names,
            ["f", "g", "grad_gamma_x", "grad_gamma_p"],
        ),
    }

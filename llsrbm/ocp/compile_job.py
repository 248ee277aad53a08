"""Compiles C files into a library, in a process of its own: `compile_job.py TARGET FD COMMAND...`.

The files come on standard input, as JSON of name -> content, compressed. FD is the end of a pipe
whose other end the asker holds: when that has gone, the job ends with all that it runs and leaves
nothing. One job runs at a time on a machine, and one for each library; others of the same end at
once. A library appears at TARGET, sealed, once it is whole and can be loaded. Otherwise the reason
is printed, and kept in TARGET.failed unless the compiler was killed. Run by its path, for it needs
nothing of the package.
"""

import contextlib
import ctypes
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import zlib
from pathlib import Path

LEAST_PRIORITY = 19
TIDYING = 5.0  # s
LONGEST = 3600.0  # s; a minute on an idle core
REASON_LENGTH = 500  # characters of a compiler's messages that are kept


def main(target: Path, asker: int, command: list[str]) -> None:
    """Make the library, unless it is there or being made. Raises `OSError`: it cannot be made, or
    the cache cannot be written or locked.
    """
    import fcntl  # this process runs on POSIX alone, others read the module anywhere

    end_with(asker)
    yield_to_others()
    mine = Path(f"{target}.lock")
    # NFS locks only what is open for writing: of the whole cache a file, which stays.
    with mine.open("w") as lock, Path(target.parents[1], "compiling.lock").open("a") as machine:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:  # another process makes the same
            return
        try:
            fcntl.flock(machine, fcntl.LOCK_EX)
            if not target.exists():
                for left in target.parent.glob(f"{target.stem}.*.part"):
                    shutil.rmtree(left, ignore_errors=True)
                compile_files(target, command)
        finally:
            mine.unlink(missing_ok=True)


def end_with(asker: int) -> None:
    """End this process, as by SIGTERM, once nobody holds the other end of the pipe `asker`."""

    def wait() -> None:
        os.read(asker, 1)
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(TIDYING)  # the main thread takes a signal between two calls
        os._exit(1)

    signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended, for nobody waits for it any more"))
    threading.Thread(target=wait, daemon=True).start()


def yield_to_others() -> None:
    """Take the processor's time that nobody else wants."""
    if hasattr(os, "nice"):
        os.nice(LEAST_PRIORITY)
    # Linux shares time among sessions first, and a session's priority is its own.
    if hasattr(os, "getsid") and os.getsid(0) == os.getpid():
        with contextlib.suppress(OSError):
            Path("/proc/self/autogroup").write_text(str(LEAST_PRIORITY), "ascii")


def seal(library: Path) -> None:
    """Add to a library what tells that it is whole; a loader does not look beyond its end."""
    content = library.read_bytes()
    library.write_bytes(content + hashlib.sha256(content).digest())


def is_sealed(library: Path) -> bool:
    """True if a library is as it was sealed. Raises `OSError`: it cannot be read."""
    content, size = library.read_bytes(), hashlib.sha256().digest_size
    return hashlib.sha256(content[:-size]).digest() == content[-size:]


def failed(target: Path) -> Path:
    """Where the reason is kept when there is no library."""
    return Path(f"{target}.failed")


def compile_files(target: Path, command: list[str]) -> None:
    """Compile what comes on standard input, its files appended to the command. Raises `OSError`:
    the compiler failed or was killed, or its library cannot be loaded.
    """
    failed(target).unlink(missing_ok=True)
    files = json.loads(zlib.decompress(sys.stdin.buffer.read()))
    with tempfile.TemporaryDirectory(".part", f"{target.stem}.", target.parent) as folder:
        for name, content in files.items():
            Path(folder, name).write_text(content, encoding="ascii")
        made = Path(folder, target.name)
        try:
            run([*command, "-o", made.name, *files, "-lm"], folder)
            seal(made)  # not once it is loaded: the process would crash as it ends
            ctypes.CDLL(str(made))
        except InterruptedError:
            raise
        except OSError as error:
            failed(target).write_text(str(error), encoding="utf-8")
            raise
        made.replace(target)


def run(command: list[str], folder: str) -> None:
    """Run a compiler. Raises `InterruptedError`: it, or a program that it runs, was killed;
    `OSError`: it failed, or took too long.
    """
    with subprocess.Popen(
        command,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        start_new_session=True,  # of its own, to be ended with all programs that it runs
    ) as compiler:
        try:
            _, printed = compiler.communicate(timeout=LONGEST)
        except BaseException as error:
            os.killpg(compiler.pid, signal.SIGKILL)
            if isinstance(error, subprocess.TimeoutExpired):
                raise OSError(f"{command[0]}: not finished after {LONGEST:g} s") from error
            raise
    status = compiler.returncode
    if status != 0:
        killed = status < 0 or "signal" in printed or "Killed" in printed
        kind = InterruptedError if killed else OSError
        raise kind(f"{command[0]}: status {status}: {printed[:REASON_LENGTH]}")


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3:])
    except OSError as error:
        sys.exit(str(error))

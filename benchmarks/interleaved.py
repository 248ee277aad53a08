"""Solve times of several programs, measured in turns: what else the machine does meets all of them.

Minima of many turns, and ratios of them; used by `solve_times.py`.
"""

import json
import os
import subprocess
import sys
import tempfile
import venv
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[1]
CHILD = Path(__file__).with_name("solve_child.py")
CROCODDYL = ("crocoddyl==3.2.1", "pin==4.0.0", "mim-solvers==0.3.0", "example-robot-data")
# 90 deg, and 2 deg to the next; the biped's record, and 1 cm.
ANYMAL = ("anymal", "48", "twist=1.5708", "0.0349")
SLIDER = ("slider", "60", "forward=0.2", "height=0.35", "0.01")

Figures = dict[str, float]


class Program:
    """A process that answers a line with figures."""

    def __init__(self, command: list[str], tree: Path | None = None) -> None:
        threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        environment = {**os.environ, **threads}
        if tree is not None:
            environment["PYTHONPATH"] = str(tree)
        self.best: Figures = {}
        self._process = subprocess.Popen(
            command,
            cwd=tree,
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def ready(self) -> None:
        """Wait until it has built all it needs."""
        self._line()

    def turn(self) -> None:
        """Measure once."""
        for name, value in json.loads(self.answer()).items():
            self.best[name] = min(value, self.best.get(name, value))

    def answer(self) -> str:
        """Its answer to a line."""
        self._process.stdin.write("again\n")
        self._process.stdin.flush()
        return self._line()

    def end(self) -> None:
        self._process.stdin.close()
        self._process.wait()

    def _line(self) -> str:
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self._process.args[1]} ended with {self._process.wait()}")
        return line


def compare(repeats: int, against: str | None, crocoddyl: bool) -> None:
    """Print times and ratios of this version, an older one and Crocoddyl."""
    with ExitStack() as stack:
        programs = {
            "anymal": Program([sys.executable, str(CHILD), *ANYMAL], ROOT),
            "slider": Program([sys.executable, str(CHILD), *SLIDER], ROOT),
        }
        if against is not None:
            tree = stack.enter_context(checked_out(against))
            programs["before"] = Program([sys.executable, str(CHILD), *ANYMAL], tree)
        if crocoddyl:
            programs["crocoddyl"] = Program(
                [str(crocoddyl_python()), str(CHILD.with_name("crocoddyl_jump.py"))]
            )
        for program in programs.values():
            stack.callback(program.end)
            program.ready()
        for _ in range(repeats):
            for program in programs.values():
                program.turn()
        report({name: program.best for name, program in programs.items()}, against)


def report(best: dict[str, Figures], against: str | None) -> None:
    """Print minima in ms, then ratios."""
    print("ms, least of all turns: a plan in all, of it the solver, its iterations")
    for name, figures in best.items():
        for kind in ("cold", "near"):
            if kind in figures:
                total, solve = (1e3 * figures[key] for key in (kind, f"{kind} solve"))
                print(f"{name} {kind}: {total:.0f}, {solve:.0f}, {figures[f'{kind} iterations']}")
    mine = best["anymal"]
    print(f"slider at 60 intervals / anymal at 48: {best['slider']['cold'] / mine['cold']:.2f}")
    if "before" in best:
        before = best["before"]
        for kind in ("cold", "near"):
            print(
                f"{kind} plan / that of {against}: {mine[kind] / before[kind]:.2f} in all, "
                f"{mine[f'{kind} solve'] / before[f'{kind} solve']:.2f} in the solver"
            )
        print(f"costs differ by {abs(mine['cost'] / before['cost'] - 1):.1e}")
    if "crocoddyl" in best:
        seconds = best["crocoddyl"]["solve"]
        print(
            f"crocoddyl's jump of 30 cm, {best['crocoddyl']['knots']:.0f} knots: "
            f"{1e3 * seconds:.0f}; {seconds / mine['cold']:.0f} x a cold plan"
        )


@contextmanager
def checked_out(commit: str) -> Iterator[Path]:
    """A folder with an older version."""
    with tempfile.TemporaryDirectory(prefix="llsrbm-") as folder:
        tree = Path(folder, "tree")
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run([*git, "add", "--quiet", "--detach", str(tree), commit], check=True)
        try:
            yield tree
        finally:
            subprocess.run([*git, "remove", "--force", str(tree)], check=True)


def crocoddyl_python() -> Path:
    """The interpreter of an environment with Crocoddyl, made on its first use."""
    place = ROOT / "build" / "crocoddyl"
    python = place / "bin" / "python"
    marker, packages = place / "installed", "\n".join(CROCODDYL)
    if not marker.exists() or marker.read_text() != packages:
        venv.create(place, with_pip=True, symlinks=True, clear=True)
        subprocess.run([str(python), "-m", "pip", "install", "--quiet", *CROCODDYL], check=True)
        marker.write_text(packages)
    return python

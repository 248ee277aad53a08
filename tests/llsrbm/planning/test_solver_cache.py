"""What a kept solver depends on."""

import subprocess
import sys
from pathlib import Path

import llsrbm
from llsrbm.cache import program
from llsrbm.planning.solver_cache import programs

PACKAGE = Path(llsrbm.__file__).parent


def test_all_that_makes_the_problem_is_in_the_key_and_no_search():
    known = set(programs())
    needed = ["models/llsrbm_plus.py", "models/leg_drives.py", "ocp/lifting.py", "ocp/batch.py"]
    needed += ["ocp/solvers.py", "planning/stage.py", "planning/layout.py", "planning/costs.py"]
    needed += ["planning/rotations.py", "planning/headings.py", "planning/constraints/turn.py"]
    needed += ["planning/constraints/__init__.py", "planning/solver_cache.py", "planning/task.py"]
    for name in needed:
        assert program(PACKAGE / name) in known, name
    for name in ("scout", "nearest", "explanation", "planner", "assembly", "residuals"):
        assert program(PACKAGE / "planning" / f"{name}.py") not in known, name


def test_nothing_that_is_imported_is_forgotten():
    """By Python itself, in a fresh process."""
    code = (
        "import sys, llsrbm.planning.solver_cache\n"
        "for name, module in sys.modules.items(): print(name, getattr(module, '__file__', ''))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    rooms = ("llsrbm.models.", "llsrbm.ocp.", "llsrbm.planning.")
    imported = [line.split() for line in found.stdout.splitlines() if line.startswith(rooms)]
    assert len(imported) > 20
    known = set(programs())
    assert [name for name, path in imported if program(Path(path)) not in known] == []

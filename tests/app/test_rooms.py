"""Modules import each other in one direction; the table of security.md names real tests."""

import re
from graphlib import TopologicalSorter
from pathlib import Path

import grimp

ROOT = Path(__file__).parents[2]
TESTS = [ROOT / "tests" / "app" / folder for folder in ("", "guard", "workers")]


def test_no_module_imports_itself_by_way_of_others():
    graph = grimp.build_graph("app", exclude_type_checking_imports=True)
    imports = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    assert tuple(TopologicalSorter(imports).static_order())  # CycleError names the circle


def test_every_test_that_the_table_names_exists():
    table = (ROOT / "docs" / "security.md").read_text("utf-8")
    rows = [line for line in table.splitlines() if line.startswith("| ") and "`test_" in line]
    assert len(rows) > 15
    for row in rows:
        module = None
        for file, name in re.findall(r"`(test_\w+)?(?:::(test_\w+))?`", row.rpartition(" | ")[2]):
            module = file or module
            (path,) = (found for folder in TESTS for found in folder.glob(f"{module}.py"))
            assert not name or f"\ndef {name}(" in path.read_text("utf-8"), (module, name)

"""docs/security.md names tests; they are there."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = [ROOT / "tests" / "app" / folder for folder in ("", "guard")]


def test_every_test_that_the_table_names_exists():
    table = (ROOT / "docs" / "security.md").read_text("utf-8")
    rows = [line for line in table.splitlines() if line.startswith("| ") and "`test_" in line]
    assert len(rows) > 15
    for row in rows:
        module = None
        for file, name in re.findall(r"`(test_\w+)?(?:::(test_\w+))?`", row.rpartition(" | ")[2]):
            module = file or module
            (path,) = (found for folder in FOLDERS for found in folder.glob(f"{module}.py"))
            assert not name or f"\ndef {name}(" in path.read_text("utf-8"), (module, name)

"""Modules and functions stay short enough to be read at once."""

import ast
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[1]
MODULE, FUNCTION = 400, 60  # lines


def test_no_module_and_no_function_is_long():
    listed = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "*.py", "*.js"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    long = []
    for name in listed.stdout.splitlines():
        path = ROOT / name
        if not path.is_file():  # deleted, and not committed yet
            continue
        text = path.read_text("utf-8")
        if (lines := len(text.splitlines())) > MODULE:
            long.append(f"{name}: {lines} lines")
        if path.suffix == ".py":
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                    lines = node.end_lineno - node.lineno + 1
                    if lines > FUNCTION:
                        long.append(f"{name}: {node.name}: {lines} lines")
    assert long == []

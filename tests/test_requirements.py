"""What the code imports is declared in pyproject.toml and pinned in the lock files."""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
OURS = {"llsrbm", "app", "tests", "benchmarks", "docs"}
NOT_DECLARED = {
    "pinocchio",  # of pin, whose wheel does not say so
    "pydantic_core",  # pydantic's own half
    "OpenGL",  # MuJoCo's, whatever its version draws with
}


def _imported(folder):
    """Third-party packages that are imported below a folder."""
    found = set()
    for path in (ROOT / folder).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(node.module.partition(".")[0])
    return found - sys.stdlib_module_names - OURS - NOT_DECLARED


def _name(requirement):
    return re.sub(r"[-_.]+", "-", re.match(r"[\w.-]+", requirement)[0]).lower()


@pytest.mark.parametrize("folder", ["llsrbm", "app", "tests"])
def test_what_is_imported_is_declared_and_pinned(folder):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    groups = [
        project["project"]["dependencies"],
        *project["project"]["optional-dependencies"].values(),
    ]
    groups += [project["dependency-groups"]["dev"]] if folder == "tests" else []
    pinned = (ROOT / "requirements-dev.lock").read_text(encoding="utf-8")
    known = {_name(each) for group in groups for each in group} & {
        *re.findall(r"^([\w.-]+)==", pinned, re.M)
    }
    distributions = packages_distributions()
    for package in _imported(folder):
        assert {_name(each) for each in distributions.get(package, [package])} & known, package


def test_locks_name_no_host():
    for path in ROOT.glob("requirements*.lock"):
        assert "://" not in path.read_text(encoding="utf-8")

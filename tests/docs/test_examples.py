"""Code of the pages is run: Python, the shell commands that are marked, and TOML is read."""

from pathlib import Path

import pytest
import yaml

import llsrbm
from llsrbm.cli import main
from llsrbm.installed import assets_directory
from llsrbm.request import jump_types
from llsrbm.request.tables import parse_table
from llsrbm.robots import load_robot
from llsrbm.robots.schema import RobotFile, robot_files
from tests.docs.pages import PAGES, ROOT, blocks, command_lines, name_of
from tests.llsrbm.sweep.specs import parse_spec

PYTHON = {page: {b.text for b in blocks(page) if b.language == "python"} for page in PAGES}
# The README's example is the first jump's.
WITH_PYTHON = [page for page, own in PYTHON.items() if not any(own < PYTHON[p] for p in PAGES)]
WITH_PYTHON = [page for page in WITH_PYTHON if PYTHON[page]]
WITH_SHELL = [page for page in PAGES if any(b.note == "run" for b in blocks(page))]


def toml_of(name):
    return [block.text for block in blocks(ROOT / "docs" / name) if block.language == "toml"]


@pytest.fixture(scope="module", autouse=True)
def planned_once():
    """Pages plan the same jump, in Python and in a shell: it is planned once."""
    plan, found = llsrbm.plan, {}

    def once(jump, **options):
        key = jump, *(str(options.get(name) or "") for name in ("weights", "limits", "draft"))
        if key not in found:
            found[key] = plan(jump, **options)
        return found[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(llsrbm, "plan", once)
        yield


@pytest.mark.nightly
@pytest.mark.timeout(900)  # a machine without a cache builds solvers first
@pytest.mark.parametrize("page", WITH_PYTHON, ids=name_of)
def test_python_runs(page, tmp_path, monkeypatch):
    """A page's blocks in order, in one namespace and an empty folder."""
    monkeypatch.chdir(tmp_path)
    if name_of(page) == "docs/cluster.md":
        small_sweep()
    if name_of(page) == "docs/learning.md":
        data_set()
    namespace = {"__name__": "example"}
    for block in blocks(page):
        if block.language != "python":
            continue
        code = compile(block.text, f"{name_of(page)}:{block.line}", "exec")
        if not block.note.startswith("not run: "):
            exec(code, namespace)


def data_set():
    """The LeRobot data set that a page's example reads, by its own spec and commands; of drafts."""
    (spec,) = toml_of("learning.md")
    Path("small.toml").write_text(f"draft = true\n{spec}")
    for block in blocks(ROOT / "docs" / "learning.md"):
        for program, *words in command_lines(block.text) if block.language == "" else ():
            if program == "llsrbm" and words[0] in ("sweep", "dataset"):
                assert main(words) == 0


def small_sweep():
    """The results in DIR that a page's example reads, here of two jumps."""
    Path("two.toml").write_text(
        'title = "Two jumps"\nrobots = ["anymal"]\ndraft = true\ntrajectories = true\n'
        "[axes]\nforward = [0.0, 0.1]\n"
    )
    assert main(["sweep", "two.toml", "--out", "DIR", "--workers", "1"]) == 0


@pytest.mark.nightly
@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", WITH_SHELL, ids=name_of)
def test_shell_runs(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for block in blocks(page):
        if block.note == "run":
            for program, *words in command_lines(block.text):
                assert program == "llsrbm"
                assert main(words) == 0, (words, capsys.readouterr().err)


def test_a_jump_type_is_read(tmp_path):
    """The page's own file is whole; its other examples go behind a preset's file."""
    whole, *parts = toml_of("jump_types.md")
    hops = (assets_directory() / "jump_types" / "hops.toml").read_text("utf-8")
    assert "title" in whole
    assert parts
    for text in (whole, *(f"{hops}\n{part}" for part in parts)):
        path = tmp_path / "my_jump.toml"
        path.write_text(text)
        kind = jump_types.load_type(str(path))
        for robot in ("anymal", "go2"):
            kind.schedule(load_robot(robot))


def test_a_sweep_is_read():
    (text,) = toml_of("cluster.md")
    assert parse_spec(text, "docs/cluster.md").robots == ("anymal",)


def test_yaml_is_read():
    found = [b for page in PAGES for b in blocks(page) if b.language == "yaml"]
    assert found
    for block in found:
        assert all("kind" in part for part in yaml.safe_load_all(block.text))


def test_a_robot_file_is_read(tmp_path):
    """The guide's tables in place of Go2's; "..." stands for the legs that the page leaves out."""
    table = parse_table(robot_files()["go2"].read_text("utf-8"), "go2.toml")
    known = {info.alias or name for name, info in RobotFile.model_fields.items()}
    seen = set()
    for text in toml_of("add_a_robot.md"):
        lines = [line for line in text.splitlines() if line.strip() != "..."]
        for name, value in parse_table("\n".join(lines), "docs/add_a_robot.md").items():
            assert name in known, name
            seen.add(name)
            mixed = isinstance(value, dict) and not {"file", "package"} & set(value)
            mixed = mixed and name in ("urdf", "legs", "posture", "limits", "reach")
            table[name] = table[name] | value if mixed else value
        RobotFile.model_validate(table)
    assert {"urdf", "legs", "reach", "limits", "control"} <= seen

"""Files that an addition touches, by where its name occurs; rooms; the table of security.md."""

from __future__ import annotations

import re
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest

import app
from app.panel.acts import Act, Button
from app.panel.jump_controls import SLIDERS
from app.panel.scenario_controls import BOARD, DISTURBANCE, PUSH
from app.panel.view_controls import SWITCHES
from app.picture.overlays import OVERLAYS
from llsrbm.formats import FORMATS
from llsrbm.robots import names

FOLDER = Path(app.__file__).parent
SOURCES = {
    path.relative_to(FOLDER).as_posix(): path.read_text("utf-8") for path in FOLDER.rglob("*.py")
}
HANDLE = "LandingMarks"  # is also asked whether the landing handle is seen
IN_ROWS = {Act.SIMULATE, Act.CANCEL, Act.EXPORT, Act.UNDO, Act.REDO, Act.SHARE}  # by the page


def files_with(pattern):
    return {name for name, source in SOURCES.items() if re.search(pattern, source)}


@pytest.mark.parametrize("field", SLIDERS, ids=lambda field: field.label)
def test_a_slider_is_a_row_of_one_table(field):
    assert files_with(f'"{re.escape(field.label)}"') == {"panel/jump_controls.py"}


@pytest.mark.parametrize("overlay", OVERLAYS.values(), ids=lambda overlay: overlay.name)
def test_an_overlay_is_one_file(overlay):
    others = {"tab/rendering.py"} if overlay.__name__ == HANDLE else set()
    assert files_with(rf"{re.escape(overlay.__module__)}\b") == others
    assert files_with(rf"class {overlay.__name__}\b.*Overlay") == {
        overlay.__module__.removeprefix("app.").replace(".", "/") + ".py"
    }


@pytest.mark.parametrize(
    "act", [act for act in Act if isinstance(act.value, Button)], ids=lambda act: act.name
)
def test_a_button_is_a_member_and_a_function(act):
    feature = files_with(rf"Act\.{act.name}\b") - {"panel/panel.py"}
    assert len(feature - {"panel/file_controls.py"}) == 1
    assert all(name.startswith("tab/") for name in feature)
    assert (files_with(rf"Act\.{act.name}\b") - feature <= {"panel/panel.py"}) or act in IN_ROWS


@pytest.mark.parametrize(
    "field", [SWITCHES[-1], *BOARD, *PUSH, *DISTURBANCE], ids=lambda field: field.label
)
def test_a_switch_is_a_row_of_a_table(field):
    places = files_with(f'"{re.escape(field.label)}"')
    assert len(places) <= 1  # impulses' labels are made of their axes


@pytest.mark.parametrize("kind", ["Format", "robot"])
def test_a_format_or_a_robot_touches_no_file(kind):
    special = {"npz", "csv", "html", "design"}  # also suffixes and words
    found = set(FORMATS) - special if kind == "Format" else set(names()) - {"anymal", "slider"}
    for name in found:
        assert files_with(f'"{re.escape(name)}"') == set(), name


def test_no_module_imports_itself_by_way_of_others():
    graph = grimp.build_graph("app", exclude_type_checking_imports=True)
    imports = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    assert tuple(TopologicalSorter(imports).static_order())  # CycleError names the circle


def test_every_module_of_the_page_is_in_a_room():
    outside = {path.name for path in Path(app.__file__).parent.glob("*.py")}
    assert outside == {
        *("__init__.py", "designer.py", "link.py", "page_template.py"),
        *("serve.py", "viser_private.py"),
    }


ROOT = Path(__file__).parents[2]
TESTS = [ROOT / "tests" / "app" / folder for folder in ("", "guard")]


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

"""The rooms of the page: every module is in one, and none in a circle."""

from __future__ import annotations

from graphlib import TopologicalSorter
from pathlib import Path

import grimp

import app


def test_no_module_imports_itself_by_way_of_others():
    graph = grimp.build_graph("app", exclude_type_checking_imports=True)
    imports = {name: graph.find_modules_directly_imported_by(name) for name in graph.modules}
    TopologicalSorter(imports).prepare()  # CycleError names the circle


def test_every_module_of_the_page_is_in_a_room():
    outside = {path.name for path in Path(app.__file__).parent.glob("*.py")}
    assert outside == {
        *("__init__.py", "designer.py", "link.py", "page_template.py"),
        *("serve.py", "viser_private.py"),
    }

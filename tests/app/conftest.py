from __future__ import annotations

import pytest

from app.designer import Designer
from app.tab.atlas import Atlases
from llsrbm.look.visuals import link_visuals
from llsrbm.robots import load_robot
from tests.app.planners import SyntheticPlanner
from tests.app.raw_tab import RawTab
from tests.app.shared_page import fresh, visit
from tests.llsrbm.atlas.tables import grid, write


@pytest.fixture(scope="session")
def designer(tmp_path_factory):
    """A designer whose planner is quick and made up, its atlas too; tabs of it share nothing."""
    sweep = tmp_path_factory.mktemp("sweep")
    write(sweep / "jumps.parquet", grid(("anymal", "slider")))
    atlases = Atlases([sweep])
    running = Designer(port=0, token="none", planner=SyntheticPlanner, atlases=atlases)
    yield running
    running.close()


@pytest.fixture
def tab(designer):
    with RawTab(designer.port) as opened:
        opened.wait_for_status("Feasible")
        yield opened


@pytest.fixture
def session(designer, tab):
    """The server's side of `tab`."""
    return designer.sessions[-1]


@pytest.fixture
def script(tab, session):
    """The page's scripts."""
    return tab.page


@pytest.fixture(scope="session")
def shared_page(browser, designer):
    """The page that tests share, for one takes seconds to open; with meshes from the start."""
    link_visuals(load_robot("anymal"), coarse=True)
    page = visit(browser, designer)
    yield page
    page.context.close()


@pytest.fixture
def page(shared_page):
    yield from fresh(shared_page)

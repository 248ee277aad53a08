from __future__ import annotations

import pytest

from app.designer import Designer
from llsrbm.look.visuals import link_visuals
from llsrbm.robots import load_robot
from tests.app.planners import SyntheticPlanner
from tests.app.raw_tab import RawTab
from tests.app.shared_page import fresh, visit


@pytest.fixture(scope="session")
def designer():
    """A designer whose planner is quick and made up; tabs of it share nothing."""
    running = Designer(port=0, token="none", planner=SyntheticPlanner)
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

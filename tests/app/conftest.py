import multiprocessing
from types import SimpleNamespace

import pytest

from app.designer import Designer
from app.tab.atlas import Atlases
from llsrbm.look.visuals import link_visuals
from llsrbm.robots import load_robot
from tests.app.planners import SyntheticPlanner
from tests.app.raw_tab import RawTab
from tests.app.shared_page import fresh, visit
from tests.llsrbm.atlas.tables import grid, write


@pytest.fixture(scope="session", autouse=True)
def planned_log(tmp_path_factory):
    """The file in which computing processes tell what they planned, see `SyntheticPlanner`.

    They are forked from one that has imported everything, which would take each of them seconds.
    """
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["pytest", "tests.app.planners"])
    log = tmp_path_factory.mktemp("planned") / "log"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANNED_LOG", str(log))
        forking = SimpleNamespace(get_context=lambda _: context)
        patch.setattr("app.workers.process.multiprocessing", forking)
        yield log


@pytest.fixture
def spawning(monkeypatch):
    """Computing processes start as users' do, in seconds, with this process' own terminal."""
    monkeypatch.setattr("app.workers.process.multiprocessing", multiprocessing)


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

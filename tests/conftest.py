"""One browser for the whole run, and which tests have to share a process."""

import os
from functools import cache

import pytest
from hypothesis import settings

# Solvers as they are everywhere: no compiler runs beside the tests, and none's work is used; tests
# of compiled functions say so themselves.
os.environ["LLSRBM_COMPILE"] = "0"

# A busy machine is no fault.
settings.register_profile("patient", deadline=None)
settings.load_profile("patient")


def pytest_collection_modifyitems(items):
    """Tests that drive the browser come last: Playwright leaves an event loop in the thread."""
    items.sort(key=lambda item: item.get_closest_marker("browser") is not None)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """With several processes, a file's tests share one, and all that drive the browser one too."""
    from xdist.scheduler import LoadScopeScheduling

    class Scheduler(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.partition("::")[0]
            return "browser" if _drives_browser(config.rootpath / file) else file

    return Scheduler(config, log)


@cache
def _drives_browser(path):
    return "mark.browser" in path.read_text(encoding="utf-8")


@pytest.fixture(scope="session")
def browser():
    """Chromium; it takes a second to start."""
    from tests.app.chromium import chromium  # needs Playwright, which other tests do not

    with chromium() as started:
        yield started

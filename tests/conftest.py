"""One browser a process, and in which order tests run."""

import os
from collections import Counter

import pytest
from hypothesis import settings

# Solvers as they are everywhere: no compiler runs beside the tests, and none's work is used; tests
# of compiled functions say so themselves.
os.environ["LLSRBM_COMPILE"] = "0"

# A busy machine is no fault.
settings.register_profile("patient", deadline=None, max_examples=50)
settings.load_profile("patient")


def pytest_collection_modifyitems(items):
    """Files with many tests first, those that drive the browser last, and their other tests first.

    Playwright leaves an event loop in the thread. What a browser on a busy machine has missed is
    tried once more, on a page brought back to its beginning; the closing line counts it.
    """
    browser = {item: item.get_closest_marker("browser") is not None for item in items}
    for item in items:
        if browser[item]:
            item.add_marker(pytest.mark.flaky(reruns=1))
    tests, driving = Counter(item.path for item in items), Counter()
    for item in items:
        driving[item.path] += browser[item]

    def rank(item):
        share = driving[item.path] / tests[item.path]
        return bool(share), share, -tests[item.path], item.path, browser[item]

    items.sort(key=rank)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """With several processes, the next free one takes the next file, in the order from above."""
    from xdist.scheduler import LoadScopeScheduling

    class Scheduler(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            return nodeid.partition("::")[0]

    config.option.loadscopereorder = False
    return Scheduler(config, log)


@pytest.fixture(scope="session")
def browser():
    """Chromium; it takes a second to start."""
    from tests.app.chromium import chromium  # needs Playwright, which other tests do not

    with chromium() as started:
        yield started

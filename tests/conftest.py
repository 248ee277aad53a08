"""One browser for the whole run, and which tests have to share a process."""

from __future__ import annotations

import pytest
from hypothesis import settings

# A busy machine is no fault.
settings.register_profile("patient", deadline=None)
settings.load_profile("patient")


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """A file's tests stay in one process, and all that drive the browser in one and the same.

    They come last: Playwright leaves an event loop in the main thread.
    """
    for item in items:
        browser = item.get_closest_marker("browser") is not None
        item.add_marker(pytest.mark.xdist_group("browser" if browser else str(item.path)))
    items.sort(key=lambda item: item.get_closest_marker("browser") is not None)


@pytest.fixture(scope="session")
def browser():
    """Chromium; it takes a second to start."""
    from tests.app.chromium import chromium  # needs Playwright, which other tests do not

    with chromium() as started:
        yield started

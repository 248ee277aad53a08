"""One browser a process; in which order, and on which process, the files run."""

import asyncio
import json
import os
import time
from collections import defaultdict
from pathlib import Path

import pytest
from hypothesis import settings

# Solvers as they are everywhere: no compiler runs beside the tests, and none's work is used; tests
# of compiled functions say so themselves.
os.environ["LLSRBM_COMPILE"] = "0"
# A process of tests a core: threads of the linear algebra would wait for each other.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# MB of solvers that a process of tests keeps: all that it needs, once each.
SOLVERS = 6000.0

# A busy machine is no fault.
settings.register_profile("patient", deadline=None, max_examples=50)
settings.load_profile("patient")

# File -> seconds, and what it uses that takes a process long to make: the browser, solvers.
DURATIONS = Path(__file__).with_name("durations.json")
BROWSER = "browser"


def pytest_addoption(parser):
    parser.addoption(
        "--record-durations",
        action="store_true",
        help="keep how long each file takes and what it uses, which orders later runs",
    )


def pytest_configure(config):
    from llsrbm.planning.solve import kept

    kept.MOST = SOLVERS
    if config.getoption("record_durations"):
        config.pluginmanager.register(Recorder(), "durations")


@pytest.hookimpl(tryfirst=True)  # before markers select
def pytest_collection_modifyitems(items):
    """Files that drive the browser first, then the longest; what uses it is marked so.

    What a browser on a busy machine has missed is tried once more, on a page brought back to its
    beginning; the closing line counts it.
    """
    durations = _durations()

    def rank(item):
        name = _file(item.nodeid)
        seconds, uses = durations.get(name, (0.0, ()))
        return BROWSER not in uses, -seconds, name

    items.sort(key=rank)
    for item in items:
        if BROWSER in item.fixturenames:
            item.add_marker(BROWSER)
            item.add_marker(pytest.mark.flaky(reruns=1))


@pytest.fixture
def refused(capfd):
    """What a command says that refuses its words: one line, and nothing on stdout."""

    from llsrbm import cli

    def line_of(*words):
        assert cli.main([*words]) == 2
        out, err = capfd.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert err.startswith("llsrbm: ")
        return err.removeprefix("llsrbm: ")

    return line_of


def _file(nodeid):
    return nodeid.partition("::")[0]


def _durations():
    return json.loads(DURATIONS.read_text("utf-8"))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    """Playwright's event loop counts as running in this thread, even while it does not."""
    loop = asyncio._get_running_loop()
    if item.get_closest_marker(BROWSER) is None:
        asyncio._set_running_loop(None)
    try:
        return (yield)
    finally:
        asyncio._set_running_loop(loop)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """A free process takes the longest file that uses nothing which another one is just making.

    A solver is built once, for what one process has built the others read from the cache; and those
    that a process has it need not read, nor plan again what others of its files have planned with
    them. Chromium is one process' alone.
    """
    from xdist.scheduler import LoadScopeScheduling

    class Scheduler(LoadScopeScheduling):
        def __init__(self, config, log):
            super().__init__(config, log)
            self.uses = defaultdict(set, {name: set(u) for name, (_, u) in _durations().items()})
            self.browsing = None
            self.has = defaultdict(set)

        def _split_scope(self, nodeid):
            return _file(nodeid)

        def _made_elsewhere(self, node):
            """What others are making, as far as it is known."""
            found = {BROWSER} if self.browsing not in (None, node) else set()
            for other, files in self.assigned_work.items():
                for name, tests in files.items():
                    if other is not node and not all(tests.values()):
                        found |= self.uses[name] - {BROWSER}
            return found

        def _assign_work_unit(self, node):
            elsewhere = self._made_elsewhere(node)
            has = self.has[node]

            def rank(name):
                uses = self.uses[name]
                return len(uses & elsewhere), -len(uses & has)

            chosen = min(self.workqueue, key=rank)
            self.workqueue.move_to_end(chosen, last=False)
            has |= self.uses[chosen] - {BROWSER}
            if BROWSER in self.uses[chosen]:
                self.browsing = node
            super()._assign_work_unit(node)

    config.option.loadscopereorder = False
    return Scheduler(config, log)


class Recorder:
    """Times the files and notes what they use; of several processes the first one writes."""

    def __init__(self):
        self.seconds, self.uses = defaultdict(float), defaultdict(set)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item):
        from llsrbm.planning.solve import solver_cache

        name, entry = _file(item.nodeid), solver_cache._entry

        def noted(subject):
            self.uses[name].add(f"{subject.of} {subject.variant}")
            return entry(subject)

        if item.get_closest_marker(BROWSER) is not None:
            self.uses[name].add(BROWSER)
        began = time.perf_counter()
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(solver_cache, "_entry", noted)
            result = yield
        self.seconds[name] += time.perf_counter() - began
        return result

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node):
        for name, (seconds, uses) in node.workeroutput["durations"].items():
            self.seconds[name] += seconds
            self.uses[name].update(uses)

    def pytest_sessionfinish(self, session):
        found = {name: (round(s, 1), sorted(self.uses[name])) for name, s in self.seconds.items()}
        if hasattr(session.config, "workeroutput"):
            session.config.workeroutput["durations"] = found
            return
        root = session.config.rootpath
        kept = {name: each for name, each in _durations().items() if (root / name).exists()}
        every = sorted((kept | found).items())
        lines = (f"  {json.dumps(name)}: {json.dumps(each)}" for name, each in every)
        DURATIONS.write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")


@pytest.fixture(scope="session")
def browser():
    """Chromium; it takes a second to start."""
    from tests.app.chromium import chromium  # needs Playwright, which other tests do not

    with chromium() as started:
        yield started

"""Five ways in which one visitor could stop the page for all others, tried against a served page.

    python -m benchmarks.denial_of_service

Starts `llsrbm serve` on loopback and tries each for some seconds: files that take long to be read,
large attributes of controls, uploads that are never sent, silent WebSockets, guesses of the token.
Another visitor asks for the page and pings its tab four times a second meanwhile; a new one enters,
opens a design and plans a jump. The exit status is 1 if an answer to the page or a ping took 1 s,
if the new visitor was kept out, or if the server's memory grew by 100 MB.
"""

import contextlib
import http.client
import math
import multiprocessing
import struct
import sys
import time
from urllib.parse import urlsplit

import viser
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from benchmarks.served import resident, serving, wait_until_ready
from llsrbm.request.design import Design, dump_design
from llsrbm.request.jump import Jump
from tests.app.raw_tab import PLANNED, RawTab

ANSWER = 1.0  # s
ENTER, PLAN = 10.0, 30.0  # s for a new visitor on a busy machine; the planning itself is slowed
MEMORY = 100.0  # MB
NAMES, SILENT, GUESSES, MESSAGES = 300_000, 50, 1000, 30
HEARD = PLANNED


class Page:
    """A page's address, and a cookie that lets in."""

    def __init__(self, url):
        parts = urlsplit(url)
        self.port, self.token = parts.port, parts.query.partition("=")[2]
        self.cookie = {"Cookie": self.request(f"/?token={self.token}")[1].partition(";")[0]}

    def request(self, path="/", headers=()):
        """(status, cookie) of a request."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=30)
        with contextlib.closing(connection):
            connection.request("GET", path, headers=dict(headers))
            answer = connection.getresponse()
            answer.read()
            return answer.status, answer.headers["Set-Cookie"] or ""

    def tab(self):
        return RawTab(self.port, additional_headers=self.cookie)

    def tabs(self, count, stack):
        """Tabs of the attacker, opened one after the other as by visitors."""
        tabs = []
        for _ in range(count):
            tabs.append(stack.enter_context(self.tab()))
            tabs[-1].wait_for_status(HEARD, PLAN)
        return tabs

    def silent_socket(self):
        protocol = [f"viser-v{viser.__version__}"]
        headers = self.cookie
        return connect(
            f"ws://127.0.0.1:{self.port}", subprotocols=protocol, additional_headers=headers
        )


class Witness:
    """A visitor who was there before, in a process of its own; `slowest` of its answers, s."""

    def __init__(self, page):
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=watch, args=(page, theirs), daemon=True)
        self._process.start()
        self._pipe.recv()  # it has a plan

    def stop(self):
        """Its slowest answer, s, and what failed."""
        self._pipe.send("stop")
        found = self._pipe.recv()
        self._process.join(20)
        return found


def watch(page, pipe):
    """Ask for the page and ping a tab four times a second, until there is a message."""
    slowest, faults = 0.0, []
    with page.tab() as tab:
        tab.wait_for_status(HEARD, PLAN)

        def request():
            status, _ = page.request(headers=page.cookie)
            assert status == 200, status

        def ping():
            assert tab._connection.ping().wait(10), "no pong"

        pipe.send("ready")
        while not pipe.poll(0.25):
            for act in (request, ping):
                start = time.perf_counter()
                try:
                    act()
                except (OSError, AssertionError, WebSocketException) as error:
                    faults.append(repr(error))
                slowest = max(slowest, time.perf_counter() - start)
        pipe.send((slowest, faults))


def visit(page, degrees):
    """Seconds in which a new visitor enters, opens a design, and has its jump planned."""
    times, start = [], time.perf_counter()
    with page.tab() as tab:
        tab.control("Save design")
        times.append(time.perf_counter() - start)
        design = dump_design(Design(Jump(twist=math.radians(degrees)))).encode()
        tab.upload("Open", "own.jump.json", design)
        tab.wait(lambda: tab.acknowledged.get("transfer"), "the upload", ENTER)
        tab.wait(lambda: round(tab.value("Twist [deg]")) == degrees, "the design", PLAN)
        tab.wait_for_status(HEARD, PLAN)
        times.append(time.perf_counter() - start)
    return times


# ---- attacks: each a context that lasts


@contextlib.contextmanager
def long_readings(page):
    """Zip files whose directory has 300,000 names, by two tabs."""
    entry = struct.pack("<4s6H3L5H2L", b"PK\1\2", 20, 20, *[0] * 3, 33, *[0] * 3, 6, *[0] * 6)
    directory = b"".join(entry + b"%06d" % k for k in range(NAMES))
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, 1000, 1000, len(directory), 0, 0)
    with contextlib.ExitStack() as stack:
        for tab in page.tabs(2, stack):
            tab.upload("Open", "motion.zip", directory + end)
        yield


@contextlib.contextmanager
def large_attributes(page):
    """A megabyte in each of some attributes."""
    with page.tab() as tab:
        uuid = tab.control("Twist [deg]")["uuid"]
        for number in range(MESSAGES):
            updates = {("label", "hint", "value")[number % 3]: str(number) + "x" * 900_000}
            tab.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})
            time.sleep(0.1)
        yield


@contextlib.contextmanager
def empty_uploads(page):
    """Files of 20 MB that are announced, and of which nothing is sent."""
    with contextlib.ExitStack() as stack:
        for tab in page.tabs(6, stack):
            start = {"source_component_uuid": tab.control("Open")["uuid"], "transfer_uuid": "none"}
            start |= {"filename": "a.npz", "mime_type": "", "part_count": 40}
            tab.send({"type": "FileTransferStartUpload", "size_bytes": 40 << 19, **start})
        yield


@contextlib.contextmanager
def silent_sockets(page):
    """As many WebSockets as there may be tabs, that send nothing."""
    with contextlib.ExitStack() as stack:
        for _ in range(SILENT):
            with contextlib.suppress(WebSocketException, OSError):
                stack.enter_context(page.silent_socket())
        yield


@contextlib.contextmanager
def guesses(page):
    """Wrong tokens, one after the other."""
    statuses = [page.request(f"/?token=guess-{k:020d}")[0] for k in range(GUESSES)]
    print(f"  {statuses.count(429)} of {GUESSES} guesses were answered with 429", flush=True)
    assert page.request(f"/?token={page.token}")[0] == 303, "the right token was refused"
    yield


def main():
    with serving() as (server, url):
        page = Page(url)
        wait_until_ready(server)
        visit(page, 20)
        visit(page, 25)
        before, failed = resident(server.pid)[0], False
        attacks = (long_readings, large_attributes, empty_uploads, silent_sockets, guesses)
        for number, attack in enumerate(attacks):
            print(attack.__doc__, flush=True)
            witness = Witness(page)
            try:
                with attack(page):
                    entered, planned = visit(page, 30 + 5 * number)
                outcome = f"entered in {entered:.1f} s, planned in {planned:.1f} s"
                failed |= entered > ENTER
            except (AssertionError, WebSocketException, OSError) as error:
                outcome, failed = f"was kept out: {error}", True
            slowest, faults = witness.stop()
            failed |= slowest > ANSWER or bool(faults)
            print(f"  others answered within {slowest:.2f} s; a new visitor {outcome}", flush=True)
            for fault in faults[:3]:
                print(f"  {fault}")
        grown = resident(server.pid)[0] - before
        print(f"memory of the server grew by {grown:.0f} MB")
        return 1 if failed or grown > MEMORY else 0


if __name__ == "__main__":
    sys.exit(main())

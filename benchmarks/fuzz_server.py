"""Nonsense against a running server.

    python -m benchmarks.fuzz_server [--messages 100000] [--tabs 50] [--requests 10000] [--seed N]

So many tabs send messages that are random, mutated from those of a real tab, or hostile, to a
designer with a made-up planner; requests and handshakes of all kinds come beside them. Witness
tabs, which send what a browser does, have to keep their own state and to answer. The exit status
is 1 after a crash, a wrong state, or memory, threads or sessions that do not come back.
"""

import argparse
import contextlib
import copy
import gc
import logging
import math
import os
import random
import sys
import threading
import time
import traceback
from collections import Counter
from pathlib import Path

import msgspec
import viser
import viser._messages
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from app.designer import Designer
from app.guard.limits import Limits, Rate
from benchmarks.hostile_requests import OWN, flood_of_requests, run_all
from tests.app.planners import SyntheticPlanner
from tests.app.raw_tab import CAMERA, PLANNED, RawTab

WITNESSES = 3
MEMORY = 100.0  # MB more than before at most
SETTLING = 60.0  # s for all that was begun to end
PACE = 0.004  # s between a tab's messages: 200 a second may come, and all tabs share two cores
# The clients share an address with the witnesses; who comes too often is tested elsewhere.
MANY = Rate(1000.0, 1000.0)

HOSTILE = [
    None, True, math.nan, math.inf, -math.inf, 1e308, -1, 0, 2**63 - 1, -(2**63), 1e-320, "",
    "x" * 10_000, "../../../../etc/passwd", "/dev/zero", "file:///etc/passwd", "C:\\nul", "\0",
    "<script>alert(1)</script>", "'; drop table jumps; --", "{}{{%s%n}}", "${jndi:ldap://x}",
    "\ud7ff\u202e", "NaN", "anymal/../../x", b"", b"\0" * 1000, [], {}, [[]] * 100,
    {"a": {"b": []}}, ["x"] * 1000, [math.nan] * 4, [0, 0, 0], (1.0, 0.0, 0.0, 0.0), "__class__",
]  # fmt: skip
PROPERTIES = [
    "value", "visible", "disabled", "label", "_impl", "__class__", "order", "nosuch", "max",
]  # fmt: skip
KINDS = sorted(
    name
    for name, kind in vars(viser._messages).items()
    if isinstance(kind, type) and issubclass(kind, viser._messages.Message)
)


def main():
    given = options()
    chance = random.Random(given.seed)
    crashes = Crashes()
    tabs = given.tabs + WITNESSES + 10
    limits = Limits(
        tabs=tabs, tabs_per_peer=tabs, handshakes=MANY, handshakes_per_peer=MANY, pages=MANY,
        pages_per_peer=MANY, wrong_tokens=MANY, open_s=1.0,
    )  # fmt: skip
    designer = Designer(port=0, token="none", planner=SyntheticPlanner, limits=limits)
    # A first round, so that what is loaded once is not taken for what is not given back.
    visits(designer, given.tabs)
    settle(designer)
    before = state(designer)
    print(f"before: {before}", flush=True)
    crashes.lines.clear()
    begun = time.monotonic()

    with contextlib.ExitStack() as stack:
        witnesses = [Witness(stack.enter_context(RawTab(designer.port)), i, designer)
                     for i in range(WITNESSES)]  # fmt: skip
        recorded = record(designer)
        others = {uuid for w in witnesses for uuid in list(w.tab.controls)}
        wrong = Watching(witnesses)
        wrong.start()
        sent = flood_of_messages(designer, given, chance, recorded, sorted(others))
        answers = flood_of_requests(designer, given, chance)
        wrong.stop()
        print(f"messages: {sum(sent.values())} ({dict(sent.most_common())})")
        print(f"requests: {sum(answers.values())} ({dict(answers.most_common())})")
        print(f"witnesses: {wrong.answered} answers, {len(wrong.faults)} wrong or missing")
    for fault in wrong.faults[:10]:
        print(f"  {fault}")
    settle(designer)
    after = state(designer)
    print(f"after: {after} ({time.monotonic() - begun:.0f} s)")
    print(f"log: {len(crashes.lines)} lines, {len(crashes.found)} crashes")
    for line in [*crashes.found[:10], *crashes.lines[:40]]:
        print(f"  {line}")
    designer.close()
    grown = after["memory_mb"] - before["memory_mb"]
    left = [key for key in ("sessions", "tabs", "threads") if after[key] > before[key]]
    print(f"memory grew by {grown:.0f} MB; {', '.join(left) or 'nothing'} left behind")
    return 1 if crashes.found or wrong.faults or left or grown > MEMORY else 0


def options():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--messages", type=int, default=100_000)
    parser.add_argument("--tabs", type=int, default=50)
    parser.add_argument("--requests", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    return parser.parse_args()


# ---- the server, seen from outside


class Crashes(logging.Handler):
    """Everything that reaches the log; a traceback in it, or in a thread, is a crash."""

    def __init__(self):
        super().__init__(logging.WARNING)
        self.lines, self.found = [], []
        logging.getLogger().addHandler(self)
        logging.getLogger("websockets.client").disabled = True  # the fuzzer's own
        threading.excepthook = self.of_thread
        sys.stderr = self
        sys.unraisablehook = lambda hook: self.found.append(f"unraisable: {hook.exc_value!r}")

    def emit(self, record):
        self.lines.append(record.getMessage()[:300])
        if record.exc_info and record.exc_info[1] is not None:
            self.found.append("".join(traceback.format_exception(record.exc_info[1]))[-1500:])

    def write(self, text):
        """In place of stderr: viser prints there what callbacks raise."""
        if "Traceback" in text:
            self.found.append(text[-1500:])
        elif text.strip():
            self.lines.append(text.strip()[:300])

    def flush(self):
        pass

    def of_thread(self, failed):
        self.found.append(f"{failed.thread}: {failed.exc_value!r}")


def state(designer):
    gc.collect()
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return {
        "memory_mb": round(pages * os.sysconf("SC_PAGE_SIZE") / 1e6, 1),
        "sessions": len(designer.sessions),
        "tabs": len(designer._server.door.tabs),
        "pending": len(designer._server.door.pending),
        "threads": sum(not t.name.startswith("ThreadPool") for t in threading.enumerate()),
    }


def settle(designer):
    """Wait until all tabs are gone, and with them what they began."""
    end = time.monotonic() + SETTLING
    threads = None
    while time.monotonic() < end:
        door = designer._server.door
        former, threads = threads, threading.active_count()
        if not designer.sessions and not door.tabs | door.pending and threads == former:
            return
        time.sleep(1.0)


def visits(designer, count):
    with contextlib.ExitStack() as stack:
        tabs = [stack.enter_context(RawTab(designer.port)) for _ in range(count)]
        for tab in tabs:
            tab.wait_for_status(PLANNED, timeout=120)
            tab.set("Twist [deg]", 10)


# ---- witnesses


class Witness:
    """A tab that nobody else should be able to change."""

    def __init__(self, tab, number, designer):
        self.tab, self.number, self.step = tab, number, 0
        tab.wait_for_status(PLANNED, timeout=60)
        self.session = designer.sessions[-1]

    def check(self):
        """Ask for a jump of its own, and expect that one, here and in the server."""
        self.step += 1
        twist = 1 + (7 * self.step + 11 * self.number) % 50  # deg
        self.tab.set("Twist [deg]", twist)

        def planned():
            plan = self.session.state.plan
            return plan is not None and math.isclose(plan.jump.twist, math.radians(twist))

        self.tab.wait(planned, f"a plan of {twist} deg by witness {self.number}", timeout=60)
        time.sleep(0.3)
        jump = self.session.state.plan.jump
        if not math.isclose(jump.twist, math.radians(twist)) or jump.robot != "anymal":
            raise AssertionError(f"witness {self.number}: {jump} instead of {twist} deg")
        if self.tab.closed.is_set():
            raise AssertionError(f"witness {self.number} was closed")


class Watching(threading.Thread):
    def __init__(self, witnesses):
        super().__init__(daemon=True)
        self.witnesses, self.faults, self.answered = witnesses, [], 0
        self._end = threading.Event()

    def run(self):
        while not self._end.is_set():
            self._round()

    def stop(self):
        self._end.set()
        self.join()
        self._round()  # and when all is over

    def _round(self):
        for witness in self.witnesses:
            try:
                witness.check()
                self.answered += 1
            except Exception as error:  # noqa: BLE001  # what it looks for
                self.faults.append(f"{type(error).__name__}: {error}")


# ---- messages


def record(designer):
    """Messages of a tab whose every control is moved, and more that a page can send."""
    recorded = [CAMERA]
    with RawTab(designer.port) as tab:
        tab.wait_for_status(PLANNED, timeout=60)
        for uuid, message in list(tab.controls.items()):
            value = message.get("value", True)
            recorded.append({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})
        source = tab.control("Open")["uuid"]
        upload = {"source_component_uuid": source, "transfer_uuid": "a transfer"}
        start = {"filename": "a.npz", "mime_type": "", "part_count": 1, "size_bytes": 4}
        recorded.append({"type": "FileTransferStartUpload", **start, **upload})
        recorded.append(
            {"type": "FileTransferPart", "part_index": 0, "content": b"PK\3\4", **upload}
        )
        recorded.append({"type": "LocalStorageGetItemResponseMessage", "value": "{}", "error": None,
                         "request_uuid": "a request"})  # fmt: skip
        recorded.append({"type": "ShareUrlRequest"})
        recorded.append({"type": "ShareUrlDisconnect"})
    return recorded


def message(chance, recorded, own, foreign):
    """One message: its kind, and its bytes or text."""
    # Of the first three most end their connection, and a new one takes 0.1 s.
    weights = {"random": 2, "flipped": 2, "mutated": 8, "hostile": 60, "foreign": 28}
    (kind,) = chance.choices(list(weights), list(weights.values()))
    if kind == "random":
        return kind, chance.randbytes(chance.randrange(200))
    made = copy.deepcopy(chance.choice(recorded))
    if "uuid" in made:
        made["uuid"] = chance.choice(own)
    if kind == "foreign" and "uuid" in made:
        made["uuid"] = chance.choice(foreign)
    elif kind == "mutated":
        key = chance.choice(list(made))
        match chance.randrange(4):
            case 0:
                made[key] = chance.choice(HOSTILE)
            case 1:
                del made[key]
            case 2:
                made[chance.choice(PROPERTIES)] = chance.choice(HOSTILE)
            case _:
                made["type"] = chance.choice(KINDS)
    elif kind == "hostile" and "updates" in made:
        made["updates"] = {chance.choice(["value", "value", *PROPERTIES]): chance.choice(HOSTILE)}
    elif kind == "hostile":
        made[chance.choice(list(made))] = chance.choice(HOSTILE)
    try:
        content = msgspec.msgpack.encode(made)
    except (OverflowError, UnicodeEncodeError, msgspec.MsgspecError):
        content = b"\xc1"
    if kind == "flipped":
        broken = bytearray(content)
        for _ in range(chance.randrange(1, 4)):
            broken[chance.randrange(len(broken))] = chance.randrange(256)
        content = bytes(broken)
    return kind, content


def flood_of_messages(designer, given, chance, recorded, foreign):
    sent = Counter()
    lock = threading.Lock()
    share = -(-given.messages // given.tabs)

    def one_tab(seed):
        mine, left, counted = random.Random(seed), share, Counter()
        while left > 0:
            try:
                left = talk(mine, left, counted)
            except (WebSocketException, OSError, AssertionError):
                counted["reconnected"] += 1
        with lock:
            sent.update(counted)

    def talk(mine, left, counted):
        try:
            with Quiet(designer.port) as tab:
                own = tab.uuids()
                while left > 0 and not tab.closed:
                    kind, content = message(mine, recorded, own, foreign)
                    tab.send(content)
                    counted[kind] += 1
                    left -= 1
                    time.sleep(PACE)
        except (WebSocketException, OSError):
            counted["closed"] += 1
        return left

    run_all(one_tab, [chance.randrange(1 << 30) for _ in range(given.tabs)])
    del sent["reconnected"]
    closed = sent.pop("closed", 0)
    print(f"tabs that sent nonsense were closed {closed} times", flush=True)
    return sent


class Quiet:
    """A tab that keeps nothing but the names of its controls."""

    def __init__(self, port):
        self._connection = connect(
            f"ws://{OWN}:{port}", subprotocols=[f"viser-v{viser.__version__}"], max_size=None,
            compression=None,
        )  # fmt: skip
        self._uuids, self.closed = set(), False
        self._reader = threading.Thread(target=self._read, daemon=True)

    def __enter__(self):
        self._reader.start()
        self.send(msgspec.msgpack.encode(CAMERA))
        return self

    def __exit__(self, *_):
        self._connection.close()
        self._reader.join()

    def send(self, content):
        self._connection.send(content)

    def uuids(self):
        end = time.monotonic() + 5
        while len(self._uuids) < 20 and time.monotonic() < end and not self.closed:
            time.sleep(0.05)
        return sorted(self._uuids) or ["nosuch"]

    def _read(self):
        import zstandard

        with contextlib.suppress(WebSocketException, OSError):
            for packet in self._connection:
                if len(self._uuids) >= 20:
                    continue
                size, compressed = (int.from_bytes(packet[i : i + 8], "little") for i in (0, 8))
                inner = zstandard.ZstdDecompressor().decompress(
                    packet[16 : 16 + compressed], max_output_size=size
                )
                for sent in msgspec.msgpack.decode(inner)["messages"]:
                    if "uuid" in sent and str(sent["type"]).startswith("Gui"):
                        self._uuids.add(sent["uuid"])
        self.closed = True


if __name__ == "__main__":
    sys.exit(main())

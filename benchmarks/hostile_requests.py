"""Requests and handshakes as no browser sends them, by the thousand; for benchmarks.fuzz_server."""

import random
import socket
import threading
from collections import Counter

import viser

OWN = "127.0.0.1"


def flood_of_requests(designer, given, chance, threads=8):
    answers = Counter()
    lock = threading.Lock()
    share = -(-given.requests // threads)

    def one(seed):
        mine, counted = random.Random(seed), Counter()
        for _ in range(share):
            counted[answer_of(designer.port, request(mine, designer.port), mine)] += 1
        with lock:
            answers.update(counted)

    run_all(one, [chance.randrange(1 << 30) for _ in range(threads)])
    return answers


def request(chance, port):
    method = chance.choice(["GET"] * 6 + ["HEAD", "POST", "OPTIONS", "get", "", "\x16\x03\x01"])
    path = chance.choice(
        ["/", "/", "/index.html", "/?token=x", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd",
         "//evil.example", "http://evil.example/", "/" + "a" * chance.randrange(9000), "*", "/\0",
         "/?" + "a=b&" * 500, "/..\\..\\x", "/assets/index.js"]
    )  # fmt: skip
    lines = [f"{method} {path} {chance.choice(['HTTP/1.1'] * 8 + ['HTTP/1.0', 'HTTP/9', ''])}"]
    hosts = [f"{OWN}:{port}"] * 5
    hosts += ["evil.example", "", "[::1", f"{OWN}@evil.example", "x" * 3000]
    lines += [f"Host: {chance.choice(hosts)}" for _ in range(chance.choice([1, 1, 1, 1, 0, 2]))]
    if chance.random() < 0.5:
        lines += ["Connection: Upgrade", f"Upgrade: {chance.choice(['websocket', 'h2c', 'x'])}"]
        lines += chance.choice([["Sec-WebSocket-Version: 13"], ["Sec-WebSocket-Version: 99"], []])
        key = chance.choice(["Z3VhcmQgY2hlY2sgb25seQ==", "x", "", "=" * 500])
        version = chance.choice(["0", viser.__version__])
        lines += [f"Sec-WebSocket-Key: {key}", f"Sec-WebSocket-Protocol: viser-v{version}"]
    if chance.random() < 0.4:
        lines.append("Origin: " + chance.choice(
            [f"http://{OWN}:{port}", "null", "http://evil.example", "", "http://[", "\xff"]
        ))  # fmt: skip
    lines += chance.choice([[], [], ["Cookie: llsrbm-1=1.2"], ["Cookie: " + "a=b;" * 1000],
                            ["Content-Length: 5"], ["Transfer-Encoding: chunked"], ["x" * 20_000],
                            ["a: b"] * 300, [": x"], ["Sec-Fetch-Site: cross-site"]])  # fmt: skip
    made = "\r\n".join([*lines, "", ""]).encode("latin-1")
    if chance.random() < 0.1:
        made = made[: chance.randrange(len(made))]
    if chance.random() < 0.1:
        made = chance.randbytes(chance.randrange(1, 300))
    return made


def answer_of(port, content, chance):
    """Status of the answer."""
    try:
        with socket.create_connection((OWN, port), timeout=30) as plain:
            plain.sendall(content)
            if chance.random() < 0.3:
                return "left at once"
            head = plain.recv(64)
            if head.startswith(b"HTTP/1.1 101"):
                plain.sendall(chance.randbytes(chance.randrange(100)))
    except TimeoutError:
        return "no answer"
    except OSError:
        return "cut"
    return head[9:12].decode("ascii", "replace") if head.startswith(b"HTTP/1.1 ") else "cut"


def run_all(work, seeds):
    threads = [threading.Thread(target=work, args=(seed,)) for seed in seeds]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

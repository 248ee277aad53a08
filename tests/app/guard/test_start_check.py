"""A server whose guard does not hold is not served, whatever the cause."""

import contextlib
from http import HTTPStatus

import pytest

import app.viser_private
from app.designer import Designer
from app.guard.policy import Decision, Guard
from app.guard.start_check import GuardMissing, check
from tests.app.planners import SyntheticPlanner
from tests.app.raw_http import asked

TOKEN = "a-token-of_32-characters-exactly"


@pytest.fixture
def closed(monkeypatch):
    """The servers that were closed."""
    stopped = []
    stop = app.viser_private.DesignerServer.stop

    def stop_and_note(server):
        stopped.append(server)
        stop(server)

    monkeypatch.setattr(app.viser_private.DesignerServer, "stop", stop_and_note)
    return stopped


def refused_to_start(match, closed, **options):
    with pytest.raises(GuardMissing, match=match) as refused:
        Designer(port=0, **options)
    assert "\n" not in str(refused.value)
    (server,) = closed
    with pytest.raises(OSError, match="refused"):
        asked(server.get_port())


def test_it_does_not_start_when_the_hook_is_not_called(monkeypatch, closed):
    monkeypatch.setattr(app.viser_private, "_behind", lambda _: contextlib.nullcontext())
    refused_to_start("under another name was answered with 200 instead of 403", closed)


@pytest.mark.parametrize(
    ("let_in", "told"),
    [
        (lambda request: request.host.endswith("invalid"), "under another name was .* with 200"),
        (
            lambda request: any("invalid" in origin for origin in request.values("origin")),
            "a WebSocket of another site was answered with 101 instead of 403",
        ),
        (
            lambda request: "invalid" not in str(request) and not request.upgrade,
            "a request without the token was answered with 200 instead of 401",
        ),
        (
            lambda request: "invalid" not in str(request) and request.upgrade,
            "a WebSocket without the token was answered with 101 instead of 401",
        ),
    ],
)
def test_it_does_not_start_when_anything_is_let_in(monkeypatch, closed, let_in, told):
    decide = Guard.decide

    def decide_badly(guard, request, *tabs):
        if not let_in(request):
            return decide(guard, request, *tabs)
        return Decision(HTTPStatus.SWITCHING_PROTOCOLS if request.upgrade else HTTPStatus.OK)

    monkeypatch.setattr(Guard, "decide", decide_badly)
    refused_to_start(told, closed, token=TOKEN)


def test_it_does_not_start_without_headers(monkeypatch, closed):
    monkeypatch.setattr(Guard, "headers", lambda *_: ())
    refused_to_start("the guard did not take hold", closed)


def test_it_does_not_start_when_the_guard_fails(monkeypatch, closed):
    monkeypatch.setattr(Guard, "decide", lambda *_: 1 / 0)
    refused_to_start("answered with 500 instead of 403", closed)


def test_a_server_that_does_not_answer_is_none():
    with pytest.raises(GuardMissing, match="does not answer to its own check"):
        check("127.0.0.1", 1, token=False)


@pytest.mark.parametrize("host", ["0.0.0.0", "127.0.0.2", "localhost", "::1"])
def test_a_sound_one_starts_in_silence(host, caplog, capfd):
    designer = Designer(host, 0, planner=SyntheticPlanner, token=TOKEN)
    try:
        assert caplog.records == []
        assert capfd.readouterr() == ("", "")
    finally:
        designer.close()

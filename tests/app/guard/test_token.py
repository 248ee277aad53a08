import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.guard.token import COOKIE_LIFE, Access
from llsrbm.errors import InputError
from tests.app.guard.clock import Clock

TOKEN = "a-token-of_32-characters-exactly"
HOST = "10.0.0.1:8080"


@pytest.fixture
def clock():
    return Clock(1_700_000_000.0)


@pytest.fixture
def access(clock):
    return Access(TOKEN, 8080, clock)


def pair(access, host=HOST):
    return access.cookie(host).partition(";")[0]


def test_a_token_is_generated_anew_each_time():
    made = {Access.chosen(None).token for _ in range(20)}
    assert len(made) == 20
    assert all(len(token) == 43 for token in made)  # 256 bits


@pytest.mark.parametrize(("token", "required"), [(None, True), ("none", False), (TOKEN, True)])
def test_only_none_needs_no_token(token, required):
    access = Access.chosen(token)
    assert access.required is required
    assert access.accepts_token(TOKEN) is (token == TOKEN)
    assert bool(access.query) is required


@pytest.mark.parametrize(
    "token", ["", "None", "short", "x" * 15, "x" * 257, "x" * 15 + "/", "ä" * 16, "x" * 16 + "\n"]
)
def test_a_token_that_can_be_guessed_or_must_be_escaped_is_refused(token):
    with pytest.raises(InputError, match=r"--token: expected 16 to 256 letters") as refused:
        Access.chosen(token)
    assert "\n" not in str(refused.value)


def test_the_cookie_is_hidden_from_scripts_and_from_other_sites(access):
    header = access.cookie(HOST)
    assert header.startswith("llsrbm-8080=")
    for attribute in ("HttpOnly", "SameSite=Strict", "Path=/", f"Max-Age={COOKIE_LIFE}"):
        assert f"; {attribute}" in header
    assert "Domain" not in header
    assert TOKEN not in header


def test_the_cookie_is_accepted_among_others_until_it_expires(access, clock):
    cookie = pair(access)
    assert access.accepts_cookie([f"a=b; {cookie}; c"], HOST)
    assert access.accepts_cookie(["a=b", cookie], HOST)
    clock.now += COOKIE_LIFE - 1
    assert access.accepts_cookie([cookie], HOST)
    clock.now += 1
    assert not access.accepts_cookie([cookie], HOST)


def test_a_cookie_of_an_earlier_run_another_port_or_another_host_is_refused(access, clock):
    cookie = pair(access)
    assert Access(TOKEN, 8080, clock).accepts_cookie([cookie], HOST)  # the same token survives
    assert not Access("another" + TOKEN, 8080, clock).accepts_cookie([cookie], HOST)
    renamed = cookie.replace("8080", "8081", 1)
    assert not Access(TOKEN, 8081, clock).accepts_cookie([renamed], HOST)
    assert not access.accepts_cookie([cookie], "10.0.0.2:8080")
    assert not Access(None, 8080, clock).accepts_cookie([cookie], HOST)


@given(st.data())
def test_a_cookie_that_was_tampered_with_is_refused(data):
    access = Access(TOKEN, 8080, lambda: 1_700_000_000.0)
    name, value = pair(access).split("=")
    at = data.draw(st.integers(0, len(value) - 1))
    other = data.draw(st.characters(codec="ascii").filter(lambda c: c not in value[at] + ";= \t"))
    assert not access.accepts_cookie([f"{name}={value[:at]}{other}{value[at + 1 :]}"], HOST)


@given(st.lists(st.text(), max_size=3), st.text(), st.text())
def test_nothing_else_is_accepted_and_nothing_breaks(headers, host, token):
    access = Access(TOKEN, 8080)
    assert not access.accepts_cookie(headers, host)
    assert not access.accepts_cookie([f"llsrbm-8080={token}"], host)
    assert not access.accepts_token(token)


def test_the_token_itself_is_no_cookie(access):
    assert not access.accepts_cookie([f"llsrbm-8080={TOKEN}"], HOST)

from __future__ import annotations

from unittest.mock import MagicMock, call

import pytest

from app.motion.clip import Clip
from app.session.player import BrowserPlayer, ServerPlayer
from app.viser_link.page_link import PlayerMoved
from llsrbm.motion.timeline import Timeline

EVENTS = Timeline((), (), "", 2.0)


def lasting(seconds):
    return Clip((), seconds)


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def shown():
    return []


@pytest.fixture
def player(clock, shown):
    made = ServerPlayer(lambda _, time: shown.append(time), clock=clock)
    made.load(lasting(2.0), EVENTS)
    shown.clear()
    return made


def run(player, clock, seconds):
    """As the session does: sleep until a step is due."""
    end = clock.now + seconds
    while player.wait is not None and clock.now + player.wait <= end:
        clock.now += player.wait
        player.step()
    clock.now = end
    player.step()


def test_it_plays_in_real_time_at_sixty_frames_a_second(player, clock, shown):
    player.play()
    run(player, clock, 1.0)
    assert player.time == pytest.approx(1.0, abs=1 / 60)
    assert len(shown) == pytest.approx(60, abs=2)


def test_paused_it_wants_nothing(player, clock, shown):
    player.play()
    run(player, clock, 0.5)
    player.pause()
    shown.clear()
    assert player.wait is None
    clock.now += 5
    player.step()
    assert shown == []
    assert player.time == pytest.approx(0.5, abs=1 / 60)


def test_speed_scales_time(player, clock):
    player.set_speed(0.25)
    player.play()
    run(player, clock, 2.0)
    assert player.time == pytest.approx(0.5, abs=1 / 60)


def test_a_loop_rests_at_the_end_then_starts_anew(player, clock):
    player.play()
    run(player, clock, 2.5)
    assert player.time == 2.0
    run(player, clock, 0.7)
    assert 0.4 < player.time < 0.6


def test_without_loop_it_stops_at_the_end_and_play_starts_from_the_beginning(player, clock):
    player.set_loop(False)
    player.play()
    run(player, clock, 3.0)
    assert (player.playing, player.time) == (False, 2.0)
    player.play()
    run(player, clock, 0.5)
    assert player.time == pytest.approx(0.5, abs=2 / 60)


def test_seeking_keeps_within_the_motion(player, shown):
    player.seek(9.0)
    player.seek(-1.0)
    assert shown == [2.0, 0.0]


def test_a_new_motion_keeps_the_time_as_far_as_it_lasts_and_is_the_one_shown(clock):
    clips = []
    player = ServerPlayer(lambda clip, time: clips.append((clip, time)), clock=clock)
    player.load(lasting(2.0), EVENTS)
    player.play()
    run(player, clock, 1.5)
    short = lasting(1.0)
    player.load(short, EVENTS)
    assert (player.playing, player.time) == (True, 1.0)
    assert clips[-1] == (short, 1.0)


def test_a_stalled_server_does_not_catch_up_in_a_burst(player, clock, shown):
    player.play()
    player.step()
    clock.now += 1.0
    shown.clear()
    run(player, clock, 0.1)
    assert len(shown) <= 8


@pytest.mark.parametrize("cleared", [False, True])
def test_nothing_loaded_nothing_plays(player, clock, shown, cleared):
    if cleared:
        player.play()
        player.clear()
    else:
        player = ServerPlayer(lambda _, time: shown.append(time), clock=clock)
    player.play()
    clock.now += 1
    player.step()
    assert (player.playing, player.wait, shown) == (False, None, [])


# ---- in the browser


@pytest.fixture
def bridge():
    return MagicMock(spec_set=("load", "clear", "play", "pause", "seek", "set_speed", "set_loop"))


def test_the_page_is_told_what_to_do_and_no_frame(bridge):
    player, clip = BrowserPlayer(bridge), lasting(2.0)
    player.load(clip, EVENTS)
    player.play()
    player.step()
    player.pause()
    player.seek(0.5)
    player.set_speed(0.25)
    player.set_loop(False)
    player.clear()
    assert player.wait is None
    assert bridge.mock_calls == [
        call.load(clip, EVENTS),
        call.play(),
        call.pause(),
        call.seek(0.5),
        call.set_speed(0.25),
        call.set_loop(False),
        call.clear(),
    ]


def test_with_nothing_loaded_the_page_is_not_told_to_play(bridge):
    player = BrowserPlayer(bridge)
    player.play()
    assert not player.playing
    assert bridge.mock_calls == []


def test_it_believes_the_page(bridge):
    player = BrowserPlayer(bridge)
    player.load(lasting(2.0), EVENTS)
    player.play()
    assert player.playing
    player.hear(PlayerMoved(0.75, False))
    assert (player.time, player.playing) == (0.75, False)


@pytest.mark.parametrize(("told", "time"), [(9.0, 2.0), (-1.0, 0.0)])
def test_what_the_page_says_is_kept_within_the_motion(bridge, told, time):
    player = BrowserPlayer(bridge)
    player.load(lasting(2.0), EVENTS)
    player.hear(PlayerMoved(told, True))
    assert player.time == time

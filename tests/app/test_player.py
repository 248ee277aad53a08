from __future__ import annotations

import pytest

from app.player import ServerPlayer


@pytest.fixture
def clock():
    class Clock:
        now = 100.0

        def __call__(self):
            return self.now

    return Clock()


@pytest.fixture
def shown():
    return []


@pytest.fixture
def player(clock, shown):
    made = ServerPlayer(shown.append, clock=clock)
    made.load(2.0)
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


def test_a_new_motion_keeps_the_time_as_far_as_it_lasts(player, clock):
    player.play()
    run(player, clock, 1.5)
    player.load(1.0)
    assert (player.playing, player.time) == (True, 1.0)


def test_a_stalled_server_does_not_catch_up_in_a_burst(player, clock, shown):
    player.play()
    player.step()
    clock.now += 1.0
    shown.clear()
    run(player, clock, 0.1)
    assert len(shown) <= 8


def test_nothing_loaded_nothing_plays(clock, shown):
    player = ServerPlayer(shown.append, clock=clock)
    player.play()
    assert not player.playing

"""Ghosts are drawn whole, and only while they differ from the solid robot."""

from dataclasses import replace

import numpy as np

from app.motion import colours
from app.picture.picture import Ghost
from app.picture.scene import Scene
from tests.app.picture.pictures import picture, planned
from tests.app.picture.recorded import RecordedClient, track_of


def seen(simulated, node="/shade/base"):
    """(F,) whether a part of the plan's ghost has a size."""
    shown = replace(picture(), simulated=simulated)
    time, track = track_of(Scene(RecordedClient()).draw(shown), node)
    assert len(time) == len(track.scale) == len(track.position)
    return time, track.scale[:, 0] > 0


def test_a_ghost_in_the_same_place_is_not_drawn():
    assert not seen(planned().frames)[1].any()


def test_a_whole_ghost_is_drawn_while_a_part_of_it_is_two_centimetres_away():
    frames = planned().frames
    late = frames.time > 0.5
    for far, drawn in ((0.01, False), (0.03, True)):
        position = frames.body_position.copy()
        position[late, 0] += [0.0, far, 0.0]
        time, there = seen(replace(frames, body_position=position))
        assert there[time > 0.6].all() == there.any() == drawn
        assert not there[time < 0.4].any()
        # Its legs are where the plan has them, and come with the trunk.
        _, leg = seen(replace(frames, body_position=position), "/shade/LF_SHANK")
        assert np.array_equal(leg, there)


def test_a_simulation_that_goes_on_is_compared_with_the_plans_end():
    frames = planned().frames
    time = np.append(frames.time, frames.end + np.array([0.5, 1.0]))
    index = np.minimum(np.arange(len(time)), len(frames.time) - 1)
    position = frames.body_position[index].copy()
    position[-1] += [0.1, 0.0, 0.0]

    def longer(of, *names):
        return replace(of, **{name: getattr(of, name)[index] for name in names})

    motion = longer(frames.motion, "com", "base_quat", "foot_position", "contact")
    drawn = ("body_wxyz", "stands", "inertia_axes", "inertia_wxyz", "foot_force", "pressed_at")
    fallen = replace(longer(frames, *drawn), motion=motion, time=time, body_position=position)
    instants, there = seen(fallen)
    assert instants[-1] == time[-1]
    assert there[-1]
    assert not there[: len(frames.time) - 9].any()


def test_a_pin_of_another_robot_is_drawn_throughout():
    other = planned("slider")
    shown = replace(
        picture(), ghosts=(Ghost(picture("slider").robot, other.frames, colours.PINNED[0]),)
    )
    _, track = track_of(Scene(RecordedClient()).draw(shown), "/pinned/1/pelvis")
    assert track.scale is None

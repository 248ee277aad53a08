"""Robots beside each other keep out of each other's way, and have names and ellipsoids."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from app.motion import colours
from app.picture.picture import Standing
from app.picture.scene import Scene
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.scenario import Scenario
from tests.app.picture.pictures import picture, planned
from tests.app.picture.recorded import RecordedClient, track_of

TINTS = (*colours.PINNED[:2], colours.SIMULATED)


def row_of(*motions, blocks=()):
    shown = picture()
    row = tuple(
        Standing(f"no. {k}", shown.robot, motion.frames, motion.frames, tint, tuple(blocks))
        for k, (motion, tint) in enumerate(zip(motions, TINTS))
    )
    return replace(shown, planned=motions[-1], row=row)


@pytest.fixture(scope="module")
def three():
    motions = planned(twist=0.3), planned(twist=1.2), planned()
    client = RecordedClient()
    clip = Scene(client).draw(row_of(*motions))
    return client.scene, clip, motions


def way_of(clip, node):
    return track_of(clip, node)[1].position


def test_the_one_that_is_shown_stays_and_the_others_stand_to_its_side(three):
    _, clip, motions = three
    ways = [motion.frames.body_position[:, 0] for motion in motions]
    assert way_of(clip, "/links/base") == pytest.approx(ways[2])
    for place in (0, 1):
        by = way_of(clip, f"/row/{place}-1/base") - ways[place]
        assert np.ptp(by, axis=0) == pytest.approx(0, abs=1e-9)
        assert by[0, [0, 2]] == pytest.approx(0)
        assert by[0, 1] < -0.7 * (2 - place)


def test_none_is_ever_where_another_has_been(three):
    _, clip, _ = three
    names = [f"/row/{place}-1/" for place in (0, 1)] + ["/links/"]
    rooms = []
    for name in names:
        tracks = [
            track.position[:, 1]
            for channel in clip.channels
            for track in channel.tracks
            if track.nodes[0].startswith(name)
        ]
        rooms.append((min(t.min() for t in tracks), max(t.max() for t in tracks)))
    assert all(high + 0.2 < low for (_, high), (low, _) in pairwise(rooms))


def test_each_has_its_name_above_it_and_its_ellipsoid_in_its_colour(three):
    scene, clip, motions = three
    labels = [node for name, node in scene.nodes.items() if name.startswith("/row-name/")]
    assert [label.text for label in labels] == ["no. 0", "no. 1", "no. 2"]
    top = max(motion.frames.body_position[..., 2].max() for motion in motions)
    assert all(label.position[2] > top for label in labels)
    for place, motion in enumerate(motions):
        rings = scene.nodes[f"/row-inertia/{place}/wires"]
        assert rings.values[1] == TINTS[place]
        _, track = track_of(clip, rings.name)
        assert track.scale == pytest.approx(motion.frames.inertia_axes)
    assert not scene.seen() & {"/ellipsoid/planned", "/ellipsoid/srbm"}


def test_the_camera_sees_all_of_them_from_ahead(three):
    _, clip, _ = three
    target = clip.camera_target
    assert target.direction[0] > 0.9
    assert np.ptp(target.points[:, 1]) > 2.5


def test_what_one_lands_on_stands_at_its_side_too():
    motion = planned(height=0.1)
    blocks = surroundings(picture().robot, motion.plan, Scenario()).blocks
    client = RecordedClient()
    shown = row_of(planned(twist=0.3), motion, blocks=blocks)
    clip = Scene(client).draw(replace(shown, simulated=motion.frames, blocks=blocks))
    aside, own = way_of(clip, "/row-box/0")[0], way_of(clip, "/blocks/0")[0]
    assert aside[1] < own[1] - max(block.size[1] for block in blocks)
    assert aside[[0, 2]] == pytest.approx(own[[0, 2]])


def test_one_that_begins_far_away_is_brought_beside():
    motion = planned(twist=0.3)
    frames, away = motion.frames, np.array([3.0, 1.0, 0.0])
    states = replace(frames.motion, com=frames.com + away)
    frames = replace(frames, motion=states, body_position=frames.body_position + away)
    far = replace(motion, frames=frames)
    clip = Scene(RecordedClient()).draw(row_of(far, planned()))
    apart = way_of(clip, "/row/0-1/base")[0] - way_of(clip, "/links/base")[0]
    assert apart[[0, 2]] == pytest.approx(0, abs=0.02)
    assert apart[1] < -0.7


def test_a_row_that_goes_is_hidden_and_found_again():
    client = RecordedClient()
    scene, shown = Scene(client), row_of(planned(twist=0.3), planned())
    scene.draw(shown)
    seen, made = client.scene.seen(), len(client.scene.made)
    scene.draw(replace(shown, row=()))
    assert not any(name.startswith("/row") for name in client.scene.seen())
    assert "/ellipsoid/planned" in client.scene.seen()
    scene.draw(shown)
    assert {name for name in client.scene.seen() if name.startswith("/row")} == {
        name for name in seen if name.startswith("/row")
    }
    assert not [name for name in client.scene.made[made:] if name.startswith("/row")]

"""`Scene.draw`: what changed is drawn, and nothing else."""

import time
from dataclasses import replace

import numpy as np
import pytest

from app.motion import colours
from app.picture import robot_nodes
from app.picture.overlays import AT_FIRST, OVERLAYS
from app.picture.picture import Ghost, Picture
from app.picture.scene import Scene
from llsrbm.look.visuals import link_visuals
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing
from llsrbm.robots import load_robot
from tests.app.picture.pictures import picture, planned
from tests.app.picture.recorded import RecordedClient, names_in, track_of


class Drawn:
    """A scene, and what it sent."""

    def __init__(self, *pictures):
        self.client = RecordedClient()
        self.nodes = self.client.scene.nodes
        self.scene = Scene(self.client)
        for each in pictures:
            self.clip = self.scene.draw(each)

    def changes(self, shown):
        """(clip, names of new nodes, changes of old ones) of another picture."""
        scene = self.client.scene
        made, changed = len(scene.made), len(scene.changes)
        clip = self.scene.draw(shown)
        return clip, scene.made[made:], scene.changes[changed:]

    @property
    def seen(self):
        return self.client.scene.seen()


@pytest.mark.parametrize("robot", ["anymal", "slider"])
@pytest.mark.parametrize("simulation", [False, True])
def test_the_same_picture_again_sends_nothing(robot, simulation):
    shown = picture(robot, OVERLAYS, simulation=simulation)
    drawn = Drawn(shown)
    assert drawn.clip is not None
    assert drawn.changes(shown) == (None, [], [])
    # Another value of the same parts, as a state that is rendered anew gives it.
    again = replace(shown, layers=frozenset(OVERLAYS), blocks=tuple(shown.blocks))
    assert drawn.changes(again) == (None, [], [])


def test_nothing_new_is_found_out_within_a_millisecond():
    shown = picture(layers=OVERLAYS, simulation=True)
    drawn = Drawn(shown)
    times = []
    for _ in range(50):
        again = replace(shown, layers=frozenset(OVERLAYS))
        began = time.perf_counter()
        drawn.scene.draw(again)
        times.append(time.perf_counter() - began)
    assert min(times) < 1e-3


def test_an_empty_picture_is_a_floor():
    drawn = Drawn()
    assert drawn.scene.draw(Picture()) is None
    assert {name.split("/")[1] for name in drawn.nodes} == {"lamps", "ground", "floor"}


def test_a_robot_without_a_plan_stands_still_and_is_looked_at():
    robot = load_robot("anymal")
    drawn = Drawn(Picture(robot=robot, layers=AT_FIRST))
    assert drawn.clip.end == 0
    assert all(name.startswith("/links") for name in names_in(drawn.clip))
    _, track = track_of(drawn.clip, "/links/base")
    assert track.position[0] == pytest.approx(robot.base_position)
    points = drawn.clip.camera_target.points
    low, high = points.min(axis=0), points.max(axis=0)
    assert low[2] == pytest.approx(0, abs=0.07)
    assert (high - low > 0.4).all()
    assert drawn.clip.camera_target.follow == "/links/base"


def test_the_points_that_are_looked_at_hold_all_of_the_motion():
    drawn = Drawn(picture(forward=0.4))
    points = drawn.clip.camera_target.points
    low, high = points.min(axis=0), points.max(axis=0)
    frames = planned(forward=0.4).frames
    places = frames.body_position.reshape(-1, 3)
    assert (low < places.min(axis=0)).all()
    # The apex may lie between two of the frames that are looked at.
    assert (high > places.max(axis=0) - 0.01).all()
    still = Drawn(Picture(robot=load_robot("anymal"))).clip.camera_target
    route = Jump(type="hops").along((Landing(forward=0.5), Landing(forward=0.5, height=0.2)))
    waits = Drawn(Picture(robot=load_robot("anymal"), target=route)).clip.camera_target
    assert np.ptp(waits.points, axis=0) - np.ptp(still.points, axis=0) == pytest.approx(
        [1.0, 0.0, 0.2], abs=0.02
    )
    assert high[0] - still.points[:, 0].max() == pytest.approx(0.4, abs=0.1)


def test_a_new_plan_makes_no_nodes():
    drawn = Drawn(picture(layers=OVERLAYS))
    _, made, changes = drawn.changes(picture(layers=OVERLAYS, forward=0.3))
    assert made == []
    # Marks and trails; all else moves with the clip.
    assert {name.split("/")[1] for name, _ in changes} <= {"target", "path"}


def test_overlays_are_made_when_they_are_switched_on_first():
    drawn = Drawn(picture(layers=()))
    always = {"lamps", "ground", "floor", "links", "below"}
    assert {name.split("/")[1] for name in drawn.nodes} == always
    for name in OVERLAYS:
        _, made, _ = drawn.changes(picture(layers={name}))
        assert made or name in {"ghost", "new-plans", "landing-region"}, name
        _, made, _ = drawn.changes(picture(layers=()))
        assert made == []
        _, made, _ = drawn.changes(picture(layers={name}))
        assert made == [], name


def test_what_is_switched_off_is_hidden_and_moves_no_more():
    drawn = Drawn(picture(layers=OVERLAYS))
    everything = names_in(drawn.clip)
    for name in OVERLAYS:
        clip, _, _ = drawn.changes(picture(layers=OVERLAYS.keys() - {name}))
        gone = everything - (names_in(clip) if clip else everything)
        assert not gone & drawn.seen, name
        if clip is not None:
            assert gone, name
        clip, _, _ = drawn.changes(picture(layers=OVERLAYS))
        assert gone <= drawn.seen
        assert clip is None or names_in(clip) == everything


def test_night_changes_light_and_floor_only():
    drawn = Drawn(picture())
    clip, made, changes = drawn.changes(replace(picture(), night=True))
    assert (clip, made) == (None, [])
    assert {name.split("/")[1] for name, _ in changes} == {"lamps", "ground", "floor"}
    assert max(drawn.nodes["/ground"].plane_color) < 90
    drawn.changes(picture())
    assert min(drawn.nodes["/ground"].plane_color) > 180


def test_only_a_graphics_processor_casts_shadows():
    link_visuals(load_robot("anymal"), coarse=True)  # until then there are stand-ins
    drawn = Drawn(picture())
    assert not drawn.nodes["/lamps/key"].cast_shadow
    assert drawn.nodes["/ground"].shadow_opacity == 0
    _, made, changes = drawn.changes(replace(picture(), fine=True))
    assert made == []
    assert drawn.nodes["/lamps/key"].cast_shadow
    assert drawn.nodes["/ground"].shadow_opacity > 0
    refined = {name for name, prop in changes if prop == "glb_data"}
    assert refined == {name for name in drawn.nodes if name.startswith("/links/")}


def test_a_simulation_has_the_plan_as_a_ghost():
    drawn = Drawn(picture())
    assert not any(name.startswith("/shade") for name in drawn.nodes)
    clip, _, _ = drawn.changes(picture(simulation=True))
    assert "/shade/base" in drawn.seen
    solid, shade = (track_of(clip, f"/{name}/base")[0] for name in ("links", "shade"))
    frames = planned().frames
    assert (shade[: len(frames.time)] == frames.time).all()
    assert solid[-1] == shade[-1] > frames.end
    assert clip.end == solid[-1]
    drawn.changes(picture())
    assert "/shade/base" not in drawn.seen


# ---- robots are sent once


def test_robots_that_are_switched_forth_and_back_are_sent_once():
    drawn = Drawn(picture("anymal", simulation=True), picture("slider", simulation=True))
    sent, nodes = drawn.client.scene.sent, len(drawn.nodes)
    for robot in ("anymal", "slider") * 5:
        clip, made, changes = drawn.changes(picture(robot, simulation=True))
        # Landing marks belong to a kind of foot.
        assert all(name.startswith("/target/") for name in made)
        assert not any(prop == "glb_data" for name, prop in changes if "/links" in name)
        bases = {name for name in drawn.seen if name.endswith(("/base", "/pelvis"))}
        assert {name.split("/")[2] for name in bases} == {"base" if robot == "anymal" else "pelvis"}
        assert clip.camera_target.follow in drawn.seen
    links = sum(len(glb) for _, _, glb in robot_nodes.meshes(load_robot("anymal")))
    assert drawn.client.scene.sent - sent < 0.1 * links
    assert len(drawn.nodes) == nodes


def test_only_so_many_hidden_robots_are_kept():
    shown = [replace(picture(), robot=replace(load_robot("anymal"))) for _ in range(9)]
    drawn = Drawn(*shown)
    bases = {name for name in drawn.nodes if name.endswith("/base")}
    assert len(bases) == robot_nodes.KEPT + 1
    # The oldest has gone; the newest are there.
    _, made, _ = drawn.changes(shown[-2])
    assert not any(name.endswith("/base") for name in made)
    _, made, _ = drawn.changes(shown[0])
    assert any(name.endswith("/base") for name in made)


def test_pins_that_come_and_go_are_sent_once():
    robot, frames = load_robot("anymal"), planned().frames
    ghosts = [Ghost(robot, frames, colour) for colour in colours.PINNED]
    drawn = Drawn(replace(picture(), ghosts=tuple(ghosts)))
    made_first = len(drawn.nodes)
    clip, made, _ = drawn.changes(replace(picture(), ghosts=tuple(ghosts[1:])))
    assert made == []
    assert "/pinned/1/base" not in names_in(clip) | drawn.seen
    assert {"/pinned/2/base", "/pinned/3/base"} <= names_in(clip) & drawn.seen
    other = Ghost(robot, planned(forward=0.4).frames, colours.PINNED[0])
    clip, made, _ = drawn.changes(replace(picture(), ghosts=(*ghosts[1:], other)))
    assert made == []
    assert len(drawn.nodes) == made_first
    assert track_of(clip, "/pinned/1/base")[1].position[-1, 0] == pytest.approx(
        other.frames.body_position[-1, 0, 0]
    )


def test_tracks_with_the_same_instants_are_one_strand():
    clip = Drawn(picture(layers=OVERLAYS, simulation=True)).clip
    assert len(clip.channels) == 3  # the plan's, the simulation's, and those of the ghost
    for strand in clip.channels:
        for track in strand.tracks:
            for values in (track.position, track.wxyz, track.scale):
                assert values is None or len(values) == len(strand.time)
                assert values is None or np.isfinite(values).all()


def test_the_ground_is_where_the_robot_lands_below():
    drawn = Drawn(picture(height=-0.15))
    assert drawn.nodes["/ground"].position[2] == -0.15
    assert drawn.nodes["/target/step0"].visible


def test_an_overlay_that_was_hidden_meanwhile_has_the_newest_motion():
    drawn = Drawn(picture(layers={"com"}), picture(layers=()), picture(layers=(), forward=0.4))
    clip, _, _ = drawn.changes(picture(layers={"com"}, forward=0.4))
    assert track_of(clip, "/com")[1].position is planned(forward=0.4).frames.com

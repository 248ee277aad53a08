"""What every overlay has in common; the geometry of each has a test of its own."""

from dataclasses import replace

import pytest

from app.picture.overlays import AT_FIRST, OVERLAYS
from app.picture.scene import Scene
from app.tab.rendering import legend_of
from llsrbm.robots import load_robot
from tests.app.picture.pictures import picture
from tests.app.picture.recorded import RecordedClient
from tests.llsrbm.synthetic_rollout import synthetic_rollout


def test_titles_are_different_and_hints_are_sentences():
    titles = [overlay.title for overlay in OVERLAYS.values()]
    assert len(set(titles)) == len(titles)
    # Fixed: scripts that use the page find its boxes by them.
    assert OVERLAYS["ellipsoids"].title == "Inertia ellipsoids"
    for name, overlay in OVERLAYS.items():
        assert overlay.name == name
        assert overlay.hint.endswith(".")
        assert "\n" not in overlay.hint


@pytest.mark.parametrize("name", OVERLAYS)
def test_no_node_is_called_as_its_box(name):
    client = RecordedClient()
    Scene(client).draw(picture("slider", {name}, simulation=True))
    # viser labels nodes in its own tree; a test that looks for a control would find them, too.
    taken = {OVERLAYS[name].title.lower(), "robot", "model", "pin/", "open", "play", "seed", "time"}
    assert not [node for node in client.scene.nodes for word in taken if word in node.lower()]


@pytest.mark.parametrize("name", OVERLAYS)
@pytest.mark.parametrize("robot", ["anymal", "slider"])
def test_an_overlay_has_few_nodes(name, robot):
    without, having = RecordedClient(), RecordedClient()
    for client, layers in ((without, ()), (having, {name})):
        Scene(client).draw(picture(robot, layers))
    bodies = load_robot(robot).model.njoints - 1
    assert len(having.scene.nodes) - len(without.scene.nodes) <= bodies + 1


def test_diagnostics_are_quiet_at_first():
    assert frozenset(OVERLAYS) > AT_FIRST
    of_pushes = {"pushes", "new-plans", "landing-region"}  # without any they draw nothing
    assert {"ellipsoids", "com", "forces", "trails", "ghost", "landing"} == AT_FIRST - of_pushes
    assert of_pushes < AT_FIRST


def test_the_legend_has_the_colour_of_every_overlay_that_is_drawn():
    shown = picture(layers=OVERLAYS, simulation=True)
    shown = replace(shown, rollout=synthetic_rollout(shown.planned.plan))
    colours = [colour for colour, _ in legend_of(shown)]
    for name in OVERLAYS:
        for colour, _ in OVERLAYS[name].legend(shown):
            assert colour in colours, name
    few = legend_of(replace(shown, layers=frozenset({"com", "trails"})))
    assert [words for _, words in few] == ["trails"]

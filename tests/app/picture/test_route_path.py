"""The line along a route, and its numbers."""

import numpy as np

from app.picture.overlays.landing_marks import LandingMarks
from app.picture.picture import Picture
from app.picture.route_path import RoutePath
from llsrbm.request.jump import Jump
from llsrbm.request.route import Landing
from tests.app.picture.recorded import RecordedScene

PLAIN = Jump(forward=0.3)
UP_AND_ON = PLAIN.along((Landing(forward=0.3, height=0.1), Landing(lateral=0.2)))
LAYERS = frozenset({LandingMarks.name})


def test_it_leads_from_landing_to_landing_and_each_has_its_number():
    scene = RecordedScene()
    path = RoutePath(scene)
    path.draw(Picture(target=PLAIN, layers=LAYERS))
    assert not scene.made
    path.draw(Picture(target=UP_AND_ON, layers=LAYERS))
    line = scene.nodes["/route/line"].points
    np.testing.assert_allclose(line[:, :, :2], [[[0, 0], [0.3, 0]], [[0.3, 0], [0.3, 0.2]]])
    assert np.ptp(line[0, :, 2]) > 0.09
    for number, at in (("1", (0.3, 0.0)), ("2", (0.3, 0.2))):
        label = scene.nodes[f"/route/{number}"]
        assert label.values == (number,)
        np.testing.assert_allclose(label.position[:2], at)
    assert scene.seen() == {"/route/line", "/route/1", "/route/2"}


def test_it_is_drawn_with_the_landing_marks_and_of_routes_alone():
    scene = RecordedScene()
    path = RoutePath(scene)
    path.draw(Picture(target=UP_AND_ON, layers=LAYERS))
    for picture in (Picture(target=UP_AND_ON), Picture(target=PLAIN, layers=LAYERS), Picture()):
        path.draw(picture)
        assert not scene.seen()

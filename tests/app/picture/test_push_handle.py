import pytest

from app.picture.push_handle import PushHandle, PushShown
from tests.app.picture.recorded import RecordedClient

SHOWN = PushShown(0.5, (0.1, 0.2, 0.6), (0.0, 10.0, 2.0), 0.05)
BALL, ARROW, SIZE = "/push/tip", "/push/arrow", "/push/size"


class Target:
    def __init__(self):
        client = RecordedClient()
        self.nodes = client.scene.nodes
        self.handle = PushHandle(client)

    @property
    def seen(self):
        return {name for name, node in self.nodes.items() if node.visible}


@pytest.fixture
def target():
    made = Target()
    made.handle.draw(SHOWN)
    return made


def test_the_ball_is_at_the_tip_and_the_size_beside_it(target):
    assert target.nodes[BALL].position == pytest.approx((0.1, 0.7, 0.7))
    assert target.nodes[SIZE].text == "10.2 N s"
    begin, end = target.nodes[ARROW].points[0]
    assert begin == pytest.approx(SHOWN.origin)
    assert end == pytest.approx(SHOWN.tip)
    assert target.seen == {BALL, ARROW, SIZE}


def test_without_a_size_there_is_a_ball_alone(target):
    target.handle.draw(PushShown(0.5, (0.0, 0.0, 0.5), (0.0, 0.0, 0.0), 0.05))
    assert target.seen == {BALL, SIZE}
    assert target.nodes[SIZE].text == "drag to push"


def test_nothing_is_shown_of_no_push(target):
    target.handle.draw(None)
    assert target.seen == set()

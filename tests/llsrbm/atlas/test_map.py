import numpy as np
import pytest

from llsrbm.atlas.colours import COLOURS, FREE
from llsrbm.atlas.jumps import axis_of
from llsrbm.atlas.map import ALL, NEAREST, map_of
from llsrbm.atlas.table import read_atlas
from tests.llsrbm.atlas.tables import FORWARDS, HEIGHTS, TWISTS, drawn, grid, row, stopped, write

TWIST, FORWARD, LATERAL = map(axis_of, ("twist", "forward", "lateral"))


@pytest.fixture(scope="module")
def jumps(tmp_path_factory):
    return read_atlas(write(tmp_path_factory.mktemp("grid") / "t.parquet", grid())).groups[0]


@pytest.fixture(scope="module")
def cloud(tmp_path_factory):
    return read_atlas(write(tmp_path_factory.mktemp("cloud") / "t.parquet", drawn())).groups[0]


def made(jumps, colour="plannable", axes=(TWIST, FORWARD), **how):
    return map_of(jumps, *axes, COLOURS[colour], **how)


@pytest.mark.parametrize(("height", "border"), [(0.0, 112.5), (0.2, 67.5), (0.16, 67.5)])
def test_a_grids_slice_is_the_one_nearest_to_the_design(jumps, height, border):
    # Half way between the last twist that can be done and the first that cannot.
    found = made(jumps, design={"height": height})
    np.testing.assert_allclose(found.x.centres, TWISTS, atol=1e-8)
    np.testing.assert_allclose(found.y.centres, FORWARDS)
    slice_ = min(HEIGHTS, key=lambda each: abs(each - height))
    assert {jumps.requested["height"][k] for k in found.jump.flat} == {slice_}
    assert len(found.border) == 2
    for line in found.border:
        np.testing.assert_allclose(np.abs(np.degrees(line[:, 0])), border, atol=1e-4)
        # From one edge of the map to the other.
        assert {*np.round(line[[0, -1], 1], 6)} == {-0.45, 0.75}


def test_all_slices_together_are_shares(jumps):
    found = made(jumps, projection=ALL)
    assert found.count.tolist() == [[2] * 9] * 4
    assert found.value[0].tolist() == [0, 0, 0.5, 1, 1, 1, 0.5, 0, 0]
    worse = made(jumps, "stopped-by", projection=ALL)
    assert [jumps.stops[int(k)] for k in worse.value[0, [0, 4]]] == ["joint_torque", ""]


def test_a_cell_opens_its_own_jump(jumps):
    found = made(jumps, projection=ALL, design={"height": 0.2})
    for (up, across), place in np.ndenumerate(found.jump):
        assert jumps.requested["twist"][place] == pytest.approx(TWISTS[across])
        assert jumps.requested["forward"][place] == pytest.approx(FORWARDS[up])
        assert jumps.requested["height"][place] == 0.2


def test_a_drawn_sweeps_border_is_where_it_should_be(cloud):
    found = made(cloud, axes=(FORWARD, LATERAL), projection=ALL)
    assert not found.x.listed
    assert found.count.sum() == 400
    line = max(found.border, key=len)
    radius = np.hypot(*line.T)
    assert np.abs(radius - 0.25).max() < 0.4 * np.ptp(found.x.edges) / len(found.x.centres) * 2
    assert abs(radius.mean() - 0.25) < 0.02


def test_strict_is_of_the_plannable_alone(tmp_path):
    rows = [
        row(0, strict=False),
        row(1, forward=0.1, **stopped()),
        row(2, lateral=0.1),
        row(3, lateral=0.1, forward=0.1, **stopped("reach")),
    ]
    (jumps,) = read_atlas(write(tmp_path / "t.parquet", rows)).groups
    found = made(jumps, "strict", axes=(FORWARD, LATERAL), projection=NEAREST)
    np.testing.assert_array_equal(found.value, [[0, np.nan], [1, np.nan]])
    stops = made(jumps, "stopped-by", axes=(FORWARD, LATERAL))
    assert stops.colour_of(stops.value[0, 0]) == FREE
    assert len({stops.colour_of(value) for value in stops.value.flat}) == 3


def test_cells_without_a_jump_are_empty_and_make_no_border(tmp_path):
    places = [(0, 0), (0, 1), (1, 0), (2, 2), (1, 2), (2, 1), (0, 2), (2, 0)]  # without (1, 1)
    rows = [row(k, forward=x / 10, lateral=y / 10) for k, (x, y) in enumerate(places)]
    (jumps,) = read_atlas(write(tmp_path / "t.parquet", rows)).groups
    found = made(jumps, axes=(FORWARD, LATERAL))
    assert found.jump[1, 1] == -1
    assert np.isnan(found.value[1, 1])
    assert found.border == ()

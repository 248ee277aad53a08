import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from llsrbm.atlas.jumps import FALLS, NOTHING
from llsrbm.atlas.learned import learned_atlas
from llsrbm.atlas.table import read_atlas
from llsrbm.errors import InputError
from llsrbm.planning.whole_body.learned_file import outcomes_of
from llsrbm.request.jump import COMPONENTS
from llsrbm.robots import load_robot
from tests.llsrbm.atlas.tables import can, grid, row, stopped, write


def test_jumps_of_a_robot_with_what_was_asked_and_what_varies(tmp_path):
    atlas = read_atlas(write(tmp_path / "jumps.parquet", grid(("anymal", "go2"))))
    assert atlas.title == tmp_path.name
    assert atlas.robots == ("anymal", "go2")
    jumps = atlas.jumps_of("go2")
    assert len(jumps) == 72
    assert [axis.name for axis in jumps.axes] == ["twist", "forward", "height"]
    asked = zip(jumps.requested["twist"], jumps.requested["height"], strict=True)
    assert jumps.planned.tolist() == [can(*each) for each in asked]
    assert atlas.jumps_of("slider") is None


def test_a_jump_is_found_by_its_number_with_its_request(tmp_path):
    values = {"twist": 1.0, "height": 0.1, "hops": 2, "limit_friction": 0.3, "drive_torque": 1.2}
    rows = [row(3), row(7, **values)]
    atlas = read_atlas(write(tmp_path / "t.parquet", rows, limits=("friction",)))
    jumps, place = atlas.find(7)
    jump, limits, drives = jumps.request(place)
    assert (jump.robot, jump.twist, jump.height, jump.hops) == ("anymal", 1.0, 0.1, 2)
    assert limits == {"friction": 0.3}
    assert drives == {"drive_torque": 1.2}
    assert [atlas.find(number) for number in (-1, 0, 5, 8)] == [None] * 4


@pytest.mark.parametrize("arms", ["free", "held"])
def test_a_jump_has_its_sweeps_arms(tmp_path, arms):
    table = write(tmp_path / "t.parquet", [row(3, robot="g1", arms=arms)])
    jumps, place = read_atlas(table).find(3)
    assert jumps.request(place)[0].arms == arms


def test_seeds_come_together_whatever_their_order(tmp_path):
    falls = {"landed": False, "strict": False}
    rows = [
        row(1, 0, **falls),
        row(0, 1, strict=False),
        row(0, 0),
        row(1, 1, **falls),
        row(2, 0, **stopped()),
        row(2, 1, **stopped()),
        row(1, 2),
    ]
    (jumps,) = read_atlas(write(tmp_path / "t.parquet", rows)).groups
    assert jumps.planned.tolist() == [1, 1, 0]
    np.testing.assert_allclose(jumps.strict, [0.5, 1 / 3, np.nan])
    np.testing.assert_allclose(jumps.landed, [1, 1 / 3, np.nan])
    assert [jumps.stops[k] for k in jumps.stop] == ["", FALLS, "joint_torque"]


def test_what_is_no_sweeps_table_is_refused_in_one_line(tmp_path):
    (tmp_path / "text.parquet").write_text("nothing of the kind")
    pq.write_table(pa.table({"jump": [1]}), tmp_path / "other.parquet")
    write(tmp_path / "odd.parquet", [row(0, status="maybe")])
    write(tmp_path / "empty.parquet", [])
    for name, why in (
        ("none", "no jumps.parquet there"),
        ("text.parquet", "cannot be read"),
        ("other.parquet", 'no column "robot"'),
        ("odd.parquet", "status 'maybe'"),
        ("empty.parquet", "has no jumps"),
    ):
        with pytest.raises(InputError, match=why) as refused:
            read_atlas(tmp_path / name)
        assert "\n" not in str(refused.value)


def test_the_built_in_atlas_has_the_jumps_of_the_tables():
    atlas, outcomes = learned_atlas(), outcomes_of(load_robot("go2"))
    jumps = atlas.jumps_of("go2")
    assert len(jumps) == len(outcomes.requests) + len(outcomes.refused)
    assert jumps.planned.sum() == len(outcomes.requests)
    np.testing.assert_array_equal(np.isfinite(jumps.flight), jumps.planned == 1)
    group, place = atlas.find(int(jumps.numbers[-1]))
    assert group is jumps
    jump, limits, drives = group.request(place)
    assert [getattr(jump, name) for name in COMPONENTS] == outcomes.refused[-1].tolist()
    assert (jump.robot, limits, drives) == ("go2", {}, {})
    assert jumps.stops[jumps.stop[-1]] == outcomes.stopped_by[-1]
    assert {jumps.stops[k] for k in jumps.stop[: len(outcomes.requests)]} == {NOTHING}

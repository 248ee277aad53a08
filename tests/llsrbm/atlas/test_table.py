import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from llsrbm.atlas.jumps import FALLS
from llsrbm.atlas.table import read_atlas, shipped_atlas, write_small
from llsrbm.errors import InputError
from tests.llsrbm.atlas.tables import can, grid, row, stopped, write
from tests.llsrbm.processes import printed


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


@pytest.mark.parametrize("name", ["t.parquet", "small.npz", "small.parquet"])
@pytest.mark.parametrize("arms", ["free", "held"])
def test_a_jump_has_its_sweeps_arms(tmp_path, name, arms):
    table = write(tmp_path / "t.parquet", [row(3, robot="g1", arms=arms)])
    if name != table.name:
        write_small(table, tmp_path / name)
    jumps, place = read_atlas(tmp_path / name).find(3)
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


@pytest.mark.parametrize("name", ["small.npz", "small.parquet"])
def test_the_small_file_is_the_same_atlas(tmp_path, name):
    table = write(tmp_path / "jumps.parquet", [*grid(), row(72, limit_friction=0.2)], ("friction",))
    write_small(tmp_path, tmp_path / name)
    assert (tmp_path / name).stat().st_size < table.stat().st_size / 2
    (one,), (other,) = (read_atlas(p).groups for p in (table, tmp_path / name))
    assert read_atlas(tmp_path / name).title == tmp_path.name
    np.testing.assert_array_equal(one.planned, other.planned)
    np.testing.assert_array_equal(
        one.requested["limit_friction"], other.requested["limit_friction"]
    )
    np.testing.assert_allclose(one.torque_share, other.torque_share, rtol=1e-6)
    assert one.stops == other.stops


def test_the_small_file_is_read_without_pyarrow(tmp_path):
    write_small(write(tmp_path / "t.parquet", grid()), tmp_path / "small.npz")
    script = """
import sys
from pathlib import Path
sys.modules["pyarrow"] = None
from llsrbm.atlas.table import read_atlas
read_atlas(Path(sys.argv[1]))
"""
    printed(script, tmp_path / "small.npz")


def test_what_is_no_sweeps_table_is_refused_in_one_line(tmp_path):
    (tmp_path / "text.parquet").write_text("nothing of the kind")
    pq.write_table(pa.table({"jump": [1]}), tmp_path / "other.parquet")
    write(tmp_path / "odd.parquet", [row(0, status="maybe")])
    write(tmp_path / "empty.parquet", [])
    (tmp_path / "text.npz").write_text("nothing of the kind")
    np.savez(tmp_path / "other.npz", title="x", jump=[1])
    for name, why in (
        ("none", "no jumps.parquet there"),
        ("text.parquet", "cannot be read"),
        ("other.parquet", 'no column "robot"'),
        ("text.npz", "cannot be read"),
        ("other.npz", 'no column "robot"'),
        ("odd.parquet", "status 'maybe'"),
        ("empty.parquet", "has no jumps"),
    ):
        with pytest.raises(InputError, match=why) as refused:
            read_atlas(tmp_path / name)
        assert "\n" not in str(refused.value)


def test_where_none_ships_it_says_how_one_is_made():
    with pytest.raises(InputError, match="no map of jumps ships at present; `llsrbm sweep atlas"):
        shipped_atlas()

"""Tables and trajectories are opened by others, in processes that do not know this project."""

import subprocess
import sys

import pytest

from llsrbm.sweep.points import Points
from llsrbm.sweep.shard import origin, run_shard
from llsrbm.sweep.table import Folder
from llsrbm.sweep.trajectories import STORE, merge
from tests.llsrbm.sweep.specs import spec, without_planning
from tests.llsrbm.sweep.test_trajectories import part

PANDAS = """
import pandas
table = pandas.read_parquet(path)
assert len(table) == 40
assert list(table["index"]) == list(range(40))
assert (table.groupby("robot").size() == 20).all()
assert table.loc[table.status == "planned", "cost"].notna().all()
"""
DUCKDB = """
import duckdb
found = duckdb.sql(
    f"select robot, status, count(*) n, max(twist) twist from '{path}' group by all order by all"
).fetchall()
assert [row[:3] for row in found] == [
    ("anymal", "not planned", 4), ("anymal", "planned", 16),
    ("go2", "not planned", 4), ("go2", "planned", 16),
]
assert abs(found[0][3] - 1.5707963) < 1e-6
"""
XARRAY = """
import xarray
motions = xarray.open_zarr(store, group="slider/srbm/5")
assert motions.com.dims == ("jump", "knot", "xyz")
assert float(motions.com.sel(jump=1).mean()) == 1.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("sweep")
    with pytest.MonkeyPatch.context() as patch:
        without_planning(patch)
        points = Points(spec())
        with Folder(path, points, origin(points.spec)) as kept:
            kept.write(run_shard(points.spec.as_json(), range(points.count)))
            kept.finish()
    merge([part(path, [0, 1])], path / STORE)
    return path


@pytest.mark.parametrize("program", [PANDAS, DUCKDB, XARRAY], ids=["pandas", "duckdb", "xarray"])
def test_others_open_it(folder, program):
    names = f"path = {str(folder / 'jumps.parquet')!r}\nstore = {str(folder / STORE)!r}\n"
    alone = "\nimport sys\nassert not any(n.startswith('llsrbm') for n in sys.modules)\n"
    done = subprocess.run(
        [sys.executable, "-c", names + program + alone],
        capture_output=True,
        text=True,
        cwd=folder,
        check=False,
    )
    assert done.returncode == 0, done.stderr

"""The folder of parts is opened by others, in processes that do not know this project."""

import pytest

from tests.llsrbm.processes import printed
from tests.llsrbm.sweep.specs import filled, without_planning

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
    f"select robot, status, count(*) n, max(twist) twist from '{path}/*.parquet' group by all "
    "order by all"
).fetchall()
assert [row[:3] for row in found] == [
    ("anymal", "not planned", 4), ("anymal", "planned", 16),
    ("go2", "not planned", 4), ("go2", "planned", 16),
]
assert abs(found[0][3] - 1.5707963) < 1e-6
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("sweep")
    with pytest.MonkeyPatch.context() as patch:
        without_planning(patch)
        filled(path, range(13))
        filled(path, range(13, 40))
    return path


@pytest.mark.parametrize("program", [PANDAS, DUCKDB], ids=["pandas", "duckdb"])
def test_others_open_it(folder, program):
    names = f"path = {str(folder / 'jumps.parquet')!r}\n"
    alone = "\nimport sys\nassert not any(n.startswith('llsrbm') for n in sys.modules)\n"
    printed(names + program + alone, cwd=folder)

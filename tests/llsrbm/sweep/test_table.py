import errno
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from llsrbm.errors import Error, InputError
from llsrbm.sweep import shard
from llsrbm.sweep.points import Points
from llsrbm.sweep.shard import origin, run_shard
from llsrbm.sweep.table import Folder
from tests.llsrbm.sweep.specs import GRID, rows_of, spec, without_planning

ORIGIN = {"llsrbm": "1", "anymal": "a", "go2": "b"}


@pytest.fixture(autouse=True)
def _planned_at_once(monkeypatch):
    without_planning(monkeypatch)


def folder(path, text=GRID, of=ORIGIN):
    return Folder(path, Points(spec(text)), of)


def made(jumps, text=GRID):
    return run_shard(spec(text).as_json(), jumps)


@pytest.fixture
def whole(tmp_path):
    with folder(tmp_path / "whole") as kept:
        kept.write(made(range(40)))
        kept.finish()
    return rows_of(tmp_path / "whole" / "jumps.parquet")


def test_parts_in_any_order_and_shape_make_the_same_table(tmp_path, whole):
    with folder(tmp_path / "out") as kept:
        for jumps in ([30, 39], [*range(10, 20)], [0], [*range(31, 39)], [*range(20, 30)]):
            kept.write(made(jumps))
        kept.write(made([*range(1, 10)]))
        kept.finish()
    assert rows_of(tmp_path / "out" / "jumps.parquet").equals(whole)
    assert not (tmp_path / "out" / "parts").exists()


def test_merging_holds_little_and_misses_nothing(tmp_path, monkeypatch, whole):
    monkeypatch.setattr("llsrbm.sweep.table._GROUP", 4)
    with folder(tmp_path / "out") as kept:
        for first in range(0, 40, 4):  # each part overlaps the next
            odd = [n for n in (first, first + 1, first + 2, first + 5) if n < 40]
            kept.write(made([n for n in odd if not kept.done[n]]))
        left = [*kept.missing()]
        if left:
            kept.write(made(left))
        kept.finish()
    assert rows_of(tmp_path / "out" / "jumps.parquet").equals(whole)
    assert pq.ParquetFile(tmp_path / "out" / "jumps.parquet").num_row_groups > 1


def test_it_goes_on_with_what_is_missing_and_takes_nothing_twice(tmp_path, whole):
    with folder(tmp_path / "out") as kept:
        kept.write(made([0, 1, 5]))
    with folder(tmp_path / "out") as kept:
        left = [*kept.missing()]
        assert left == [n for n in range(40) if n not in (0, 1, 5)]
        with pytest.raises(RuntimeError, match="twice"):
            kept.write(made([5]))
        kept.write(made(left))
        kept.finish()
    assert rows_of(tmp_path / "out" / "jumps.parquet").equals(whole)
    with folder(tmp_path / "out") as kept:
        assert kept.done.all()
        kept.finish()


def test_what_was_half_written_counts_for_nothing(tmp_path):
    with folder(tmp_path) as kept:
        kept.write(made([0, 1]))
        kept.write(made([2, 3]))
    parts = tmp_path / "parts"
    first, second = sorted(parts.glob("*.parquet"))
    second.write_bytes(second.read_bytes()[:-20])
    (parts / "000000000009.parquet.tmp").write_bytes(b"half")
    (parts / "000000000009.npz").write_bytes(b"trajectories without their rows")
    (tmp_path / "jumps.parquet.tmp").write_bytes(b"half")
    with folder(tmp_path) as kept:
        assert kept.damaged == [second.name]
        assert [*kept.missing()] == [*range(2, 40)]
    assert [path.name for path in parts.iterdir()] == [first.name]


def test_a_table_whose_parts_are_still_there_is_done(tmp_path, whole):
    with folder(tmp_path / "out") as kept:
        kept.write(made(range(40)))
        part = next((tmp_path / "out" / "parts").glob("*.parquet"))
        content = part.read_bytes()
        kept.finish()
    part.parent.mkdir()
    part.write_bytes(content)  # as if it had been killed before it removed them
    with folder(tmp_path / "out") as kept:
        assert kept.done.all()
        kept.finish()
    assert not part.exists()
    assert rows_of(tmp_path / "out" / "jumps.parquet").equals(whole)


def test_no_room_is_one_line_and_nothing_half_written(tmp_path, monkeypatch):
    def full(path, content):
        with path.open("wb") as file:
            file.write(content[:10])
        raise OSError(errno.ENOSPC, "No space left on device")

    with folder(tmp_path) as kept:
        kept.write(made([0]))
        monkeypatch.setattr(Path, "write_bytes", full)
        with pytest.raises(Error, match=r"No space left on device.*run the same command again"):
            kept.write(made([1]))
        assert [*kept.missing()] == [*range(1, 40)]
    monkeypatch.undo()
    assert [path.name for path in (tmp_path / "parts").iterdir()] == ["000000000000.parquet"]


@pytest.mark.parametrize(
    ("text", "of", "said"),
    [
        (GRID.replace("0.2", "0.3"), ORIGIN, 'is of another spec, "a grid"'),
        (GRID, ORIGIN | {"llsrbm": "2"}, r"the version of llsrbm was another one .*\(1, now 2\)"),
        (GRID, ORIGIN | {"go2": "c"}, "the robot go2 was another one"),
    ],
)
def test_another_sweeps_folder_is_refused(tmp_path, text, of, said):
    with folder(tmp_path):
        pass
    with pytest.raises(InputError, match=said):
        folder(tmp_path, text, of)


def test_a_folder_with_other_things_is_refused(tmp_path):
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(InputError, match=r"holds thesis.tex"):
        folder(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="is a file"):
        folder(tmp_path / "file")
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "sweep.json").write_text("{")
    with pytest.raises(InputError, match="is damaged"):
        folder(tmp_path / "damaged")


def test_two_processes_do_not_work_in_one_folder(tmp_path):
    with folder(tmp_path), pytest.raises(InputError, match="another process works in it"):
        folder(tmp_path)
    with folder(tmp_path):
        pass


def test_the_origin_is_of_every_robot():
    of = origin(spec())
    assert of.keys() == {"llsrbm", "anymal", "go2"}
    assert of["anymal"] == shard.robot_hash("anymal")

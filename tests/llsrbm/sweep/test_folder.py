import errno

import pyarrow.parquet as pq
import pytest

from llsrbm.errors import Error, InputError
from llsrbm.sweep import folder as module
from tests.llsrbm.sweep.specs import GRID, filled, opened, rows_of, without_planning

ORIGIN = {"llsrbm": "1", "anymal": "a", "go2": "b"}


@pytest.fixture(autouse=True)
def _planned_at_once(monkeypatch):
    without_planning(monkeypatch)


@pytest.fixture
def whole(tmp_path):
    filled(tmp_path / "whole", range(40))
    found = rows_of(tmp_path / "whole")
    assert found["index"].to_pylist() == [*range(40)]
    return found


def test_parts_are_one_table_in_the_order_of_the_spec(tmp_path, whole):
    for jumps in ([*range(10)], [*range(30, 40)], [*range(10, 17), *range(20, 30)], range(17, 20)):
        filled(tmp_path / "out", jumps)
    with opened(tmp_path / "out") as kept:
        assert kept.done.all()
    assert len([*kept.table.iterdir()]) == 5
    assert rows_of(tmp_path / "out").equals(whole)


def test_rows_are_on_the_disk_after_a_while(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "_MOST_ROWS", 3)
    with opened(tmp_path) as kept:
        for jump in range(7):
            kept.append(jump, [{"index": jump, "jump": jump}])
        assert [*kept.missing()] == [*range(6, 40)]
    assert pq.read_table(tmp_path / "jumps.parquet")["jump"].to_pylist() == [*range(7)]


def test_half_written_and_damaged_parts_are_computed_again(tmp_path, whole):
    for jumps in ([0, 1], [2, 3], range(4, 40)):
        filled(tmp_path / "out", jumps)
    table = tmp_path / "out" / "jumps.parquet"
    second = table / "000000000002.parquet"
    second.write_bytes(second.read_bytes()[:-20])
    (table / ".unfinished").write_bytes(b"half")
    with opened(tmp_path / "out") as kept:
        assert kept.damaged == [second.name]
        assert [*kept.missing()] == [2, 3]
    assert not (table / ".unfinished").exists()
    filled(tmp_path / "out", [2, 3])
    assert rows_of(tmp_path / "out").equals(whole)


def test_no_room_is_one_line_and_nothing_half_written(tmp_path, monkeypatch):
    filled(tmp_path, [0])

    def full(table, path, **_):
        path.write_bytes(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(pq, "write_table", full)
    with pytest.raises(Error, match=r"No space left on device.*run the same command again"):
        filled(tmp_path, [1])
    assert [path.name for path in (tmp_path / "jumps.parquet").iterdir()] == [
        "000000000000.parquet"
    ]


@pytest.mark.parametrize(
    ("text", "of", "message"),
    [
        (GRID.replace("0.2", "0.3"), ORIGIN, 'is of another spec, "a grid"'),
        (GRID, ORIGIN | {"llsrbm": "2"}, r"the sweep began with llsrbm 1, here is 2; expected"),
        (GRID, ORIGIN | {"go2": "c"}, "the sweep began with robot go2 b, here is c"),
    ],
)
def test_another_sweeps_folder_is_refused(tmp_path, text, of, message):
    with opened(tmp_path, of=ORIGIN):
        pass
    with pytest.raises(InputError, match=message):
        opened(tmp_path, text, of)


def test_a_folder_with_other_things_is_refused(tmp_path):
    (tmp_path / "thesis.tex").touch()
    with pytest.raises(InputError, match=r"holds thesis.tex"):
        opened(tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="is a file"):
        opened(tmp_path / "file")
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "sweep.json").write_text("{")
    with pytest.raises(InputError, match="is damaged"):
        opened(tmp_path / "damaged")


def test_two_processes_do_not_work_in_one_folder(tmp_path):
    with opened(tmp_path), pytest.raises(InputError, match="another process works in it"):
        opened(tmp_path)
    with opened(tmp_path):
        pass

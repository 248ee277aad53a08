from dataclasses import fields

import pytest

from llsrbm.motion.outcome import Outcome
from llsrbm.robots import load_robot
from llsrbm.sweep import rows
from tests.llsrbm.sweep.specs import spec


def test_every_figure_of_an_outcome_has_its_column_but_the_feets_own():
    names = {column.name for column in rows.COLUMNS}
    left_out = {field.name for field in fields(Outcome)} - names
    # `landed` and `fall` stand for the first two.
    assert left_out == {"reason", "foot_touchdown_s"}


def test_names_are_there_once_and_units_beside_them():
    names = [column.name for column in rows.COLUMNS]
    assert len(set(names)) == len(names)
    assert {*rows.TIMES, *rows.DIAGNOSED} < {*names}
    schema = rows.schema(spec())
    assert schema.names == [*names, "limit_friction"]
    assert schema.field("twist").metadata == {
        b"unit": b"rad",
        b"meaning": b"turn about the vertical, positive to the left",
    }


def test_what_a_row_does_not_say_is_null_and_what_there_is_not_is_refused():
    table = rows.table_of([{"index": 3, "violations": {"edge": 0.1}}], rows.schema(spec()))
    assert table["violations"].to_pylist() == [[("edge", 0.1)]]
    assert table["status"].to_pylist() == [None]
    with pytest.raises(KeyError, match="colour"):
        rows.table_of([{"colour": 1}], rows.schema(spec()))


def test_the_hash_is_of_the_robots_files_as_they_are_now(tmp_path):
    own = load_robot("slider").path
    path = tmp_path / "slider.toml"
    path.write_text(own.read_text().replace('file = "../', f'file = "{own.parents[1]}/'))
    before = rows.robot_hash(str(path))
    assert rows.robot_hash(str(path)) == before
    path.write_text(path.read_text() + "\n# heavier\n")
    assert rows.robot_hash(str(path)) != before

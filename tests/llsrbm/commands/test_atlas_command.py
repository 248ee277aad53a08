import json
import math

import pytest
from PIL import Image

from llsrbm.cli import main
from llsrbm.robots import load_robot
from tests.llsrbm.atlas.classifiers import BORDER, learned_of
from tests.llsrbm.atlas.tables import grid, row, write


@pytest.fixture
def table(tmp_path):
    return write(tmp_path / "jumps.parquet", grid(("anymal", "go2")))


def test_shares_and_borders_as_json(table, capfd):
    assert main(["atlas", str(table.parent), "--at", "height=0", "--json"]) == 0
    first, second = json.loads(capfd.readouterr().out)["maps"]
    assert (first["robot"], second["robot"]) == ("anymal", "go2")
    assert first["axes"] == ["twist", "forward", "height"]
    assert first["plannable_share"] == pytest.approx(8 / 18)
    assert first["strict_share"] == 1
    assert len(first["border"]) == 2


@pytest.mark.parametrize("colour", ["plannable", "stopped-by"])
def test_a_picture_of_every_robot(table, tmp_path, colour):
    pytest.importorskip("matplotlib")
    target = tmp_path / "map.png"
    assert main(["atlas", str(table), "--out", str(target), "--colour", colour]) == 0
    with Image.open(target) as picture:
        assert picture.width > 1.5 * picture.height
    one = tmp_path / "one.png"
    main(["atlas", str(table), "--robot", "go2", "--out", str(one)])
    with Image.open(one) as picture:
        assert picture.width < 1.5 * picture.height


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--colour", "red"], 'no "red"'),
        (["--x", "lateral"], 'no axis "lateral"'),
        (["--y", "twist"], "two different axes"),
        (["--robot", "slider"], 'no jumps of "slider"'),
        (["--at", "height=high"], "AXIS=VALUE"),
        (["--out", "map.bmp"], ".png, .svg, .pdf"),
    ],
)
def test_what_cannot_be_is_one_line(table, refused, arguments, why):
    assert why in refused("atlas", str(table), *arguments)


def test_a_sweep_of_one_axis_has_no_map(tmp_path, refused):
    write(tmp_path / "jumps.parquet", [row(0), row(1, twist=1.0)])
    assert "expected two axes" in refused("atlas", str(tmp_path))


def test_without_a_sweep_it_is_of_the_tables_of_solved_jumps(capfd):
    assert main(["atlas", "--robot", "go2", "--json"]) == 0
    (found,) = json.loads(capfd.readouterr().out)["maps"]
    assert found["axes"] == ["twist", "forward", "lateral", "height"]
    assert found["jumps"] >= 200
    assert 0.4 < found["plannable_share"] < 0.9
    assert found["strict_share"] is None


def test_of_robots_without_a_table_nothing_is_known(capfd):
    with learned_of():
        assert main(["atlas", "--intervals", "--robot", "go2"]) == 0
    assert "nothing is known of this robot" in capfd.readouterr().out


def test_the_intervals_that_can_be_planned(capfd):
    with learned_of(load_robot("go2")):
        assert (
            main(["atlas", "--intervals", "--robot", "go2", "--at", "forward=0.2", "--json"]) == 0
        )
        (found,) = json.loads(capfd.readouterr().out)["robots"].values()
        assert main(["atlas", "--intervals", "--robot", "go2", "--at", "forward=0.2"]) == 0
    assert set(found["intervals"]) == {"twist", "forward", "lateral", "height"}
    assert found["unknown"] == ""
    largest = BORDER * math.pi
    (ends,) = found["intervals"]["twist"]
    assert ends == pytest.approx((-largest, largest), rel=0.03)
    assert "go2 twist" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("at", "why"),
    [("speed=1", '"speed"'), ("limit_grip=1", "unknown limit"), ("twist=900", "out of range")],
)
def test_intervals_of_what_cannot_be_are_one_line(refused, at, why):
    assert why in refused("atlas", "--intervals", "--at", at)

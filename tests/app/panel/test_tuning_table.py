import re
from html import unescape

import pytest

from app.panel.tuning import entries_of, tuning_table
from llsrbm.planning.problem.costs import COSTS, default_weights
from llsrbm.planning.problem.placement import limits_of
from llsrbm.request import jump_types
from llsrbm.robots import load_robot

ROW = re.compile(r"<tr data-group.*?</tr>")


def rows(robot):
    return [unescape(row) for row in ROW.findall(tuning_table(entries_of(robot, "together")))]


@pytest.mark.parametrize("name", ["anymal", "slider"])
def test_every_weight_and_limit_has_a_row_with_unit_default_and_effect(name):
    robot = load_robot(name)
    weights = default_weights() | dict(robot.file.planning)
    wanted = [
        ("weights", c.name, weights[c.name], c.unit, c.effect) for c in COSTS if c.concerns(robot)
    ]
    wanted += [
        ("limits", limit.name, own, limit.unit, limit.effect)
        for limit, own in limits_of(robot).values()
    ]
    found = rows(robot)
    assert len(found) == len(wanted)
    for row, (group, key, own, unit, effect) in zip(found, wanted, strict=True):
        assert f'data-group="{group}" data-name="{key}" data-default="{own:g}"' in row
        assert f'title="Increasing it: {effect}"' in row
        assert f'<td class="number">{own:g}</td>' in row
        title = key.replace("_", " ")
        label = title if unit == "1" else f"{title} [{unit}]"
        assert f'aria-label="{label}"' in row
        assert f'aria-label="Reset {title}"' in row


def test_units_are_written_with_squares():
    units = {re.findall(r"<td>(.*?)</td>", row)[0] for row in rows(load_robot("anymal"))}
    assert {"1/(m/s)²", "1/(m²/s)²", "m", ""} <= units
    assert not any("^" in unit or re.search(r"m2", unit) for unit in units)


def test_a_types_own_limits_are_the_defaults():
    robot = load_robot("go2")
    plain, flip = (
        {entry.name: entry for entry in entries_of(robot, name)} for name in ("together", "flip")
    )
    for name, value in jump_types.load_type("flip").limits.items():
        assert flip[name].default == value != plain[name].default
        assert flip[name].lowest == plain[name].lowest

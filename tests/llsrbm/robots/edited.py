"""Shipped robot files with other tables."""

import re

from llsrbm.robots import load_robot
from llsrbm.robots.schema import robot_files


def with_table(robot, table, content):
    """The text of a robot's file with `[table]` and `content` in place of its own, and of those
    below that.
    """
    text = robot_files()[robot].read_text()
    rest = re.sub(rf"(?ms)^\[{re.escape(table)}[].].*?(?=^\[|\Z)", "", text)
    return f"{rest}\n[{table}]\n{content}\n"


def rolling(folder):
    """Go2 by a file that allows barrel rolls, too, as no shipped one does."""
    path = folder / "rolls.toml"
    text = robot_files()["go2"].read_text()
    assert 'axes = ["pitch"]' in text
    path.write_text(text.replace('axes = ["pitch"]', 'axes = ["pitch", "roll"]'))
    return load_robot(str(path))

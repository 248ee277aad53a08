"""Shipped robot files with other tables."""

import re

from llsrbm.robots.schema import robot_files


def with_table(robot, table, content):
    """The text of a robot's file with `[table]` and `content` in place of its own, and of those
    below that.
    """
    text = robot_files()[robot].read_text()
    rest = re.sub(rf"(?ms)^\[{re.escape(table)}[].].*?(?=^\[|\Z)", "", text)
    return f"{rest}\n[{table}]\n{content}\n"

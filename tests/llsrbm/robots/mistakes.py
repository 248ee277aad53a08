"""Robot files with a mistake, and what is said of it."""

import pytest

from llsrbm.errors import RobotFileError
from llsrbm.robots import load_robot


def check_one_clear_line(path, text, expected):
    """Write a robot file that is wrong: the message is one line, with its name and these parts."""
    path.write_text(text)
    with pytest.raises(RobotFileError) as caught:
        load_robot(str(path))
    message = str(caught.value)
    assert "\n" not in message
    for part in [path.name, *expected]:
        assert part in message

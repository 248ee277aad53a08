"""Whether two trajectories are the same, array by array."""

from dataclasses import fields, is_dataclass

import numpy as np


def assert_same(a, b):
    """Of two plans, rollouts or solutions, every field bit for bit."""
    assert type(a) is type(b)
    for field in fields(a):
        x, y = getattr(a, field.name), getattr(b, field.name)
        if isinstance(x, np.ndarray):
            assert x.dtype == y.dtype, field.name
            np.testing.assert_array_equal(x, y, err_msg=field.name)
        elif is_dataclass(x) and type(x).__eq__ is object.__eq__:
            assert_same(x, y)
        else:
            assert x == y, field.name

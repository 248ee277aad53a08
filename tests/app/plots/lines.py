"""The twist of the plots' planned motion, and values of their lines."""

import numpy as np

TWIST = 2.5


def at(line, instant):
    """A line's value, between its points too."""
    return np.interp(instant, line.time, line.values)

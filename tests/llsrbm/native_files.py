"""Native files to damage, and what `load` says of them."""

import numpy as np
import pytest

from llsrbm.errors import FileFormatError
from llsrbm.motion.trajectory import load


def rewritten(path, out, **changes):
    """The file with some keys replaced, or left out where the new value is None."""
    with np.load(path) as archive:
        arrays = {**archive, **changes}
    np.savez(out, **{key: value for key, value in arrays.items() if value is not None})
    return out


def message(path):
    with pytest.raises(FileFormatError) as caught:
        load(path)
    text = str(caught.value)
    assert "\n" not in text
    assert str(path) in text
    return text

"""What the tests of commands on a wire share."""

import pytest

from tests.llsrbm.formats.wire.jumps import KINDS


@pytest.fixture(scope="module", params=KINDS)
def kind(request):
    """Of the motion that is written."""
    return request.param

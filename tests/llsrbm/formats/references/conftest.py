"""What the tests of reference motions share."""

import pytest

from tests.llsrbm.formats.jumps import ROBOTS


@pytest.fixture(scope="module", params=ROBOTS)
def name(request):
    """Of the robot that has jumped."""
    return request.param

"""What the tests of logs share."""

import pytest

from tests.llsrbm.formats.jumps import planned
from tests.llsrbm.formats.logs.logs import ROBOTS


@pytest.fixture(scope="module", params=ROBOTS)
def plan(request):
    return planned(request.param)

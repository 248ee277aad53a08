import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from llsrbm.formats.logs.mcap_log import nanoseconds, timestamp
from llsrbm.mechanics import turned_to

WAYS = [[0, 0, 2.0], [0, 0, -1], [3, 0, 0], [-1, 0, 0], [-1, 1e-7, 0], [0.3, -0.5, 0.8]]


@pytest.mark.parametrize("way", WAYS)
def test_arrows_are_turned_where_they_point(way):
    wxyz = turned_to(np.array([[way]]), 0)[0, 0]
    assert np.linalg.norm(wxyz) == pytest.approx(1)
    length = np.linalg.norm(way)
    drawn = Rotation.from_quat(wxyz, scalar_first=True).apply([length, 0, 0])
    np.testing.assert_allclose(drawn, way, atol=1e-6)


def test_instants_are_whole_nanoseconds():
    assert nanoseconds(np.array([0.0, 1.2345678904])) == [0, 1_234_567_890]
    stamp = timestamp(1_234_567_890)
    assert (stamp.sec, stamp.nsec) == (1, 234_567_890)

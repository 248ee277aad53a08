import pytest

from llsrbm.control.detection import model_uncertainty
from llsrbm.robots import load_robot
from llsrbm.robots.schema import Uncertainty


def test_what_is_stated_is_two_standard_deviations():
    file = load_robot("anymal").file
    stated = file.model_copy(update={"uncertainty": Uncertainty(trunk_mass=0.16)})
    assert model_uncertainty(stated).trunk_mass == pytest.approx(0.08)


@pytest.mark.parametrize("name", ["anymal", "go2", "slider"])
def test_files_without_the_table_state_ten_per_cent(name):
    assert model_uncertainty(load_robot(name).file).trunk_mass == pytest.approx(0.05)

import pytest

from llsrbm import models
from llsrbm.errors import InputError
from llsrbm.models.base import CentroidalModel
from tests.llsrbm.models.postures import ROBOT


def test_names_of_the_contract():
    assert tuple(models.MODELS) == ("srbm", "llsrbm", "llsrbm-plus")


@pytest.mark.parametrize("name", models.MODELS)
def test_made_by_name(name):
    model = models.make_model(name, ROBOT)
    assert isinstance(model, CentroidalModel)
    assert model.name == name
    assert model.mass == pytest.approx(ROBOT.mass)
    assert model.base_mass + model.leg_mass.sum() == pytest.approx(ROBOT.mass)


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(InputError) as caught:
        models.make_model("SRBM", ROBOT)
    assert str(caught.value) == 'no model "SRBM"; valid: srbm, llsrbm, llsrbm-plus'

import pytest

from llsrbm import models
from llsrbm.errors import InputError
from llsrbm.models.base import CentroidalModel
from tests.llsrbm.models.postures import ROBOT


def test_names_of_the_contract():
    assert models.names() == ("srbm", "llsrbm", "llsrbm-plus")


def test_each_is_described_in_a_line():
    assert tuple(models.describe()) == models.names()
    for text in models.describe().values():
        assert 10 < len(text) < 100
        assert "\n" not in text


@pytest.mark.parametrize("name", models.names())
def test_made_by_name(name):
    model = models.make_model(name, ROBOT)
    assert isinstance(model, CentroidalModel)
    assert model.name == name
    assert model.mass == pytest.approx(ROBOT.mass)
    assert model.base_mass + model.leg_mass.sum() == pytest.approx(ROBOT.mass)


@pytest.mark.parametrize("name", ["", "SRBM", "llsrbm+"])
def test_an_unknown_name_lists_the_known_ones(name):
    message = f"unknown model {name!r}; the models are srbm, llsrbm, llsrbm-plus"
    with pytest.raises(InputError) as caught:
        models.make_model(name, ROBOT)
    assert str(caught.value) == message
    with pytest.raises(InputError):
        models.check_name(name)

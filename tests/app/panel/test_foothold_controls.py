"""The numbers of single feet's landing places."""

from types import SimpleNamespace

import pytest

from app.panel.foothold_controls import LEG, NUMBERS, FootholdControls
from llsrbm.request.jump import Jump
from llsrbm.robots import load_robot
from tests.app.panel.test_fields import Gui

ROBOT = load_robot("go2")
JUMP = Jump(robot="go2", forward=0.1)
AHEAD, LEFT, UP = NUMBERS


class Menu(SimpleNamespace):
    """A menu as viser has it: one of its options is chosen."""

    def __setattr__(self, name, value):
        super().__setattr__(name, value)
        if name == "options" and self.value not in value:
            self.value = value[0]


class Panel(Gui):
    def add_dropdown(self, label, options, *, initial_value, **how):
        return Menu(value=initial_value, options=options, on_update=lambda _: None, **how)


class Shown:
    def __init__(self):
        self.controls = FootholdControls(Panel(), JUMP, lambda act: None)
        self.controls._fields.add(LEG, *NUMBERS)
        self.jump = JUMP

    def set(self, field, value):
        """As a hand does; the jump that is read then."""
        self.controls._fields.handle(field).value = value
        self.jump, complaints = self.controls.read(self.jump)
        self.show()
        return complaints

    def show(self, robot=ROBOT):
        self.controls.show(self.jump, robot)

    def value(self, field):
        return self.controls._fields.handle(field).value


@pytest.fixture
def shown():
    shown = Shown()
    shown.show()
    return shown


def test_the_first_leg_is_chosen_and_numbers_move_its_foot(shown):
    assert (shown.value(LEG), shown.value(AHEAD)) == ("FL", 0.0)
    assert not shown.set(AHEAD, 42.0)
    assert not shown.set(UP, 20.0)
    assert shown.jump.stones == (("FL", 0.042, 0.0, 0.02),)
    shown.set(LEG, "RR")
    assert [shown.value(field) for field in NUMBERS] == [0.0, 0.0, 0.0]
    shown.set(LEFT, -30.0)
    assert shown.jump.stones == (("FL", 0.042, 0.0, 0.02), ("RR", 0.0, -0.03, 0.0))
    shown.set(LEG, "FL")
    assert [shown.value(field) for field in NUMBERS] == [42.0, 0.0, 20.0]


def test_a_foot_out_of_reach_goes_as_far_as_its_leg_does(shown):
    shown.set(AHEAD, 300.0)
    (stone,) = shown.jump.stones
    assert 0.05 < stone.dx < 0.3
    assert shown.value(AHEAD) == pytest.approx(1000 * stone.dx)


def test_without_a_robot_there_are_none():
    shown = Shown()
    shown.show(robot=None)
    assert not any(shown.controls._fields.handle(field).visible for field in (LEG, *NUMBERS))
    assert shown.controls.read(JUMP) == (JUMP, [])


def test_of_another_robot_its_first_leg_is_chosen(shown):
    shown.set(LEG, "RR")
    shown.jump = Jump(robot="g1")
    shown.show(load_robot("g1"))
    assert shown.value(LEG) == load_robot("g1").leg_names[0]

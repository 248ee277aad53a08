"""The controls of a push, and of planning anew."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import viser

from app.guard.validation import number, put
from llsrbm.errors import InputError
from llsrbm.request.push import LARGEST_IMPULSE, Push
from llsrbm.request.scenario import Scenario

_LATEST = 10.0  # s; later than any motion ends
_TIME = ("Push at [s]", 3)  # label and decimals shown
_AXES = (("Push x [N s]", 1), ("Push y [N s]", 1), ("Push z [N s]", 1))


class PushControls:
    """One push (of several in a design, the first) and replanning, in the container that is open.

    Attributes:
        with_and_without, other_model: buttons that simulate the push twice.
    """

    def __init__(self, gui: viser.GuiApi) -> None:
        """No push, and no replanning."""
        self._push = gui.add_checkbox(
            "Push",
            initial_value=False,
            hint="A push on the trunk, where the timeline stands: drag its arrow's tip",
        )
        self._time = gui.add_number(
            _TIME[0], 0.0, min=0.0, max=_LATEST, step=0.001, visible=False, hint="When it begins"
        )
        self._impulse = [
            gui.add_number(
                label,
                0.0,
                min=-LARGEST_IMPULSE,
                max=LARGEST_IMPULSE,
                step=0.1,
                visible=False,
                hint="Impulse, world frame: x forward, y left, z up",
            )
            for label, _ in _AXES
        ]
        self._replan = gui.add_checkbox(
            "Replan",
            initial_value=False,
            hint="Plan flight and landing anew, 50 times a second, from what is measured",
        )
        self.with_and_without = gui.add_button(
            "With and without replanning",
            visible=False,
            hint="Simulate the push both ways, and play both side by side",
        )
        self.other_model = gui.add_button(
            "Against another model",
            visible=False,
            hint="Simulate the push on an SRBM plan too (on LL-SRBM+ if this is one)",
        )

    @property
    def handles(self) -> list[Any]:
        """The controls whose updates change the scenario."""
        return [self._push, self._time, *self._impulse, self._replan]

    def read(self, current: Scenario, complaints: list[str]) -> Scenario:
        """The scenario with push and replanning as the controls stand.

        Args:
            current: holds what has no control.
            complaints: takes what had to be corrected.
        """
        current = replace(current, replan=self._replan.value is True)
        if self._push.value is not True:
            return replace(current, pushes=())
        first, *others = current.pushes or (Push(0.0, (0.0, 0.0, 0.0)),)
        time = _read(_TIME, self._time.value, first.time, (0.0, _LATEST), complaints)
        ends = (-LARGEST_IMPULSE, LARGEST_IMPULSE)
        x, y, z = (
            _read(axis, handle.value, now, ends, complaints)
            for axis, handle, now in zip(_AXES, self._impulse, first.impulse, strict=True)
        )
        try:
            push = Push(time, (x, y, z), first.moment)
        except InputError as error:
            complaints.append(str(error))
            push = first
        return replace(current, pushes=(push, *others))

    def show(self, scenario: Scenario) -> None:
        """Put the controls where a scenario has them; without a push its numbers stay."""
        there = bool(scenario.pushes)
        put(self._push, there)
        put(self._replan, scenario.replan)
        for handle in (self._time, *self._impulse, self.with_and_without, self.other_model):
            handle.visible = there
        if there:
            push = scenario.pushes[0]
            put(self._time, round(push.time, _TIME[1]))
            for (_, decimals), handle, value in zip(
                _AXES, self._impulse, push.impulse, strict=True
            ):
                put(handle, round(value, decimals))


def _read(
    control: tuple[str, int], value: Any, now: float, ends: tuple[float, float], wrong: list[str]
) -> float:
    """A control's number; one that nobody touched stays as it is, however it is rounded."""
    label, decimals = control
    shown = number(label, value, ends, wrong)
    return now if math.isclose(shown, round(now, decimals), abs_tol=1e-9) else shown

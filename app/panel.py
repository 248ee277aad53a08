"""One tab's controls. Labels are part of the contract; values are checked where they are read."""

from __future__ import annotations

import math
from collections.abc import Callable, Coroutine, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

import viser

from app import markup
from app.player import SPEEDS
from app.replay import Figures
from llsrbm import models
from llsrbm.exporters import formats
from llsrbm.jump import Jump
from llsrbm.robots import RobotFile, names
from llsrbm.robots.schema import Task
from llsrbm.trajectory.plan import Plan


class Action(Enum):
    """What a user did; which value it led to is read from the panel afterwards."""

    REQUEST = auto()
    CANCEL = auto()
    PLAY = auto()
    PAUSE = auto()
    SCRUB = auto()
    PACE = auto()
    LAYERS = auto()
    EXPORT = auto()


@dataclass(frozen=True)
class _Axis:
    """A slider of the request: its label, its field in `Jump` and `Task`, display units per SI."""

    label: str
    field: str
    scale: float
    step: float
    hint: str


_AXES = (
    _Axis("Twist [deg]", "twist", 180 / math.pi, 1.0, "About the vertical, positive to the left"),
    _Axis("Forward [m]", "forward", 1.0, 0.01, "Along the heading at the start"),
    _Axis("Lateral [m]", "lateral", 1.0, 0.01, "Positive to the left"),
    _Axis("Landing height [m]", "height", 1.0, 0.01, "Of the landing surface above the start"),
)


class Panel:
    """The controls; to be used by one thread, except for the callbacks viser makes."""

    def __init__(
        self,
        client: viser.ClientHandle,
        jump: Jump,
        robot_file: RobotFile,
        act: Callable[[Action], None],
    ) -> None:
        """Build the controls.

        Args:
            client: whose tab.
            jump: the request to start from.
            robot_file: of its robot.
            act: told what the user did; called from viser's thread, must return at once.
        """
        self._client = client
        self._task = robot_file.task
        self._act = act
        self._plan: Plan | None = None
        self._scrubbed = 0.0
        gui = client.gui
        self._status = gui.add_html(markup.status("Planning", ""))
        with gui.add_folder("Jump"):
            self._robot = gui.add_dropdown("Robot", names(), initial_value=jump.robot)
            self._model = gui.add_dropdown("Model", models.names(), initial_value=jump.model)
            self._sliders = {axis.field: self._add_slider(axis, jump) for axis in _AXES}
            self._cancel = gui.add_button("Cancel", disabled=True, hint="Stop planning")
        with gui.add_folder("Playback"):
            self._transport = gui.add_button_group("Motion", ("Play", "Pause"))
            self._time = gui.add_slider("Time [s]", 0.0, 1.0, 0.01, 0.0)
            self._timeline = gui.add_html("")
            self._speed = gui.add_dropdown("Speed", SPEEDS, initial_value=SPEEDS[-1])
            self._loop = gui.add_checkbox("Loop", initial_value=True)
        with gui.add_folder("Figures"):
            self._figures = gui.add_html("")
        with gui.add_folder("Residuals", expand_by_default=False):
            self._residuals = gui.add_html("")
        with gui.add_folder("Show"):
            self._ellipsoids = gui.add_checkbox("Inertia ellipsoids", initial_value=True)
            self._forces = gui.add_checkbox("Forces", initial_value=True)
            self._trails = gui.add_checkbox("Trails", initial_value=True)
            gui.add_html(markup.legend())
        with gui.add_folder("File"):
            self._format = gui.add_dropdown("Format", tuple(formats()))
            self._export = gui.add_button("Export", disabled=True)
        with gui.add_folder("Help", expand_by_default=False):
            gui.add_html(markup.HELP)
        self._listen()

    # ---- what the user asks for

    def read_jump(self, current: Jump) -> tuple[Jump, list[str]]:
        """The request as the controls stand, and what had to be corrected in it.

        A browser's script can send anything, so nothing is taken for granted.

        Args:
            current: what counts where a control holds nothing usable.
        """
        complaints: list[str] = []
        robot = _option("Robot", self._robot.value, names(), current.robot, complaints)
        model = _option("Model", self._model.value, models.names(), current.model, complaints)
        amounts: dict[str, float] = {}
        for axis in _AXES:
            value = self._sliders[axis.field].value
            shown = _number(axis.label, value, _range(axis, self._task), complaints)
            amounts[axis.field] = shown / axis.scale
        return Jump(robot=robot, model=model, **amounts), complaints

    def read_time(self) -> float:
        """Where the user put the time slider, s."""
        duration = 0.0 if self._plan is None else self._plan.duration
        return _number("Time [s]", self._scrubbed, (0.0, duration), [])

    def read_pace(self) -> tuple[float, bool]:
        """Speed (seconds of motion a second) and whether to loop."""
        speed = _option("Speed", self._speed.value, SPEEDS, SPEEDS[-1], [])
        return float(speed.removesuffix("×")), bool(self._loop.value)

    def read_layers(self) -> dict[str, bool]:
        """What to draw, as arguments of `Scene.show_layers`."""
        return {
            "ellipsoids": bool(self._ellipsoids.value),
            "forces": bool(self._forces.value),
            "trails": bool(self._trails.value),
        }

    def read_format(self) -> tuple[str, list[str]]:
        """The file format to export, and what had to be corrected."""
        complaints: list[str] = []
        valid = tuple(formats())
        return _option("Format", self._format.value, valid, valid[0], complaints), complaints

    # ---- what the user is told

    def show_status(self, word: str, rest: str, *, busy: bool = False) -> None:
        """The status line; `busy` while there is something to cancel."""
        self._status.content = markup.status(word, rest)
        self._cancel.disabled = not busy

    def show_plan(self, plan: Plan, values: Figures) -> None:
        """A plan's numbers."""
        self._plan = plan
        self._time.max = round(max(plan.duration, 0.01), 2)
        self._figures.content = markup.figures(plan, values)
        self._residuals.content = markup.residuals(plan.violations)
        self._export.disabled = False

    def clear_plan(self) -> None:
        """No plan's numbers."""
        self._plan = None
        self._timeline.content = self._figures.content = self._residuals.content = ""
        self._export.disabled = True

    def show_time(self, time: float, *, playing: bool) -> None:
        """Where the motion is, s.

        While it plays, only the timeline moves: a browser loses what a user enters into a control
        that is being set.
        """
        if self._plan is None:
            return
        if not playing:
            _put(self._time, round(min(time, self._plan.duration), 2))
        self._timeline.content = markup.timeline(self._plan, time)

    def show_robot(self, robot_file: RobotFile) -> None:
        """The ranges of another robot; values outside of them move to the nearest end."""
        self._task = robot_file.task
        for axis in _AXES:
            handle = self._sliders[axis.field]
            handle.min, handle.max = _range(axis, robot_file.task)
            _put(handle, min(max(float(handle.value), handle.min), handle.max))

    def show_jump(self, jump: Jump) -> None:
        """Put the controls where a corrected request has them."""
        _put(self._robot, jump.robot)
        _put(self._model, jump.model)
        for axis in _AXES:
            _put(self._sliders[axis.field], _rounded(axis, getattr(jump, axis.field)))

    def notify(self, title: str, body: str) -> None:
        """A passing remark."""
        self._client.add_notification(title, body, auto_close_seconds=6.0, color="orange")

    # ---- inside

    def _add_slider(self, axis: _Axis, jump: Jump) -> viser.GuiSliderHandle[float]:
        lowest, highest = _range(axis, self._task)
        return self._client.gui.add_slider(
            axis.label,
            lowest,
            highest,
            axis.step,
            _rounded(axis, getattr(jump, axis.field)),
            hint=axis.hint,
        )

    def _listen(self) -> None:
        requests: list[Any] = [self._robot, self._model, *self._sliders.values()]
        for handle in requests:
            handle.on_update(self._told(Action.REQUEST))

        @self._time.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            if event.client_id is not None:
                # Kept apart, because the session sets the same slider.
                self._scrubbed = event.target.value
                self._act(Action.SCRUB)

        for handle in (self._speed, self._loop):
            handle.on_update(self._told(Action.PACE))
        for handle in (self._ellipsoids, self._forces, self._trails):
            handle.on_update(self._told(Action.LAYERS))
        self._cancel.on_click(self._told(Action.CANCEL))
        self._export.on_click(self._told(Action.EXPORT))

        @self._transport.on_click
        async def _(event: viser.GuiEvent[Any]) -> None:
            self._act(Action.PAUSE if event.target.value == "Pause" else Action.PLAY)

    def _told(self, action: Action) -> Callable[[viser.GuiEvent[Any]], Coroutine[Any, Any, None]]:
        # Asynchronous, so that it runs on the event loop as soon as the value is there; viser would
        # hand a plain function to one of 32 threads.
        async def callback(event: viser.GuiEvent[Any]) -> None:
            # Without a client, it was this panel that set the value.
            if event.client_id is not None:
                self._act(action)

        return callback


def _range(axis: _Axis, task: Task) -> tuple[float, float]:
    """A slider's ends: the task's, rounded inwards to whole steps (180.0004 deg is 180)."""
    lowest, highest = (axis.scale * end / axis.step for end in getattr(task, axis.field))
    slack = 1e-6  # -0.3 / 0.01 is -29.999999999999996
    return (
        round(math.ceil(lowest - slack) * axis.step, 6),
        round(math.floor(highest + slack) * axis.step, 6),
    )


def _rounded(axis: _Axis, value: float) -> float:
    return round(round(axis.scale * value / axis.step) * axis.step, 6)


def _put(handle: Any, value: float | str) -> None:
    """Set a control; mypy does not see the setter of viser's property."""
    handle.value = value


def _option(
    label: str, value: Any, valid: Sequence[str], otherwise: str, complaints: list[str]
) -> str:
    if isinstance(value, str) and value in valid:
        return value
    complaints.append(f"{label}: expected one of {', '.join(valid)}, got {value!r:.80}")
    return otherwise


def _number(label: str, value: Any, ends: tuple[float, float], complaints: list[str]) -> float:
    lowest, highest = ends
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        complaints.append(f"{label}: expected a number, got {value!r:.80}")
        return min(max(0.0, lowest), highest)
    slack = 1e-6 * max(1.0, abs(highest - lowest))
    if not lowest - slack <= value <= highest + slack:
        complaints.append(
            f"{label}: expected {lowest:.4g} to {highest:.4g}, got {value:.6g}; "
            "the nearest is taken"
        )
    return min(max(float(value), lowest), highest)

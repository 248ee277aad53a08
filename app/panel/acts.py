"""Acts of a visitor in the panel: presses of buttons, and controls that were moved.

A browser may skip values while a slider moves, and callbacks come on viser's event loop, so that an
act only says which controls to read. The session's thread reads them as they stand then.
"""

from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from enum import Enum
from typing import Any

import viser
from viser import Icon, IconName


@dataclass(frozen=True)
class Button:
    """A button, placed by `add_buttons`; its feature in `app.tab` says when it can be pressed."""

    place: str  # where in the panel, with others of the same place
    label: str  # label, hint: for people; static/tips.js shows hints
    hint: str | None = None
    icon: IconName | None = None  # in place of the label, which remains its name


_HOW_FAR = (
    "Find the largest jump towards the slider's side, with the other values as they are, and the "
    "limit that stops more; this takes minutes"
)


class Act(Enum):
    """An act: a button, or the name of a group of controls that was moved."""

    NEAREST = Button("verdict", "Use nearest", "Replace the request by this feasible jump")
    FAR_TWIST = Button("far twist", "How far?", _HOW_FAR)
    FAR_FORWARD = Button("far forward", "How far?", _HOW_FAR)
    FAR_LATERAL = Button("far lateral", "How far?", _HOW_FAR)
    FAR_HEIGHT = Button("far height", "How far?", _HOW_FAR)
    USE_LARGEST = Button("far", "Use largest", "Replace the request by this jump")
    SIMULATE = Button("main", "Simulate", "Simulate the whole robot following the plan in MuJoCo")
    CANCEL = Button("main", "Cancel", "Stop the computation")
    CHOOSE_EXPORT = Button(
        "choose export", "Export…", "Choose a file by what it is for, and save the motion as that"
    )
    EXPORT = Button("export", "Export", "Save the motion as a file of the format beside")
    STOP_FILES = Button("stop", "Stop", "Stop reading or writing this file")
    UNDO = Button(
        "history", "Undo", "Go back to the design before the last change", Icon.ARROW_BACK_UP
    )
    REDO = Button("history", "Redo", "Restore the design that was undone", Icon.ARROW_FORWARD_UP)
    EXAMPLES = Button("examples", "Examples", "Designs to start from, each with a moving picture")
    HELP = Button("help", "Help", "Topics, and a line on each term of the page", Icon.HELP)
    SHARE = Button("share", "Share", "Make a link that opens this design", Icon.LINK)
    COMPARE_REPLANNING = Button(
        "push",
        "With and without replanning",
        "Simulate the push with and without replanning, side by side",
    )
    COMPARE_MODELS = Button(
        "compare",
        "Compare models",
        "Plan this request with each inertia model and simulate each plan, side by side",
    )
    COMPARE_ARMS = Button(
        "compare",
        "Free and held arms",
        "Plan this request with free and with held arms and simulate both, side by side",
    )
    COMPARE_DRIVES = Button(
        "drives",
        "True and ideal drives",
        "Simulate this plan with the drives' rotors, friction and delay and without, side by side",
    )
    SEEDS = Button(
        "seeds",
        "Simulate 20 seeds",
        "Simulate the plan under 20 disturbances and count the landings",
    )
    ROBOT_SIMULATOR = Button(
        "seeds",
        "Simulate as on the robot",
        "Play the plan as on the robot: its wire's delays, sensors, an estimator, the player; the "
        "direct simulation is pinned beside it",
    )
    WORST = Button(
        "worst", "Show the worst seed", "Show the simulation that fell first or erred most"
    )
    PIN = Button("pin", "Pin", "Keep this design as a ghost to compare others with")
    USE_PINNED = Button("pinned", "Use this design", "Make the pinned design the current one")
    UNPIN = Button("pinned", "Unpin", "Take the pinned design out of picture, charts and table")
    CHECK = Button(
        "certificate",
        "Check the motion",
        "Check joint stops, drives, friction and distances at 1 kHz",
    )
    RESET_TUNING = Button(
        "limits", "Reset all", "Restore the defaults of the robot and the jump type"
    )
    RESET_FOOTHOLDS = Button(
        "footholds", "Reset footholds", "Have every foot land where it does by itself"
    )
    DRAW_ROUTE = Button(
        "route",
        "Draw route",
        "Click the ground where the robot shall land, one landing after the other",
    )
    STOP_DRAWING = Button("route", "Stop drawing", "Have clicks in the picture add no landings")
    ADD_LANDING = Button(
        "route", "Add landing", "Have the robot jump on from its last landing, straight ahead"
    )
    REMOVE_LANDING = Button(
        "route", "Remove landing", "Leave out the landing above; the others stay where they are"
    )
    REMOVE_ROUTE = Button("route", "Remove route", "Have the route's first jump alone")
    ADD_CHART = Button(
        "add chart",
        "Add chart",
        "Drag this button, or a chart's title, onto a chart to combine them",
    )
    REMOVE_CHART = Button("charts", "Remove chart", "Take the chosen chart away")
    SAVE_LINES = Button("charts", "Download", "Save all shown lines with their own instants as CSV")
    SAVE = Button(
        "files",
        "Save design",
        "Save request, weights, limits and scenario as a small file to open here",
    )

    JUMP = "jump"
    ROUTE = "route"
    WHOLE_BODY = "whole body"
    SCENARIO = "scenario"
    AUTOMATIC = "automatic"
    VIEW = "view"
    ATLAS = "atlas"
    PINNED = "pinned"
    FILES = "files"
    PLOTS = "plots"
    PLOT_AREA = "plot area"


HOW_FAR = {
    "twist": Act.FAR_TWIST,
    "forward": Act.FAR_FORWARD,
    "lateral": Act.FAR_LATERAL,
    "height": Act.FAR_HEIGHT,
}
"""The buttons that search along a slider, by fields of a request."""

Put = Callable[[Act], None]  # Takes an act on viser's event loop; must return at once

Buttons = dict[Act, viser.GuiButtonHandle]

_Callback = Callable[[viser.GuiEvent[Any]], Coroutine[Any, Any, None]]


def callback(put: Put, act: Act) -> _Callback:
    """A callback for a control.

    Asynchronous, so that it runs on the event loop as soon as the value is there, in order; viser
    would hand a plain function to one of 32 threads.
    """

    async def report(event: viser.GuiEvent[Any]) -> None:
        # Without a client, it was the panel itself that set the value.
        if event.client_id is not None:
            put(act)

    return report


def add_buttons(gui: viser.GuiApi, place: str, put: Put) -> Buttons:
    """Add the buttons of a place to the container that is open."""
    added = {}
    for act in Act:
        button = act.value
        if isinstance(button, Button) and button.place == place:
            added[act] = gui.add_button(button.label, icon=button.icon)
            added[act].on_click(callback(put, act))
    return added

"""The atlas: sweeps to choose from, the map that is drawn of one, and jumps that a click opens.

The map is made and sent anew only where it changes: with the choice, with the robot, and with what
the design says of axes that are not shown. The design's point moves with every slider.
"""

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.link import AtlasClicked, AtlasSeen, PageLink
from app.panel.acts import Act
from app.panel.atlas_controls import AtlasChoice, AtlasControls, as_sent
from app.panel.jump_types import title_of_type
from app.tab.acts import Step, also, keeps, on, reads
from app.tab.effects import Notify
from app.tab.planning.requests import plan_design, remember, untitled
from app.tab.state import TabState
from llsrbm.atlas.colours import COLOURS
from llsrbm.atlas.jumps import Atlas, Axis, Jumps
from llsrbm.atlas.learned import TITLE, learned_atlas
from llsrbm.atlas.map import map_of
from llsrbm.atlas.table import read_atlas
from llsrbm.errors import InputError
from llsrbm.look.titles import title_of_model
from llsrbm.planning.problem.placement import limits_of
from llsrbm.request.design import Design
from llsrbm.request.jump import Jump
from llsrbm.request.tuning import Tuning
from llsrbm.robots import Robot
from llsrbm.sweep.rows import LIMIT, robot_hash


class Atlases:
    """Read when they are first needed, once for all tabs; from any thread."""

    def __init__(self, folders: Sequence[Path] = ()) -> None:
        """Read folders of sweeps or their tables; raises `InputError` where one is none."""
        self._lock = threading.Lock()
        self._read: dict[str, Atlas] = {}
        for folder in folders:
            atlas = read_atlas(folder)
            name = atlas.title
            if name in self._read:
                name = f"{name} ({folder.name})"
            if name in self._read:
                raise InputError(f"--atlas: {folder} is given twice; expected each once")
            self._read[name] = atlas
        self.names: tuple[str, ...] = (*self._read, TITLE)  # to choose from, one at least

    def named(self, name: str) -> Atlas | None:
        """The atlas of a name ("": the first); None: there is none of it."""
        name = name or self.names[0]
        with self._lock:
            if name == TITLE and name not in self._read:
                self._read[name] = learned_atlas()
            return self._read.get(name)


# ---- events


@dataclass(frozen=True)
class JumpOpened:
    """A jump of the atlas was chosen."""

    jump: Jump  # the request
    tuning: Tuning  # with the limits that its sweep varied
    other_drives: bool = False  # its sweep had stronger or weaker drives, which a page has not


@on(JumpOpened)
def open_jump(state: TabState, event: JumpOpened) -> Step:
    """Plan a jump of the atlas, with the limits of its sweep; the scenario stays."""
    state, design = untitled(state, event.jump, event.tuning)
    step = plan_design(remember(state, design, settled=True))
    if not event.other_drives:
        return step
    body = "The sweep had other drives there; this page plans with the robot's own."
    return also(step, Notify("Opened with other drives", body))


reads(Act.ATLAS, lambda state, panel: (panel.atlas.read(state.atlas), []))


keeps(AtlasChoice, "atlas")


@on(AtlasSeen)
def show_atlas(state: TabState, _: AtlasSeen) -> TabState:
    """The page shows the atlas: there shall be a map in it."""
    return replace(state, atlas=replace(state.atlas, seen=True))


# ---- the map


class AtlasDrawing:
    """One tab's; for the session's thread. It knows what was sent last, and no other fact."""

    def __init__(self, controls: AtlasControls, link: PageLink, atlases: Atlases) -> None:
        self._controls, self._link, self._atlases = controls, link, atlases
        self._made_of: tuple[Any, ...] = ()
        self._sent: dict[str, Any] | None = None

    def draw(self, state: TabState) -> None:
        """Draw what has changed, once the page has shown the atlas."""
        if not state.atlas.seen or not state.ready or state.robot is None:
            return
        found = self._jumps(state)
        jumps = found if isinstance(found, Jumps) else None
        design = placed(state.design, state.robot, () if jumps is None else jumps.axes)
        axes = None if jumps is None else state.atlas.axes(jumps.axes)
        shown = () if axes is None else (axes[0].name, axes[1].name)
        # Of the design only what its slice is of: a map takes longer than a slider's next step.
        hidden = (
            ()
            if jumps is None
            else tuple(design.get(axis.name) for axis in jumps.axes if axis.name not in shown)
        )
        jump = state.design.jump
        made_of = (state.atlas, jump.robot, jump.model, jump.type, found, hidden)
        if made_of != self._made_of:
            self._made_of = made_of
            self._show(state, found, design)
        if axes is not None:
            x, y = (design.get(axis.name, 0.0) * axis.scale for axis in axes)
            self._link.call("atlas.mark", x, y)

    def _show(self, state: TabState, found: Jumps | str, design: dict[str, float]) -> None:
        choice = state.atlas
        if isinstance(found, str):
            self._controls.show(choice, (), found)
            self._send(None)
            return
        axes = choice.axes(found.axes)
        if axes is None:
            self._controls.show(choice, (), "One axis varies here; a map needs two.")
            self._send(None)
            return
        self._controls.show(choice, found.axes, _remarks(found, state.design.jump))
        colour = COLOURS[choice.colour]
        drawn = map_of(found, *axes, colour, projection=choice.projection, design=design)
        self._send(as_sent(drawn, choice.sweep or self._atlases.names[0]))

    def _send(self, sent: dict[str, Any] | None) -> None:
        if sent != self._sent or sent is None:
            self._sent = sent
            self._link.call("atlas.show", sent)

    def _jumps(self, state: TabState) -> Jumps | str:
        jump = state.design.jump
        atlas = self._atlases.named(state.atlas.sweep)
        jumps = atlas and atlas.jumps_of(jump.robot, jump.model, jump.type)
        if jumps:
            return jumps
        if (state.atlas.sweep or self._atlases.names[0]) == TITLE:
            return (
                f"{state.file.title} has no table of solved jumps; `llsrbm robot learn` makes one."
            )
        return f"This sweep has no jumps of {state.file.title}."

    # ---- clicks

    def opened(self, click: AtlasClicked) -> JumpOpened | None:
        """The jump that a page asks for; None if there is none."""
        atlas = self._atlases.named(click.sweep)
        found = atlas and atlas.find(click.jump)
        if not found:
            return None
        jumps, place = found
        jump, limits, drives = jumps.request(place)
        return JumpOpened(jump, Tuning(limits=limits), other_drives=bool(drives))


def placed(design: Design, robot: Robot, axes: Sequence[Axis]) -> dict[str, float]:
    """Axis name -> a design's value there, SI."""
    jump = design.jump.as_dict()
    values: dict[str, float] = {}
    for axis in axes:
        if axis.name.startswith(LIMIT):
            name = axis.name.removeprefix(LIMIT)
            values[axis.name] = design.tuning.limits.get(name, limits_of(robot)[name][1])
        else:  # a page's drives are those of the robot's file
            values[axis.name] = float(jump.get(axis.name, axis.otherwise or 0.0))
    return values


def _remarks(jumps: Jumps, jump: Jump) -> str:
    remarks = []
    if (jumps.model, jumps.type) != (jump.model, jump.type):
        what = f"{title_of_type(jumps.type)}, {title_of_model(jumps.model)}"
        remarks.append(f"These jumps are {what}.")
    if jumps.robot_hash != robot_hash(jump.robot):
        remarks.append("The robot's file has changed since they were planned.")
    return " ".join(remarks)

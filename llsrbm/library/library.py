"""A library: a folder of motions, of which each is found by its card and opened by its name."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from llsrbm.certificate import certify
from llsrbm.errors import FileFormatError, InputError, RobotFileError
from llsrbm.installed import assets_directory
from llsrbm.library import file
from llsrbm.library.card import NONE, Card, Figures, Simulated, kind_of, rounded_request
from llsrbm.library.file import FileMeta, StoredMotion
from llsrbm.library.search import Filters, found
from llsrbm.library.stick_figure import StickFigure
from llsrbm.library.stored import reopened, stored
from llsrbm.motion.plan import Plan
from llsrbm.motion.robot import robot_of
from llsrbm.request.messages import look_up
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_strength
from llsrbm.robots.payload import with_payload
from llsrbm.robots.robot import Robot
from llsrbm.robots.schema import robot_files
from llsrbm.text_files import path_of

PARTS = "parts"
"""Folder of motions that a build has not put together yet, a file each."""


def shipped() -> Library:
    """The library that comes with the project."""
    return Library(assets_directory() / "library")


class Library:
    """The motions in a folder, which need not exist yet; its cards are read once."""

    def __init__(self, folder: str | Path) -> None:
        self.folder = path_of(folder)

    @cached_property
    def _where(self) -> dict[str, tuple[Path, FileMeta, Card]]:
        """Name -> the file it is in, what that says, and its card."""
        entries: dict[str, tuple[Path, FileMeta, Card]] = {}
        for path in self.files:
            meta, cards = file.read_cards(path)
            entries |= {card.name: (path, meta, card) for card in cards}
        return dict(sorted(entries.items()))

    @property
    def files(self) -> list[Path]:
        """Its files, also those of a build that is not done yet."""
        return [*sorted(self.folder.glob("*.npz")), *sorted(self.folder.glob(f"{PARTS}/*.npz"))]

    @property
    def cards(self) -> list[Card]:
        """Those of all motions. Raises `FileFormatError`: a file is damaged."""
        return [card for _, _, card in self._where.values()]

    def card(self, name: str) -> Card:
        """One motion's. Raises `InputError`: there is none of that name."""
        return self._entry(name)[2]

    def _entry(self, name: str) -> tuple[Path, FileMeta, Card]:
        if not self._where:
            raise InputError(f"{self.folder}: no library is there; expected one that was built")
        return look_up("motion", name, self._where, "see `llsrbm library`")

    def found(self, words: Sequence[str] = (), filters: Filters | None = None) -> list[Card]:
        """The motions that words and figures say: see `llsrbm.library.search`."""
        return found(self.cards, words, filters)

    def open(self, name: str, *, check: bool = True) -> Plan:
        """A motion as a plan, without any solver.

        `check`: certify it again, at 1 kHz; else its certificate is the one that its card states.

        Raises:
            InputError: there is none of that name.
            FileFormatError: it is damaged, or of a robot that has other joints by now.
            RobotFileError: the robot is not there.
        """
        path, meta, card = self._entry(name)
        robot = robot_of_card(card)
        if list(robot.joint_names) != meta.joint_names:
            raise FileFormatError(
                f"{path}: the motions are of {meta.robot} with the joints "
                f"{', '.join(meta.joint_names)}; expected {', '.join(robot.joint_names)}, as the "
                "robot's file has them"
            )
        numbers = file.read_numbers(path, name)
        plan = reopened(card, numbers, robot, f"{path}: {name}")
        if check:
            plan = replace(plan, certificate=certify(plan, robot).as_dict())
        return plan

    def stored(self, name: str) -> StoredMotion:
        """A motion as its file has it."""
        path, _, card = self._entry(name)
        figure = file.read_stick_figures(path, [name]).get(name)
        return StoredMotion(card, file.read_numbers(path, name), figure)

    def stick_figures(self) -> dict[str, StickFigure]:
        """Name -> the stick figure of a motion that has one; no motion is opened.

        Raises `FileFormatError`: a file is damaged.
        """
        found: dict[str, StickFigure] = {}
        for path in self.files:
            found |= file.read_stick_figures(path)
        return found

    def add(self, plan: Plan, simulated: Simulated | None = None) -> Card:
        """Put a plan into the library; its certificate is made anew from what is kept of it.

        `simulated`: how simulations of it ended, if there were some.

        Raises:
            InputError: as of `stored_motion` and `put`.
        """
        return self.put(stored_motion(plan, simulated or Simulated()))

    def put(self, motion: StoredMotion) -> Card:
        """Name a motion, and write it into a file of its own in `PARTS`; `packed` joins these.

        Raises:
            InputError: the library has a motion of that request, or the file cannot be written.
        """
        card = motion.card
        if there := self.with_request(card):
            raise InputError(f"{there.name} is the motion of that request; expected another one")
        name = f"{stem_of(card)}-{self._next_number(card):04d}"
        card = card.model_copy(update={"name": name})
        folder = self.folder / PARTS
        folder.mkdir(parents=True, exist_ok=True)
        path, meta = folder / f"{name}.npz", FileMeta.of(load_robot(card.robot))
        file.write(path, meta, [replace(motion, card=card)])
        self._requests[_key(card)] = name
        self._where[name] = path, meta, card
        return card

    def with_request(self, card: Card) -> Card | None:
        """The motion of a card's robot and request, to a millimetre and a thousandth of a rad."""
        name = self._requests.get(_key(card))
        return None if name is None else self.card(name)

    @cached_property
    def _requests(self) -> dict[str, str]:
        """Robot and request -> the motion's name."""
        return {_key(card): card.name for card in self.cards}

    def _next_number(self, card: Card) -> int:
        prefix = f"{stem_of(card)}-"
        taken = (name.removeprefix(prefix) for name in self._where if name.startswith(prefix))
        return 1 + max((int(number) for number in taken if number.isdigit()), default=0)

    def packed(self) -> None:
        """Join each robot's motions into one file, `ROBOT.npz`, or several of `file.MOST` each.

        Motions of older files get their stick figures, if their robot is as it was.
        """
        robots: dict[str, list[str]] = {}
        for name, (_, meta, _) in self._where.items():
            robots.setdefault(meta.robot, []).append(name)
        for robot, names in robots.items():
            meta = self._where[names[0]][1]
            parts = [names[k : k + file.MOST] for k in range(0, len(names), file.MOST)]
            motions = [[self._with_figure(name) for name in part] for part in parts]
            for number, part in enumerate(motions, start=1):
                suffix = "" if number == 1 else f"-{number}"
                file.write(self.folder / f"{robot}{suffix}.npz", meta, part)
        _remove(self.folder / PARTS)
        del self._where

    def _with_figure(self, name: str) -> StoredMotion:
        """A motion as its file has it, and with a stick figure where that has none."""
        motion = self.stored(name)
        if motion.figure is not None:
            return motion
        try:
            return replace(motion, figure=StickFigure.of(self.open(name, check=False)))
        except (FileFormatError, InputError, RobotFileError):  # it cannot be opened any more
            return motion


def stored_motion(plan: Plan, simulated: Simulated, drawn: int | None = None) -> StoredMotion:
    """A plan as a library keeps it, with its card; its name has no number of its own yet.

    Raises:
        InputError: a draft, a motion whose certificate does not hold as it is kept, or a robot that
            is none of the built-in ones.
    """
    robot = robot_of(plan)
    if not any(robot.path == path for path in robot_files().values()):
        raise InputError(f"{robot.path}: expected one of the robots of `llsrbm robots`")
    grid, numbers = stored(plan, robot)
    assert plan.refinement is not None  # by `stored`
    card = Card(
        name=f"{robot.name}-{kind_of(plan.jump)}-0000",
        kind=kind_of(plan.jump),
        robot=robot.name,
        drawn=drawn,
        request=replace(plan.jump, robot=robot.name),
        figures=NONE,
        simulated=simulated,
        certificate={},
        tuning=plan.tuning,
        limits=dict(plan.limits),
        report=plan.report,
        refinement=plan.refinement,
        intervals=tuple(count for _, count in grid.phases),
        denser_in_flight=grid.denser_in_flight,
    )
    return checked(StoredMotion(card, numbers), robot)


def checked(motion: StoredMotion, robot: Robot) -> StoredMotion:
    """A motion with the certificate, the figures and the stick figure of what is kept of it.

    Raises `InputError`: the certificate does not hold.
    """
    card = motion.card
    kept = reopened(card, motion.numbers, robot, card.name)
    certificate = certify(kept, robot)
    if not certificate.holds:
        broken = ", ".join(found.name for found in certificate.broken) or "some are not known"
        raise InputError(f"the certificate does not hold ({broken}); expected one that does")
    found = {"figures": Figures.of(kept, certificate), "certificate": certificate.as_dict()}
    return StoredMotion(card.model_copy(update=found), motion.numbers, StickFigure.of(kept))


def stem_of(card: Card) -> str:
    """A motion's name without its number."""
    return f"{card.robot}-{card.kind}"


def _key(card: Card) -> str:
    return json.dumps([card.robot, rounded_request(card.request)], sort_keys=True)


def robot_of_card(card: Card) -> Robot:
    """A motion's robot with its payload, its drives as strong and as fast as planned with."""
    strength, battery = (card.limits.get(name, 1.0) for name in ("drive_strength", "battery"))
    loaded = with_payload(load_robot(card.robot), card.request.payload)
    return with_strength(loaded, strength, battery)


def _remove(folder: Path) -> None:
    for path in sorted(folder.glob("*.npz")):
        path.unlink(missing_ok=True)
    if folder.is_dir() and not any(folder.iterdir()):
        folder.rmdir()

"""Edits in the timeline and the picture, obeyed and undone: `python -m benchmarks.edits`.

A tab over a real connection, without a browser, has ends of phases, apexes and landing places of
feet dragged at random, one after another, each by itself, with the real planner; undo follows each.
Printed are how far the plan that rests is from where each was dragged to, and whether the motion
before is back to the last bit. Exit status 1 where one is off by more than 5 ms or 5 mm, or is not
back. An edit that is answered by the nearest jump, or refused, is counted by itself.
"""

from __future__ import annotations

import argparse
import sys
from contextlib import closing
from typing import Any

import numpy as np

from app.designer import Designer
from app.panel.status import Verdict
from app.picture.foothold_handles import FootholdDragged
from app.tab.session import Session
from app.tab.shaping import first_flight, handles_of
from benchmarks.visitor import PATIENCE, Visitor
from tests.app.raw_tab import PLANNED, RawTab

MOST = 5.0  # ms and mm
REACH_TIME, REACH_HEIGHT, REACH_FOOT = 0.04, 0.03, 0.04  # s, m, m to either side
KINDS = ("edge", "apex", "foothold")


class Hand(Visitor):
    """Drags in one tab, and waits for what comes of it."""

    def __init__(self, tab: RawTab, session: Session, rng: np.random.Generator) -> None:
        super().__init__(tab, session)
        self.rng, self.grips = rng, 0

    def edge(self) -> float:
        """Drag the end of a phase; how far the plan's is from there, ms."""
        handles = handles_of(self.session.state)
        assert handles is not None
        index = int(self.rng.integers(len(handles.edges)))
        edge = handles.edges[index]
        wanted = edge.time + float(self.rng.uniform(-REACH_TIME, REACH_TIME))
        wanted = min(max(wanted, edge.low), edge.high)
        starts = [*handles.starts]
        starts[index + 1] = wanted
        durations = np.diff(starts[: edge.phases + 1]).tolist()
        self.answered(lambda: self.tab.page.say(kind="phases", durations=durations, begins=True))
        return 1e3 * abs(float(self.plan.phase_start[index + 1]) - wanted)

    def apex(self) -> float:
        """Drag the apex; how far the plan's is from there, mm."""
        handles = handles_of(self.session.state)
        assert handles is not None
        assert handles.apex is not None
        wanted = handles.apex.height + float(self.rng.uniform(-REACH_HEIGHT, REACH_HEIGHT))
        wanted = min(max(wanted, handles.apex.low), handles.apex.high)
        self.answered(lambda: self.tab.page.say(kind="apex", height=wanted, begins=True))
        return 1e3 * abs(first_flight(self.plan).apex - wanted)

    def foothold(self) -> float:
        """Drag where a foot lands; how far it lands from there, mm, horizontally.

        It is dragged from where it landed before: how far balls roll is not counted.
        """
        legs, before = self.plan.schedule.legs, self.plan.foot_position[-1]
        leg, beside = (
            int(self.rng.integers(len(legs))),
            self.rng.uniform(-REACH_FOOT, REACH_FOOT, 2),
        )
        self.grips += 1
        for held in (True, False):
            dragged = FootholdDragged(legs[leg], *beside.tolist(), grip=self.grips, held=held)
            self.answered(lambda dragged=dragged: self.session._inbox.put(dragged))
        wanted = before[leg, :2] + turned(beside, self.plan.jump.twist)
        return 1e3 * float(np.linalg.norm(self.plan.foot_position[-1, leg, :2] - wanted))

    def undo(self) -> None:
        """Go back."""
        self.answered(lambda: self.tab.press("Undo"))

    @property
    def plan(self) -> Any:
        """The one that is shown."""
        assert self.session.state.plan is not None
        return self.session.state.plan


def turned(beside: np.ndarray, angle: float) -> np.ndarray:
    """A displacement as the robot looks that lands, in the world's axes."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ beside


def main() -> bool:
    """Whether something was not obeyed, or not undone."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--edits", type=int, default=20)
    parser.add_argument("--seed", type=int, default=44)
    parser.add_argument("--robot", help="its title in the menu; the page's first by default")
    options = parser.parse_args()
    off: dict[str, list[float]] = {kind: [] for kind in KINDS}
    other = lost = 0
    with closing(Designer(port=0, token="none")) as designer, RawTab(designer.port) as tab:
        tab.wait_for_status(PLANNED, timeout=PATIENCE)
        hand = Hand(tab, designer.sessions[0], np.random.default_rng(options.seed))
        if options.robot is not None:
            hand.answered(lambda: tab.set("Robot", options.robot))
        for number in range(options.edits):
            kind = KINDS[number % len(KINDS)]
            shown = hand.session.state.shown
            amount = getattr(hand, kind)()
            state = hand.session.state
            obeyed = state.shown is not None and state.shown.wanted is None
            if obeyed and state.status.verdict in (Verdict.FEASIBLE, Verdict.DRAFT):
                off[kind].append(amount)
                words = f"{amount:.2f} {'ms' if kind == 'edge' else 'mm'} off"
            else:
                other, words = other + 1, "another jump"
            hand.undo()
            back = hand.session.state.shown
            assert shown is not None
            assert back is not None
            same = all(
                np.array_equal(getattr(back.plan, name), getattr(shown.plan, name))
                for name in ("time", "com", "foot_position", "contact_force", "base_quat")
            )
            lost += not same
            print(f"{kind}: {state.status.verdict.value}, {words}; back: {same}", flush=True)
    for kind, amounts in off.items():
        print(f"{kind}: {len(amounts)}, at most {max(amounts, default=0.0):.2f} off")
    print(f"{other} answered by another jump; {lost} not back to the last bit")
    return lost > 0 or max((max(each, default=0.0) for each in off.values()), default=0.0) > MOST


if __name__ == "__main__":
    sys.exit(main())

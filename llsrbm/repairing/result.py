"""`Repair`: a motion that was repaired, or why it could not be."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple

from llsrbm.certificate import Certificate
from llsrbm.motion.plan import Plan
from llsrbm.repairing.phases import ContactPhase

UNCHANGED, REPAIRED, FAILED = "unchanged", "repaired", "failed"


@dataclass(frozen=True)
class Moved:
    """How far a motion had to move, at the same shares of its phases, in the file's frame.

    Attributes:
        joint_rms_rad: rad, over all joints that turn; base_rms_m: m, of the base's origin.
        landing_m: m, the most that a foot lands beside where it did, horizontally.
        durations_s: by how much each phase lasts longer.
    """

    joint_rms_rad: float
    base_rms_m: float
    landing_m: float
    durations_s: tuple[float, ...]


class Rest(NamedTuple):
    """A stretch of a motion beside the jump that was repaired: from when to when, s, as it is."""

    start_s: float
    end_s: float
    certificate: Certificate


@dataclass(frozen=True, eq=False)
class Repair:
    """A motion and the nearest one whose certificate holds.

    Attributes:
        status: "unchanged", "repaired" or "failed".
        before: the certificate of the motion; of one without forces some checks are not known.
        after: of the plan; None: there is none.
        moved: how far it had to move; None: there is no plan.
        phases: the contact phases of the motion's jump, in its own time.
        plan: that satisfies the whole body's equations, in the project's frame: its origin is under
            the robot as it stands at the start, x where it looks; None: none was found.
        frame_yaw, frame_origin: the project's frame in the file's, rad and m.
        rest: what of the motion is before and after that jump, and was not repaired.
        why: one sentence on what could not be repaired, or on what else there is to know; "".
    """

    status: str
    before: Certificate
    after: Certificate | None = None
    moved: Moved | None = None
    phases: tuple[ContactPhase, ...] = ()
    plan: Plan | None = field(default=None, repr=False)
    frame_yaw: float = 0.0
    frame_origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rest: tuple[Rest, ...] = ()
    why: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The object that `llsrbm repair --json` prints, but for the file's name."""
        return {
            "status": self.status,
            "before": self.before.as_dict(),
            "after": None if self.after is None else self.after.as_dict(),
            "moved": None
            if self.moved is None
            else vars(self.moved) | {"durations_s": list(self.moved.durations_s)},
            "phases": [vars(phase) | {"feet": list(phase.feet)} for phase in self.phases],
            "frame": {"yaw": self.frame_yaw, "origin": list(self.frame_origin)},
            "rest": [
                {
                    "start_s": each.start_s,
                    "end_s": each.end_s,
                    "holds": each.certificate.holds,
                    "certificate": each.certificate.as_dict(),
                }
                for each in self.rest
            ],
            "why": self.why,
        }

"""`Repair`: a jump that was repaired, or why it could not be; `ClipRepair`: all of a clip."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from llsrbm.certificate import Certificate
from llsrbm.motion.plan import Plan
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.repairing.joining import Join
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
            "phases": [phase.as_dict() for phase in self.phases],
            "frame": {"yaw": self.frame_yaw, "origin": list(self.frame_origin)},
            "why": self.why,
        }


@dataclass(frozen=True, eq=False)
class ClipRepair:
    """A whole clip with each of its jumps repaired and joined with the frames beside it.

    Attributes:
        status: "unchanged": as all of its jumps are; "repaired"; "failed": as one of them is at
            least, or there is none.
        before, after: certificates of the clip and of the one that was made of it; None: there is
            none.
        motion: the clip that was made, at the rate of the one before and in its frame; None: no
            jump of it could be repaired.
        jumps: each in order, with `before` of the whole clip.
        plans: start and end, s of the new clip's time, of each jump that is its plan there.
        joins: where the clip's own frames lead over to a plan or back, s of the new clip's time.
        phases: the contact phases of the whole clip before.
        why: a sentence for each jump that stays as it is, or on what else there is to know; "".
    """

    status: str
    before: Certificate
    after: Certificate | None = None
    motion: WholeBodyMotion | None = field(default=None, repr=False)
    jumps: tuple[Repair, ...] = ()
    plans: tuple[tuple[float, float], ...] = ()
    joins: tuple[Join, ...] = ()
    phases: tuple[ContactPhase, ...] = ()
    why: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The object that `llsrbm repair --clip --json` prints, but for the file's name."""
        jumps = [each.as_dict() for each in self.jumps]
        for each in jumps:
            del each["before"]
        return {
            "status": self.status,
            "before": self.before.as_dict(),
            "after": None if self.after is None else self.after.as_dict(),
            "jumps": jumps,
            "plans": [{"start_s": start, "end_s": end} for start, end in self.plans],
            "joins": [each._asdict() for each in self.joins],
            "phases": [phase.as_dict() for phase in self.phases],
            "why": self.why,
        }

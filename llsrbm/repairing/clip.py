"""A whole clip in, the same with each of its jumps made one that can be done out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from llsrbm.certificate import Certificate, certify
from llsrbm.errors import InputError
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.repairing.given_phases import Given, given_phases
from llsrbm.repairing.joining import joined
from llsrbm.repairing.part import NoJump, Part, parts
from llsrbm.repairing.phases import contact_phases
from llsrbm.repairing.repair import RATE, certified_plan, opened, repaired_part, sentence
from llsrbm.repairing.repeated import without_repeated
from llsrbm.repairing.request import Request
from llsrbm.repairing.result import FAILED, REPAIRED, UNCHANGED, ClipRepair, Repair


def repair_clip(
    motion: str | Path | Plan | Rollout | WholeBodyMotion,
    robot: str = "anymal",
    *,
    fps: float | None = None,
    phases: Given | None = None,
    cancelled: Callable[[], bool] | None = None,
    progress: Progress | None = None,
) -> ClipRepair:
    """Repair each jump of a clip, and join the plans with the frames beside them.

    Frames beside a jump stay as they are but for `llsrbm.repairing.joining.LASTS` (0.3 s) next to
    it, where they lead over to the plan's posture. Those after a jump are shifted in time as the
    plan lasts longer or shorter, and go where the plan lands. A jump that could not be repaired, or
    that need not be, stays as it is.

    Args:
        motion: a file of any format that can be opened, a plan, a rollout or a motion, whose frames
            are evenly spaced.
        robot: that moves in another tool's file: its name or its file.
        fps: frames/s of a file that does not say; of a plan or a rollout at which the clip is made
            (None: 100).
        phases: contact phases of the clip, or of a stretch of it, in place of those found: a JSON
            file, or a sequence as of `ClipRepair.phases`.
        cancelled: polled; true: `Cancelled`; progress: told of each step.

    Returns:
        The new clip, a `WholeBodyMotion`, with both certificates and the repair of each jump.

    Raises:
        InputError: a file that cannot be read, a robot that there is not, frames that are not
            evenly spaced, phases that cannot be the clip's.
        Cancelled: `cancelled` was true.
    """
    watch = Watch(cancelled, progress)
    given, before = opened(motion, robot, fps, watch)
    clip = given if isinstance(given, WholeBodyMotion) else whole_body_motion(given, fps or RATE)
    if clip.fps is None:
        raise InputError(
            "the clip's frames are not evenly spaced; expected one rate from its start to its end"
        )
    states = without_repeated(clip)
    own = contact_phases(states) if phases is None else given_phases(phases, clip)
    if isinstance(given, Plan) and given.certified and phases is None:
        alone = (certified_plan(given, before),)
        return ClipRepair(UNCHANGED, before, before, clip, alone, phases=own)
    try:
        found = parts(states, own)
    except NoJump as error:
        return ClipRepair(FAILED, before, phases=own, why=sentence(error))
    jumps = [repaired_part(part, before, watch) for part in found]
    return replace(_joined(clip, before, found, jumps, watch), phases=own)


def _joined(
    clip: WholeBodyMotion,
    before: Certificate,
    found: list[Part],
    repaired: list[tuple[Repair, Request | None]],
    watch: Watch,
) -> ClipRepair:
    jumps = tuple(jump for jump, _ in repaired)
    statuses = {jump.status for jump in jumps}
    result = ClipRepair(
        status=next(one for one in (FAILED, REPAIRED, UNCHANGED) if one in statuses),
        before=before,
        jumps=jumps,
        why=" ".join(_remark(*each) for each in zip(found, jumps, strict=True) if each[1].why),
    )
    plans = [
        (request, jump.plan)
        for jump, request in repaired
        if jump.status == REPAIRED and request is not None and jump.plan is not None
    ]
    if not plans:
        as_it_is = None if statuses == {FAILED} else clip
        return replace(result, motion=as_it_is, after=before if as_it_is else None)
    made = joined(clip, plans)
    watch.begin("checking the clip at 1 kHz")
    after = watch.built(partial(certify, made.motion))
    return replace(result, after=after, motion=made.motion, plans=made.plans, joins=made.joins)


def _remark(part: Part, jump: Repair) -> str:
    """The remark on a jump, which has one, with the jump's time."""
    start, end = part.edges[[0, -1]]
    stays = " stays as it is" if jump.status == FAILED else ""
    return f"The jump from {start:.2f} to {end:.2f} s{stays}: {jump.why[0].lower()}{jump.why[1:]}"

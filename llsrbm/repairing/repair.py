"""A motion in, the nearest one that can be done out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from llsrbm.certificate import Certificate, certify, stated
from llsrbm.errors import InputError
from llsrbm.formats import load_any
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion, motion_of_states, whole_body_motion
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.repairing.moved import moved
from llsrbm.repairing.nearest import nearest
from llsrbm.repairing.part import NoJump, Part, parts
from llsrbm.repairing.phases import ContactPhase, contact_phases
from llsrbm.repairing.request import Request, request_of
from llsrbm.repairing.result import FAILED, REPAIRED, UNCHANGED, Moved, Repair, Rest

RATE = 100.0  # frames/s at which plans and rollouts are taken
# What a motion may move without being called repaired, where no check of it is broken.
SAME_JOINTS, SAME_BASE, SAME_TIME = 0.02, 0.01, 0.02  # rad, m, s
MOMENT = 0.25  # s of what is beside a jump, less than which is not looked at
STRETCHED = 0.05  # of the time that flights take, beyond which it is remarks


def repair(
    motion: str | Path | Plan | Rollout | WholeBodyMotion,
    robot: str = "anymal",
    *,
    fps: float | None = None,
    jump: int = 1,
    cancelled: Callable[[], bool] | None = None,
    progress: Progress | None = None,
) -> Repair:
    """Find the motion nearest to one of any tool's whose certificate holds.

    Its jump is repaired, with those that follow at once: from where the robot is at rest on all
    feet before to where it is after. Where its feet stand is kept, on level ground or boxes.

    Args:
        motion: a file of any format that can be opened, a plan, a rollout or a motion.
        robot: that moves in another tool's file: its name or its file.
        fps: frames/s of a file that does not say.
        jump: which one, of several that are apart from each other.
        cancelled: polled; true: `Cancelled`; progress: told of each step.

    Returns:
        The plan with both certificates and how far it is from the motion; where there is no plan,
        why.

    Raises:
        InputError: a file that cannot be read, a robot or a jump that there is not.
        Cancelled: `cancelled` was true.
    """
    given = load_any(motion, robot, fps) if isinstance(motion, str | Path) else motion
    watch = Watch(cancelled, progress)
    watch.begin("checking the motion at 1 kHz")
    if isinstance(given, Plan) and given.certified:
        before = stated(given)
        assert before is not None
        return Repair(UNCHANGED, before, before, _none(given), _phases_of(given), given)
    before = watch.built(partial(certify, given))
    states = given if isinstance(given, WholeBodyMotion) else whole_body_motion(given, RATE)
    try:
        found = parts(states)
        if not 1 <= jump <= len(found):
            raise InputError(f"jump: expected 1 to {len(found)}, got {jump}")
        request = request_of(found[jump - 1], states.robot)
        plan = nearest(request, states.robot, watch)
    except NoJump as error:
        return Repair(FAILED, before, phases=contact_phases(states), why=_sentence(str(error)))
    return _result(before, request, plan, len(found))


def _result(before: Certificate, request: Request, plan: Plan, jumps: int) -> Repair:
    result = Repair(
        FAILED,
        before,
        rest=tuple(_rest(request.part)),
        phases=request.phases,
        frame_yaw=request.frame.yaw,
        frame_origin=tuple(request.frame.origin.tolist()),
    )
    if not plan.refined:
        return replace(result, why=_not_found(plan))
    after, by = stated(plan), moved(request, plan)
    assert after is not None
    result = replace(result, after=after, moved=by, plan=plan)
    if not plan.certified:
        broken = " and ".join(finding.name.replace("_", " ") for finding in after.broken)
        return replace(
            result, why=f"The nearest motion that was found does not hold its limit of {broken}."
        )
    same = not before.broken and _is_same(by)
    return replace(
        result, status=UNCHANGED if same else REPAIRED, why=_remarks(request.part, jumps)
    )


def _rest(part: Part) -> Iterator[Rest]:
    """The stretches before and after a part that last more than a moment, with certificates."""
    motion, (start, end) = part.motion, part.edges[[0, -1]]
    for own in (motion.time <= start, motion.time >= end):
        time = motion.time[own]
        if len(time) < 2 or time[-1] - time[0] < MOMENT:
            continue
        states = motion.qpos[own], motion.qvel[own]
        alone = motion_of_states(motion.robot, motion.origin, time - time[0], *states, motion.fps)
        yield Rest(float(time[0]), float(time[-1]), certify(alone))


def _is_same(by: Moved) -> bool:
    longest = max(map(abs, by.durations_s))
    return by.joint_rms_rad < SAME_JOINTS and by.base_rms_m < SAME_BASE and longest < SAME_TIME


def _not_found(plan: Plan) -> str:
    """Why no motion was found: the rows that are missed most."""
    missed = max(plan.violations.items(), key=lambda item: item[1].amount, default=None)
    if missed is None:
        return "No motion near it was found."
    name, by = missed
    return (
        f"No motion near it was found that keeps all limits: {name.replace('_', ' ')} is missed "
        f"most, in {by.phase} at {by.time:.2f} s."
    )


def _sentence(reason: str) -> str:
    return f"{reason[0].upper()}{reason[1:]}."


def _remarks(part: Part, jumps: int) -> str:
    """Sentences on what was taken otherwise than the motion has it."""
    remarks = []
    if part.merged:
        remarks.append("Feet that leave or land one after the other do so together in the plan.")
    if abs(part.slower - 1) > STRETCHED:
        remarks.append(
            f"Its flights take {part.slower:.2f} times as long as gravity lets them: it is played "
            "as fast as they would be."
        )
    if jumps > 1:
        remarks.append(
            f"It has {jumps} jumps apart from each other; repaired is the one from "
            f"{part.edges[0]:.2f} to {part.edges[-1]:.2f} s."
        )
    return " ".join(remarks)


def _phases_of(plan: Plan) -> tuple[ContactPhase, ...]:
    edges = plan.phase_start.tolist()
    both = zip(plan.schedule, edges[:-1], edges[1:], strict=True)
    return tuple(ContactPhase(phase.name, phase.feet, start, end) for phase, start, end in both)


def _none(plan: Plan) -> Moved:
    return Moved(0.0, 0.0, 0.0, tuple(0.0 for _ in plan.schedule))

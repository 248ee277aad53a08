"""A motion in, the nearest one that can be done out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from llsrbm.certificate import Certificate, certify, stated
from llsrbm.formats import load_any
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion, whole_body_motion
from llsrbm.planning.solve.watch import Progress, Watch
from llsrbm.repairing.believable import check_amounts, check_states
from llsrbm.repairing.given_phases import Given, given_phases
from llsrbm.repairing.moved import moved
from llsrbm.repairing.nearest import jump_alone, nearest
from llsrbm.repairing.part import NoJump, Part, parts
from llsrbm.repairing.phases import ContactPhase, contact_phases
from llsrbm.repairing.repeated import without_repeated
from llsrbm.repairing.request import Request, request_of
from llsrbm.repairing.result import FAILED, REPAIRED, UNCHANGED, Moved, Repair
from llsrbm.repairing.shares import shares
from llsrbm.request.messages import Whole

RATE = 100.0  # frames/s at which plans and rollouts are taken
# What a motion may move without being called repaired, where no check of it is broken.
SAME_JOINTS, SAME_BASE, SAME_TIME = 0.02, 0.01, 0.02  # rad, m, s
STRETCHED = 0.05  # of the time that flights take, beyond which it is remarks
JUMP_ALONE = (
    "No motion near it was found that keeps all limits: this is the robot's own jump that lands "
    "nearest to where it does."
)


def repair(
    motion: str | Path | Plan | Rollout | WholeBodyMotion,
    robot: str = "anymal",
    *,
    fps: float | None = None,
    jump: int = 1,
    phases: Given | None = None,
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
        phases: contact phases of the motion, or of a stretch of it, in place of those found: a JSON
            file, or a sequence as of `Repair.phases`.
        cancelled: polled; true: `Cancelled`; progress: told of each step.

    Returns:
        The plan with both certificates and how far it is from the motion; where there is no plan,
        why.

    Raises:
        InputError: a file that cannot be read, a robot or a jump that there is not, phases that
            cannot be the motion's.
        Cancelled: `cancelled` was true.
    """
    watch = Watch(cancelled, progress)
    given, before = opened(motion, robot, fps, watch)
    if isinstance(given, Plan) and given.certified and phases is None:
        return certified_plan(given, before)
    states = given if isinstance(given, WholeBodyMotion) else whole_body_motion(given, RATE)
    states = without_repeated(states)
    own = contact_phases(states) if phases is None else given_phases(phases, states)
    try:
        found = parts(states, own)
    except NoJump as error:
        return Repair(FAILED, before, phases=own, why=sentence(error))
    jump = Whole("", low=1, high=len(found)).checked("jump", jump)
    repaired, _ = repaired_part(found[jump - 1], before, watch)
    if repaired.status == FAILED or len(found) == 1:
        return repaired
    return replace(repaired, why=" ".join(filter(None, [repaired.why, _one_of(found, jump)])))


def opened(
    motion: str | Path | Plan | Rollout | WholeBodyMotion,
    robot: str,
    fps: float | None,
    watch: Watch,
) -> tuple[Plan | Rollout | WholeBodyMotion, Certificate]:
    """A motion and its certificate; arguments and errors as of `repair`."""
    given = load_any(motion, robot, fps) if isinstance(motion, str | Path) else motion
    watch.begin("checking the motion at 1 kHz")
    if isinstance(given, Plan) and given.certified:
        before = stated(given)
        assert before is not None
        return given, before
    return given, watch.built(partial(certify, given))


def certified_plan(plan: Plan, before: Certificate) -> Repair:
    """A plan whose certificate holds: it stays as it is."""
    return Repair(UNCHANGED, before, before, _none(plan), _phases_of(plan), plan)


def repaired_part(part: Part, before: Certificate, watch: Watch) -> tuple[Repair, Request | None]:
    """A part of a motion repaired, and its request; None: there is none.

    `before`: of the motion. Raises `Cancelled`.
    """
    robot = part.motion.robot
    try:
        check_states(part, robot)
        whole = request_of(part, robot)
        check_amounts(whole, robot)
        found = []
        for share in shares(whole, robot):
            request = whole if share == 1.0 else request_of(part, robot, share)
            plan = nearest(request, robot, watch)
            found.append((_result(before, request, plan, _remarks(part, share)), request))
            if found[-1][0].status != FAILED:
                return found[-1]
    except NoJump as error:
        return Repair(FAILED, before, phases=part.phases, why=sentence(error)), None
    alone = jump_alone(whole, watch)
    return found[0] if alone is None else (_result(before, whole, alone, JUMP_ALONE), whole)


def _result(before: Certificate, request: Request, plan: Plan, remarks: str) -> Repair:
    result = Repair(
        FAILED,
        before,
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
    return replace(result, status=UNCHANGED if same else REPAIRED, why=remarks)


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


def sentence(reason: NoJump) -> str:
    """Why there is no jump, as a sentence."""
    return f"{str(reason)[0].upper()}{str(reason)[1:]}."


def _remarks(part: Part, share: float) -> str:
    """Sentences on what was taken otherwise than the motion has it."""
    remarks = []
    if share < 1.0:
        remarks.append(f"It leads {share:.0%} of the way and of the turn: more was not found.")
    if any(part.slides):
        remarks.append("Its feet slide as they stand: they are held, on one level.")
    if part.merged:
        remarks.append("Feet that leave or land one after the other do so together in the plan.")
    if abs(part.slower - 1) > STRETCHED:
        remarks.append(
            f"Its flights take {part.slower:.2f} times as long as gravity lets them: it is played "
            "as fast as they would be."
        )
    return " ".join(remarks)


def _one_of(found: list[Part], jump: int) -> str:
    start, end = found[jump - 1].edges[[0, -1]]
    return (
        f"It has {len(found)} jumps apart from each other; repaired is the one from {start:.2f} to "
        f"{end:.2f} s."
    )


def _phases_of(plan: Plan) -> tuple[ContactPhase, ...]:
    edges = plan.phase_start.tolist()
    both = zip(plan.schedule, edges[:-1], edges[1:], strict=True)
    return tuple(ContactPhase(phase.name, phase.feet, start, end) for phase, start, end in both)


def _none(plan: Plan) -> Moved:
    return Moved(0.0, 0.0, 0.0, tuple(0.0 for _ in plan.schedule))

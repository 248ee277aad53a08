"""One jump made in several ways beside each other: its models, arms, drives, replanning."""

from collections.abc import Sequence
from dataclasses import replace

from app.link import ComparisonClosed
from app.motion import colours
from app.motion.baked import bake_plan, bake_rollout
from app.motion.colours import Rgb
from app.panel.acts import Act
from app.plots.choice import compared
from app.tab.acts import Step, joined, on, submit_beside
from app.tab.contenders import By, Comparing, Contender
from app.tab.effects import Effect, Forget, Notify, Play, Queue, Reported, Seek, Stop
from app.tab.shown import Shown
from app.tab.state import TabState
from app.workers import reports, tasks
from llsrbm import models
from llsrbm.analysis.side_by_side import axis_of
from llsrbm.look.titles import title_of_model
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.surroundings import surroundings
from llsrbm.request.design import Design
from llsrbm.request.jump import FREE, HELD
from llsrbm.robots import Robot

WHOLE_BODY = "Whole body"
_OTHERS: tuple[Rgb, ...] = (*colours.PINNED, *colours.COMPONENTS[:1])  # but for the last one


def _is_pushed(state: TabState) -> bool:
    return bool(state.design.scenario.pushes)


def _has_plan(state: TabState) -> bool:
    return state.ready and state.plan is not None and state.plan.solved and not state.planning


@on(Act.COMPARE_MODELS, enabled=lambda state: state.ready)
def compare_models(state: TabState) -> Step:
    """Plan the request with each model, and simulate each plan; the whole body's too, if there."""
    design, jump = state.design, state.design.jump
    ways = [
        (title_of_model(name), replace(design, jump=replace(jump, model=name)))
        for name in models.MODELS
    ]
    plans = [_plan_of(state, way) for _, way in ways]
    plan = state.plan
    if plan is not None and plan.refined and _answers(state, plan, design):
        ways.append((WHOLE_BODY, design))
        plans.append(plan)
    return _begin(state, "models", ways, plans)


@on(Act.COMPARE_ARMS, enabled=lambda state: state.ready, visible=lambda s: bool(s.file.arms))
def compare_arms(state: TabState) -> Step:
    """Plan the request with held and with free arms, and simulate both."""
    design, jump = state.design, state.design.jump
    ways = [
        (f"{arms.capitalize()} arms", replace(design, jump=replace(jump, arms=arms)))
        for arms in (HELD, FREE)
    ]
    return _begin(state, "arms", ways, [_plan_of(state, way) for _, way in ways])


@on(Act.COMPARE_REPLANNING, enabled=_has_plan, visible=_is_pushed)
def compare_replanning(state: TabState) -> Step:
    """Simulate the plan without and with replanning."""
    return _compare_scenarios(
        state,
        "replanning",
        {"Without replanning": {"replan": False}, "With replanning": {"replan": True}},
    )


@on(Act.COMPARE_DRIVES, enabled=_has_plan)
def compare_drives(state: TabState) -> Step:
    """Simulate the plan with ideal drives, and with rotors, friction and delay."""
    return _compare_scenarios(
        state, "drives", {"Ideal drives": {"drives": "ideal"}, "True drives": {"drives": "true"}}
    )


def _compare_scenarios(state: TabState, by: By, changes: dict[str, dict[str, object]]) -> Step:
    design, plan = state.design, state.plan
    if plan is None or not _has_plan(state):
        return state, (Notify("Not compared", "There is no plan yet."),)
    design = replace(design, jump=plan.jump, tuning=plan.tuning)  # the nearest, where it is shown
    ways = [
        (name, replace(design, scenario=design.scenario.but(**change)))
        for name, change in changes.items()
    ]
    return _begin(state, by, ways, [plan] * len(ways))


def _plan_of(state: TabState, design: Design) -> Plan | None:
    """The draft that answers a design, where the tab has it."""
    shown = state.shown
    if shown is None:
        return None
    plan = shown.centroidal or shown.plan
    known = plan.refinement is None and plan.solution is not None and not state.planning
    return plan if known and _answers(state, plan, design) else None


def _answers(state: TabState, plan: Plan, design: Design) -> bool:
    """Whether a plan is of all that a design asks for, and is planned with patience."""
    wanted = state.shown is not None and state.shown.wanted is not None
    same = (plan.jump, plan.tuning) == (design.jump, design.tuning)
    return plan.solved and same and not wanted and not state.planning


# ---- side by side


def _begin(
    state: TabState, by: By, ways: Sequence[tuple[str, Design]], plans: Sequence[Plan | None]
) -> Step:
    tints = (*_OTHERS[: len(ways) - 1], colours.SIMULATED)
    contenders = tuple(
        Contender(name, design, tint, plan, _simulated(state, plan, design))
        for (name, design), tint, plan in zip(ways, tints, plans, strict=True)
    )
    plots = replace(compared(axis_of(state.design.jump)), open=state.plots.open)
    step = go_on(replace(state, comparing=Comparing(by, contenders, plots)))
    return joined((Forget(Queue.COMPARE),) if state.comparing else (), step)


def go_on(state: TabState) -> Step:
    """Try what has not been tried yet, side by side; first what is planned already."""
    comparing, effects = state.comparing, _played(state)
    if comparing is None:
        return state, ()
    untried = [place for place, each in enumerate(comparing.contenders) if not each.done]
    for place in sorted(untried, key=lambda place: comparing.contenders[place].plan is None):
        state, submits = _try(state, comparing.contenders[place], place)
        effects = (*effects, *submits)
    return state, effects


def _try(state: TabState, contender: Contender, place: int) -> Step:
    """Have one of the ways planned, or simulated where it is planned."""
    design, plan = contender.design, contender.plan
    task: tasks.Task = (
        tasks.PlanWay(design.jump, design.tuning)
        if plan is None
        else tasks.FollowWay(plan, design.scenario)
    )
    state, effects = submit_beside(state, Queue.COMPARE, task, place)
    assert state.comparing is not None
    contender = replace(contender, ticket=state.tickets, note="")
    return replace(state, comparing=state.comparing.having(place, contender)), effects


@on(tasks.PlanWay, tasks.FollowWay)
def take_way(state: TabState, event: Reported) -> Step:
    """One of the ways is being tried, or has been."""
    comparing, robot, report = state.comparing, state.robot, event.report
    place = None if comparing is None else comparing.place_of(event.ticket)
    if comparing is None or robot is None or place is None:
        return state, ()
    contender = comparing.contenders[place]
    match report:
        case reports.Progress(waiting=True):
            return state, ()
        case reports.Progress(text=text):
            contender = replace(contender, note=text)
            return replace(state, comparing=comparing.having(place, contender)), ()
        case reports.Planned(plan=plan):
            return _try(state, replace(contender, plan=plan), place)
        case reports.Simulated(rollout=rollout):
            contender = replace(contender, shown=_shown(rollout, robot))
        case reports.Refused(reason=reason):
            contender = replace(contender, why_not=reason)
        case reports.Failed(message=message):
            contender = replace(contender, why_not=message)
        case _:  # it was stopped
            return _closed(state), ()
    comparing = comparing.having(place, replace(contender, ticket=0, note=""))
    state = replace(state, comparing=comparing)
    return state, _played(state) if contender.shown or comparing.done else ()


def _played(state: TabState) -> tuple[Effect, ...]:
    """The first of the motions plays at once; all of them from the start, once they are there."""
    comparing = state.comparing
    if comparing is None or not comparing.present:
        return ()
    return (Seek(0.0), Play()) if comparing.done or len(comparing.present) == 1 else ()


def _simulated(state: TabState, plan: Plan | None, design: Design) -> Shown | None:
    """The motion that is shown, if it is a simulation of that plan in the design's scenario."""
    shown = state.shown
    if shown is None or shown.simulated is None or shown.source or shown.plan is not plan:
        return None
    return shown if shown.scenario == design.scenario else None


def _shown(rollout: Rollout, robot: Robot) -> Shown:
    plan = rollout.plan
    return Shown(
        bake_plan(plan, robot),
        bake_rollout(rollout),
        rollout.scenario,
        blocks=surroundings(robot, plan, rollout.scenario).blocks,
    )


@on(ComparisonClosed)
def close(state: TabState, _: ComparisonClosed) -> Step:
    """Back to the motion that is shown, or from a motion of a file, which stays pinned."""
    if state.comparing is not None:
        return _closed(state), ()
    stop = (Stop(Queue.MOTION),) if state.repairing else ()
    return replace(state, foreign=None), stop


def _closed(state: TabState) -> TabState:
    return replace(state, comparing=None)

"""One jump made in several ways beside each other: its models, arms, drives, replanning."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from app.link import ComparisonClosed
from app.motion import colours
from app.motion.baked import bake_plan, bake_rollout
from app.motion.colours import Rgb
from app.panel.acts import Act
from app.panel.jump_controls import title_of_model
from app.plots.choice import compared
from app.tab.acts import Step, on, submit_beside
from app.tab.contenders import By, Comparing, Contender
from app.tab.effects import Notify, Play, Queue, Reported, Seek, Stop
from app.tab.shown import Shown
from app.tab.state import TabState
from app.workers import reports, tasks
from llsrbm import models
from llsrbm.analysis.side_by_side import axis_of
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
        for name in models.names()
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


# ---- one after the other


def _begin(
    state: TabState, by: By, ways: Sequence[tuple[str, Design]], plans: Sequence[Plan | None]
) -> Step:
    tints = (*_OTHERS[: len(ways) - 1], colours.SIMULATED)
    contenders = tuple(
        Contender(name, design, tint, plan)
        for (name, design), tint, plan in zip(ways, tints, plans, strict=True)
    )
    plots = replace(compared(axis_of(state.design.jump)), open=state.plots.open)
    return go_on(replace(state, comparing=Comparing(by, contenders, plots)))


def go_on(state: TabState) -> Step:
    """Try what has not been tried yet; play all of it at the end."""
    comparing = state.comparing
    if comparing is None:
        return state, ()
    contender = comparing.following
    if contender is None:
        return state, (Seek(0.0), Play()) if comparing.present else ()
    design = contender.design
    task = tasks.TryWay(design.jump, design.tuning, design.scenario, contender.plan)
    state, effects = submit_beside(state, Queue.COMPARE, task)
    return replace(state, comparing=replace(comparing, ticket=state.tickets, note="")), effects


@on(tasks.TryWay)
def take_way(state: TabState, event: Reported) -> Step:
    """One of the ways is being tried, or has been."""
    comparing, robot, report = state.comparing, state.robot, event.report
    if comparing is None or robot is None or event.ticket != comparing.ticket:
        return state, ()
    contender = comparing.following
    assert contender is not None
    match report:
        case reports.Progress(text=text):
            return replace(state, comparing=replace(comparing, note=text)), ()
        case reports.Simulated(rollout=rollout):
            contender = replace(contender, shown=_shown(rollout, robot))
        case reports.Refused(reason=reason):
            contender = replace(contender, why_not=reason)
        case reports.Failed(message=message):
            contender = replace(contender, why_not=message)
        case _:  # it was stopped
            return _closed(state), ()
    return go_on(replace(state, comparing=comparing.with_tried(contender)))


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
    """Back to the motion that is shown."""
    return _closed(state), (Stop(Queue.COMPARE),)


def _closed(state: TabState) -> TabState:
    return replace(state, comparing=None)

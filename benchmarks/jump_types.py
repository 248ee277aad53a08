"""Figures of the jump types: reach, strict landings and a look at published jumps.

    python -m benchmarks.jump_types score --seeds 1000:1020
    python -m benchmarks.jump_types score --names flip --robots go2 --estimator imu
    python -m benchmarks.jump_types reach --robots anymal,go2
    python -m benchmarks.jump_types public
    python -m benchmarks.jump_types tuck

`score` simulates each type's jumps once a seed with everything disturbed that
`llsrbm.simulation.disturbance` disturbs; `reach` looks for the longest forward jump that is strict
in most seeds, pushing off together and with the hind feet last, with the same drives; `public`
puts Go2's rear-last jumps beside the public planar jumps of the A1; `tuck` compares back flips
planned with different models of the inertia. Strict success is defined in
`llsrbm.simulation.verdict`. Tables are in Markdown.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, NamedTuple

import numpy as np
import typer

import llsrbm
from benchmarks.counting import count, seeds_of
from benchmarks.realised import realise
from llsrbm.commands import options
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.outcome import FEET_WITHIN, PEAK_TILT, Outcome
from llsrbm.motion.plan import Plan
from llsrbm.planning.answer.planner import Planner, planner_of
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import load_robot
from llsrbm.robots.drives.variants import with_drives
from llsrbm.simulation.simulate import simulate

app = typer.Typer(help=__doc__, add_completion=False)

WIDE = 1.5  # m: further than any jump here gets, in place of the robot file's own range
STRICT = 0.9  # of the seeds, for a distance to count as reached
FIRST_SEEDS, FIRST_SHARE = (
    6,
    0.8,
)  # that are spent on a distance while searching, all but one strict
STEP, COARSE = 0.01, 0.05  # m: of the bisection, and of the search for where planning ends
LONGEST = 0.8  # m: of the public jumps

Seeds = Annotated[str, typer.Option(help="First:last+1.")]
SEEDS = "1000:1020"


class Case(NamedTuple):
    """A row of the table of scores."""

    name: str
    type: str
    robots: tuple[str, ...]
    forward: float
    hops: int = 1
    speed: float = 0.0
    pitch: float = 0.0
    height: float = 0.0


QUADRUPEDS = ("anymal", "go2")
FLIPPING = ("go2", "go1", "a1")
CASES = (
    Case("two hops of 20 cm", "hops", (*QUADRUPEDS, "slider"), 0.2, hops=2),
    Case("run-up 0.5 m/s, 30 cm", "run-up", QUADRUPEDS, 0.3, speed=0.5),
    Case("rear last 50 cm", "rear-last", QUADRUPEDS, 0.5),
    Case("hurdle 50 cm", "hurdle", ("anymal",), 0.5),
    Case("hurdle 45 cm", "hurdle", ("go2",), 0.45),
    Case("hurdle 40 cm", "hurdle", ("go2",), 0.4),
    Case("gap 50 cm", "gap", ("anymal",), 0.5),
    Case("gap 45 cm", "gap", ("go2",), 0.45),
    Case("one side first 10 cm", "one-foot-first", ("slider",), 0.1),
    Case("one side first on the spot", "one-foot-first", ("slider",), 0.0),
    Case("front flip on the spot", "flip", FLIPPING, 0.0, pitch=math.tau),
    Case("back flip on the spot", "flip", FLIPPING, 0.0, pitch=-math.tau),
    *(
        Case(f"{name} flip off {below} cm", "flip", ("go2",), 0.0, pitch=turn, height=-below / 100)
        for name, turn in (("front", math.tau), ("back", -math.tau))
        for below in (30, 40, 50)
    ),
)


def simulated(
    plan: Plan, seeds: range, estimator: str = "truth", regeneration: float | None = None
) -> list[Outcome]:
    robot = with_drives(load_robot(plan.jump.robot), regeneration=regeneration)
    scenarios = [Scenario(seed=seed, estimator=estimator) for seed in seeds]
    return [simulate(plan, robot, scenario).outcome for scenario in scenarios]


def failures(outcomes: list[Outcome]) -> str:
    """Why seeds were not strict, each reason once with its number."""
    reasons = [
        outcome.reason
        or (f"foot {1e3 * outcome.foot_error:.0f} mm off" * (outcome.foot_error >= FEET_WITHIN))
        or (f"tilt {outcome.peak_tilt:.2f} rad" * bool(outcome.peak_tilt >= PEAK_TILT))
        or ("links touched" * bool(outcome.touched))
        or (f"in the air again {1e3 * outcome.second_flight_s:.0f} ms")
        for outcome in outcomes
        if not outcome.strict
    ]
    return "; ".join(f"{reasons.count(reason)} x {reason}" for reason in dict.fromkeys(reasons))


@app.command()
def score(
    seeds: Seeds = SEEDS,
    names: Annotated[str, typer.Option(help="Part of the cases' names; all if empty.")] = "",
    robots: str = "anymal,go2,slider",
    model: str = "llsrbm-plus",
    estimator: str = "truth",
    regeneration: Annotated[
        float | None, typer.Option(help="W that a drive takes back at most; none: any.")
    ] = None,
) -> None:
    """How many seeds land strictly, a type and a robot."""
    print("| jump | robot | planned | strict | stand | not strict |\n|---|---|---|---|---|---|")
    for case in CASES:
        for robot in case.robots:
            if names not in case.name or robot not in robots.split(","):
                continue
            jump = llsrbm.Jump(
                robot,
                model,
                forward=case.forward,
                type=case.type,
                hops=case.hops,
                speed=case.speed,
                pitch=case.pitch,
                height=case.height,
            )
            cells = judged(jump, seeds_of(seeds), estimator, regeneration)
            print(f"| {case.name} | {robot} | {cells} |", flush=True)


def judged(jump: llsrbm.Jump, seeds: range, estimator: str, regeneration: float | None) -> str:
    """The cells of one jump."""
    try:
        plan = llsrbm.plan(jump)
    except llsrbm.NotConverged as error:
        return f"no: {error} | | | "
    outcomes = simulated(plan, seeds, estimator, regeneration)
    counts = count(outcomes)
    made = plan.refinement if plan.refined else plan.report
    kind = "certified" if plan.certified else "draft"
    return (
        f"{kind}, {made.iterations} iterations, {made.solve_time_s:.1f} s | "
        f"{counts.strict}/{counts.requests} | {counts.stand} | {failures(outcomes)}"
    )


@app.command()
def reach(
    robots: str = "anymal,go2",
    types: str = "together,rear-last",
    seeds: Seeds = SEEDS,
    down: Annotated[float, typer.Option(help="Between distances that are simulated, m.")] = 0.03,
    limit: options.Limits = None,
    model: str = "llsrbm-plus",
) -> None:
    """The longest forward jump that is strict in most seeds, and the longest that can be planned.

    The robot file's range of requests is widened for it; the drives are as they are. Limits that
    are given hold for all types.
    """
    limits = options.requested_tuning(Tuning(), None, limit).limits
    print("| robot | type | plans up to | strict up to | further |")
    print("|---|---|---|---|---|", flush=True)
    for robot in robots.split(","):
        for kind in types.split(","):
            plans = planned_further(llsrbm.Jump(robot, model, forward=0.3, type=kind), limits)
            longest = longest_strict(plans, seeds_of(seeds), down, limits)
            print(f"| {robot} | {kind} | {plans[-1].jump.forward:.2f} m | {longest} |", flush=True)


def longest_strict(
    plans: list[Plan], seeds: range, down: float, limits: Mapping[str, float]
) -> str:
    """The cells of the longest distance that is strict in most seeds, and of the next further one.

    From the furthest plan down: a shorter jump is not always the safer one. Few seeds first.
    """
    beyond, forward = "", plans[-1].jump.forward
    while forward >= plans[0].jump.forward:
        near = min(plans, key=lambda plan: abs(plan.jump.forward - forward))
        jump = replace(near.jump, forward=round(forward, 2))
        plan = planner_of(jump).plan(jump, near=near, limits=limits)
        for part, share in ((seeds[:FIRST_SEEDS], FIRST_SHARE), (seeds, STRICT)):
            outcomes = simulated(plan, part)
            counts = count(outcomes)
            found = f"{forward:.2f} m: {counts.strict}/{counts.requests}"
            typer.echo(f"{jump.robot} {jump.type} {found}", err=True)
            if counts.strict < share * counts.requests:
                beyond = f"{found}, {failures(outcomes)}"
                break
        else:
            return f"{found} | {beyond}"
        forward -= down
    return f"none | {beyond}"


def widened(jump: llsrbm.Jump) -> Planner:
    """The planner of a jump, for requests beyond the robot file's range.

    The range is a check of requests; neither solver nor limits depend on it.
    """
    planner = planner_of(jump)
    robot = planner.robot
    task = robot.file.task.model_copy(update={"forward": (-WIDE, WIDE)})
    robot = replace(robot, file=robot.file.model_copy(update={"task": task}))
    planner.formulation = replace(planner.formulation, robot=robot)
    return planner


def planned_further(jump: llsrbm.Jump, limits: Mapping[str, float] | None = None) -> list[Plan]:
    """Plans ever further, each begun from the one before, up to the last that is found.

    In steps of `COARSE`, and from there by bisection to `STEP`.
    """
    planner = widened(jump)
    found = [planner.plan(jump, limits=limits)]

    def plans(forward: float) -> bool:
        try:
            further = replace(jump, forward=round(forward, 2))
            found.append(planner.plan(further, near=found[-1], patient=False, limits=limits))
        except llsrbm.NotConverged:
            return False
        return True

    while plans(found[-1].jump.forward + COARSE):
        pass
    beyond = found[-1].jump.forward + COARSE
    while beyond - found[-1].jump.forward > 1.5 * STEP:
        middle = STEP * round((beyond + found[-1].jump.forward) / 2 / STEP)
        if not plans(middle):
            beyond = middle
    return found


@app.command()
def public(model: str = "llsrbm-plus", robot: str = "go2") -> None:
    """A robot's rear-last jumps beside the public planar jumps of the A1.

    Those: 0.3 to 0.8 m, front feet off at 0.494 s, hind feet at 0.796 s, end at 1.2 s, apex of the
    base 0.354 to 0.379 m above the start.
    """
    print("| jump | phases | front off | hind off | lands | end | apex of the base |")
    print("|---|---|---|---|---|---|---|")
    print(
        "| public, A1, 0.3 to 0.8 m | all feet, hind feet, flight | 0.494 s | 0.796 s "
        "| 1.2 s: its end | 1.2 s | 0.354 to 0.379 m |"
    )
    for plan in planned_further(llsrbm.Jump(robot, model, forward=0.3, type="rear-last")):
        tenth = round(plan.jump.forward, 1)
        if abs(plan.jump.forward - tenth) < 1e-6 and tenth <= LONGEST:
            print(published_row(plan), flush=True)


def published_row(plan: Plan) -> str:
    schedule, starts = plan.schedule, plan.phase_start
    front, hind = (
        starts[next(p for p in range(1, len(schedule)) if schedule.lifts(p)[leg])]
        for leg in (0, len(schedule.legs) - 1)
    )
    apex = float((plan.base_position[:, 2] - plan.base_position[0, 2]).max())
    return (
        f"| {plan.jump.robot}, {plan.jump.forward:.1f} m "
        f"| {', '.join(map(schedule.standing_words, range(len(schedule))))} "
        f"| {front:.3f} s | {hind:.3f} s | {plan.touchdown:.3f} s | {plan.duration:.3f} s "
        f"| {apex:.3f} m |"
    )


@app.command()
def tuck(robot: str = "go2", models: str = "llsrbm-plus,srbm") -> None:
    """The back flip as models plan it whose inertia changes with the legs, or does not.

    Inertia about the body's lateral axis, in the middles of the intervals of flight: of the model,
    and of the whole body in the plan's postures. Angular momentum about that axis at lift-off, as
    planned. Turn that the whole body would be ahead of the plan at touchdown, with that momentum.
    """
    heads = (
        *("model", "flight", "angular momentum at lift-off", "least inertia"),
        *("of the whole body, first and least", "fastest turn", "apex of the CoM"),
        "whole body ahead by",
    )
    print(f"| {' | '.join(heads)} |\n{'|---' * len(heads)}|")
    for model in models.split(","):
        jump = llsrbm.Jump(robot, model, type="flip", pitch=-math.tau)
        planner = planner_of(jump)
        try:
            plan = planner.plan(jump)
        except llsrbm.NotConverged as error:
            print(f"| {model} | no: {error} |" + " |" * (len(heads) - 2))
            continue
        (flight,) = plan.schedule.flights
        knots = np.flatnonzero(plan.phase == flight)
        lateral = rotation_matrices(plan.base_quat)[knots[0], :, 1]
        momentum = abs(lateral @ plan.angular_momentum[knots[0]])
        rate = np.linalg.norm(plan.angular_velocity[knots], axis=1).max()
        body = realise(planner.last_knots())
        modelled, true = (
            each[body.flight, 1] for each in (body.inertias_model, body.inertias_true)
        )
        ahead = math.degrees(math.copysign(1.0, jump.pitch) * body.turn_error[1])
        print(
            f"| `{model}` | {np.diff(plan.phase_start)[flight]:.3f} s | {momentum:.2f} kg m2/s "
            f"| {modelled.min():.3f} kg m2 | {true[0]:.3f}, {true.min():.3f} kg m2 "
            f"| {rate:.1f} rad/s | {plan.com[:, 2].max() - plan.com[0, 2]:.3f} m "
            f"| {ahead:+.1f} deg |",
            flush=True,
        )


if __name__ == "__main__":
    app()

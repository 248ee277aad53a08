"""ANYmal's 90 deg twist: with inertia shaping the base turns on in flight."""

import math
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

import llsrbm
from benchmarks.model_truth import YAW_HEADING, yaw_cells
from benchmarks.paper.drawing import COLOURS, STYLE, TITLE, axes, phases, snapshots
from benchmarks.paper.result import AGREES, NOT, PARTLY, Result, Table
from llsrbm.mechanics import yaw
from llsrbm.robots import load_robot
from llsrbm.simulation.simulate import simulate

TWIST = math.radians(90)
MODELS = ("llsrbm-plus", "llsrbm", "srbm")
ARRIVED = 0.95  # share of the twist
SEEDS = range(6000, 6020)


class Figures(NamedTuple):
    """Figures of a simulated twist, or their medians."""

    kept: float  # share of the yaw rate
    arrived: float  # s, when the yaw is reached
    gained: float  # rad, the yaw's error in flight
    near: float  # m, the feet from the axis
    inertia: float  # kg m2, the smallest Izz


def result(folder: Path) -> Result:
    plans = {
        m: llsrbm.plan(llsrbm.Jump(robot="anymal", model=m, twist=TWIST), draft=True)
        for m in MODELS
    }
    rollouts = {m: llsrbm.simulate(plan) for m, plan in plans.items()}
    figures = [
        (
            "twist_curves.png",
            "Simulated, full lines LL-SRBM+, dashed SRBM; dotted: lift-off, touchdown",
        ),
        ("twist_snapshots.png", "Above LL-SRBM+, below SRBM"),
    ]
    _curves(rollouts, folder / figures[0][0])
    shown = [(TITLE[m], rollouts[m]) for m in ("llsrbm-plus", "srbm")]
    snapshots(shown, (0.1, 0.19, 0.25, 0.32, 0.5), folder / figures[1][0])
    rows, medians = [], {}
    for model in MODELS:
        runs = [llsrbm.simulate(plans[model], llsrbm.Scenario(seed=seed)) for seed in SEEDS]
        columns = zip(*map(_figures, runs), strict=True)
        medians[model] = median = Figures(*(float(np.median(column)) for column in columns))
        strict = sum(run.outcome.strict for run in runs)
        rows.append(
            [
                TITLE[model],
                f"{100 * median.kept:.0f} %",
                f"{median.arrived:.3f} s",
                f"{median.near:.3f} m",
                f"{median.inertia:.2f}",
                f"{strict} of {len(runs)}",
            ]
        )
    heading = ("model", "yaw rate kept in flight", "95 % of the yaw",
               "feet from the axis", "least Izz [kg m²]", "strict")  # fmt: skip
    return Result(
        "ANYmal, 90° twist",
        "with LL-SRBM the feet keep close to the axis in flight, the base's angular velocity drops "
        "less than with SRBM, and the goal is reached earlier.",
        [
            Table(heading, rows),
            Table(
                ("yaw − plan [°]", *YAW_HEADING),
                [[TITLE[m], *yaw_cells(plans[m], SEEDS)] for m in MODELS],
            ),
        ],
        figures,
        _verdict(medians),
        _reason(plans, medians),
    )


def _verdict(medians: dict[str, Figures]) -> str:
    plus, ll, srbm = (medians[model] for model in MODELS)
    better = ll.kept > srbm.kept and plus.kept > srbm.kept
    earlier = ll.arrived < srbm.arrived
    most = plus.arrived < srbm.arrived
    short = all(abs(other.gained) > 2 * abs(plus.gained) for other in (ll, srbm))
    return AGREES if better and earlier and most else PARTLY if better and short else NOT


def _reason(plans: dict[str, llsrbm.Plan], medians: dict[str, Figures]) -> str:
    held = [math.degrees(_attitude_held(plan)) for plan in plans.values()]
    of = [medians[model] for model in MODELS]
    arrived = [median.arrived for median in of]
    return (
        f"With {_listed([TITLE[m] for m in MODELS])} the feet come within "
        f"{_listed([f'{median.near:.3f}' for median in of])} m of the axis, and the base keeps "
        f"{_listed([f'{100 * median.kept:.0f}' for median in of])} % of its yaw rate at lift-off. "
        f"The goal is reached at {_listed([f'{time:.3f}' for time in arrived])} s, at most "
        f"{1e3 * (max(arrived) - min(arrived)):.0f} ms apart. In flight the base turns by "
        f"{_listed([f'{math.degrees(median.gained):+.1f}' for median in of])}° more than planned: "
        "the paper's SRBM turns less than planned, and so do SRBM and LL-SRBM here, of which "
        "neither has the legs' own momentum. At touchdown little of it is seen. The controller "
        "holds the angular momentum in take-off, not the base's attitude; standing feet keep the "
        "legs back, so that for the planned momentum the base has to turn faster than a plan "
        "without them has it. It leaves the ground ahead of its plan, by what it then loses in "
        "flight. A controller that holds the attitude in take-off instead is off by "
        f"{_listed([f'{error:+.1f}' for error in held])}° at the planned touchdown, undisturbed."
    )


def _attitude_held(plan: llsrbm.Plan) -> float:
    """Yaw (rad) from the plan at its touchdown under a controller that holds attitude in take-off.

    In the place of the angular momentum, which follows from the plan's by the model alone.
    """
    robot = load_robot(plan.jump.robot)
    weights = {"orientation_in_takeoff": 1000.0, "angular_momentum_in_takeoff": 1.0}
    control = robot.file.control
    control = control.model_copy(update={"weights": control.weights.model_copy(update=weights)})
    holding = replace(robot, file=robot.file.model_copy(update={"control": control}))
    error = simulate(plan, holding, llsrbm.Scenario()).outcome.yaw_error_at_planned_touchdown
    return math.nan if error is None else error


def _listed(words: list[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}"


def _figures(rollout: llsrbm.Rollout) -> Figures:
    heading = np.abs(yaw(rollout.base_quat))
    rate = np.gradient(heading, rollout.time)
    in_air = ~rollout.contact.any(axis=1)
    flying = np.flatnonzero(in_air)
    first, last = flying[0], flying[-1]
    inside = slice(first + 8, last - 4)
    reached = np.flatnonzero(heading >= ARRIVED * TWIST)
    radius = np.linalg.norm((rollout.foot_position - rollout.com[:, None])[..., :2], axis=-1)
    error = rollout.outcome.yaw_error_in_flight
    return Figures(
        float(rate[inside].min() / rate[first]),
        float(rollout.time[reached[0]]) if len(reached) else math.nan,
        math.nan if error is None else error,
        float(radius[inside].mean(axis=1).min()),
        float(rollout.inertia[inside, 2, 2].min()),
    )


def _curves(rollouts: dict[str, llsrbm.Rollout], path: Path) -> None:
    figure, (top, rate, momentum, inertia) = axes(2, 2)
    for model in ("llsrbm-plus", "srbm"):
        rollout, style = rollouts[model], STYLE[model]
        heading, name = yaw(rollout.base_quat), TITLE[model]
        top.plot(rollout.time, np.degrees(heading), style, color="tab:blue", label=name)
        turning = np.gradient(heading, rollout.time)
        rate.plot(rollout.time, turning, style, color="tab:blue", label=name)
        for axis, colour in enumerate(COLOURS):
            label = f"{'xyz'[axis]}, {name}"
            values = rollout.angular_momentum[:, axis]
            momentum.plot(rollout.time, values, style, color=colour, label=label)
            values = rollout.inertia[:, axis, axis]
            inertia.plot(rollout.time, values, style, color=colour, label=label)
    for ax, label in (
        (top, "yaw of the base [deg]"),
        (rate, "yaw rate of the base [rad/s]"),
        (momentum, "angular momentum [kg m²/s]"),
        (inertia, "centroidal inertia [kg m²]"),
    ):
        outcome = rollouts["llsrbm-plus"].outcome
        in_air = ~rollouts["llsrbm-plus"].contact.any(axis=1)
        lift_off = float(rollouts["llsrbm-plus"].time[np.argmax(in_air)])
        phases(ax, lift_off, outcome.touchdown_true_s or math.nan)
        ax.set_ylabel(label)
        ax.legend()
    figure.savefig(path, dpi=140)

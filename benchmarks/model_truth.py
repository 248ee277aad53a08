"""The plan of each model against the motion of the whole robot, in flight, by Pinocchio.

python benchmarks/model_truth.py [--robot anymal] [--twist 90] [--forward 0] [--type together ...]
    [--seeds 7000:7020]

Errors are RMS over all flights: of the diagonal inertias (Ixx, Iyy, Izz) shares of the true values,
of the angular momentum's components shares of the peak of |L| over the plan. Without a twist or a
turn that peak is the little that legs and trunk leave of each other, so that the error is also
given as it is, with what it turns the base by over all flights.

With `--seeds` a second table follows: the yaw of the simulated base minus the plan's, undisturbed;
then the median and range of seeds that disturb it. Beside it is what the model's error makes of it
(`llsrbm.analysis.model_turn`).
"""

import argparse
import math

import numpy as np

import llsrbm
from benchmarks.counting import seeds_of
from benchmarks.realised import realise
from llsrbm import models
from llsrbm.analysis.model_turn import model_turn
from llsrbm.planning.answer.planner import planner_of
from llsrbm.request import jump_types
from llsrbm.request.jump import PLAIN
from llsrbm.request.jump_types import with_defaults


def main() -> None:
    """Print a line a type and model."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="anymal")
    parser.add_argument("--twist", type=float, default=90.0, help="deg")
    parser.add_argument("--forward", type=float, default=0.0, help="m")
    parser.add_argument(
        "--type",
        nargs="+",
        default=[PLAIN],
        help=f'jump types, or "all": {", ".join(jump_types.names())}',
    )
    parser.add_argument("--model", nargs="+", default=[*models.MODELS], choices=[*models.MODELS])
    parser.add_argument("--seeds", type=seeds_of, help="to simulate with: first:last+1")
    arguments = parser.parse_args()
    types = list(jump_types.names()) if arguments.type == ["all"] else arguments.type
    jumps = [
        with_defaults(
            llsrbm.Jump(
                arguments.robot,
                model,
                math.radians(arguments.twist),
                arguments.forward,
                type=name,
            )
        )
        for name in types
        for model in arguments.model
    ]
    print(
        "| type | model | Ixx | Iyy | Izz | Lx | Ly | Lz | Lz largest | peak of L | worst error | "
        "turn error | feet radius | peak yaw rate | joint speed |"
    )
    print("|---" * 15 + "|")
    for jump in jumps:
        print(row(jump), flush=True)
    if arguments.seeds:
        print(f"\n| type | model | {' | '.join(YAW_HEADING)} |")
        print("|---" * (2 + len(YAW_HEADING)) + "|")
        for jump in jumps:
            cells = " | ".join(yaw_cells(llsrbm.plan(jump, draft=True), arguments.seeds))
            print(f"| {jump.type} | {jump.model} | {cells} |", flush=True)


def row(jump) -> str:
    try:
        planner = planner_of(jump)
        plan = planner.plan(jump)
    except llsrbm.Error as error:
        return f"| {jump.type} | {jump.model} | {error} |"
    truth = realise(planner.last_knots())
    flying = ~plan.contact.any(axis=1)
    feet = plan.foot_position[flying][..., :2]
    radius = np.linalg.norm(feet - plan.com[flying][:, None, :2], axis=-1).mean(axis=1)
    error = (truth.momenta_true - truth.momenta_plan)[truth.flight]
    worst = np.sqrt(np.mean(error**2, axis=0)).max()
    largest = np.abs(error[:, 2]).max() / np.abs(truth.momenta_plan[:, 2]).max()
    shares = [*truth.inertia_errors, *truth.momentum_errors, largest]
    figures = [f"{share:.1%}" for share in shares]
    figures += [
        f"{np.linalg.norm(truth.momenta_plan, axis=1).max():.2f} kg m2/s",
        f"{worst:.3f} kg m2/s",
        f"{np.degrees(np.linalg.norm(truth.turn_error)):.2f} deg",
        f"{radius.min():.3f} m",
        f"{np.abs(plan.angular_velocity[:, 2]).max():.2f} rad/s",
        f"{np.abs(truth.joint_speed).max():.1f} rad/s",
    ]
    return f"| {jump.type} | {jump.model} | {' | '.join(figures)} |"


YAW_HEADING = (
    *("model, until lift-off", "model, in flight", "at lift-off", "gained in flight"),
    *("at the planned touchdown", "at first contact"),
)
_MEASURED = (
    *("yaw_error_at_lift_off", "yaw_error_in_flight"),
    *("yaw_error_at_planned_touchdown", "yaw_error_at_touchdown"),
)


def yaw_cells(plan: llsrbm.Plan, seeds: range) -> list[str]:
    """Yaw - plan, deg: by the model's error; simulated, undisturbed and the median of seeds."""
    promise = model_turn(plan)
    promised = [math.nan] * 2 if promise is None else [promise.takeoff, promise.flight]
    scenarios = [llsrbm.Scenario(), *(llsrbm.Scenario(seed=seed) for seed in seeds)]
    outcomes = [llsrbm.simulate(plan, scenario).outcome for scenario in scenarios]
    cells = [f"{math.degrees(error):+.1f}" for error in promised]
    for name in _MEASURED:
        values = [getattr(outcome, name) for outcome in outcomes]
        alone, *errors = np.degrees([math.nan if v is None else v for v in values])
        spread = f"{np.nanmin(errors):+.1f} to {np.nanmax(errors):+.1f}"
        cells.append(f"{alone:+.1f}; {np.nanmedian(errors):+.1f} ({spread})")
    return cells


if __name__ == "__main__":
    main()

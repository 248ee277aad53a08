"""The plan of each model against the motion of the whole robot, in flight, by Pinocchio.

python benchmarks/model_truth.py [--robot anymal] [--twist 90] [--forward 0] [--type together ...]

Errors are RMS over all flights: of the diagonal inertias (Ixx, Iyy, Izz) shares of the true values,
of the angular momentum's components shares of the peak of |L| over the plan. Without a twist or a
turn that peak is the little that legs and trunk leave of each other, so that the error is also
given as it is, with what it turns the base by over all flights.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

import llsrbm
from benchmarks.realised import realise
from llsrbm import models
from llsrbm.planning.solve.planner import planner_of
from llsrbm.request import jump_types
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
        default=[jump_types.DEFAULT],
        help=f'jump types, or "all": {", ".join(jump_types.names())}',
    )
    parser.add_argument("--model", nargs="+", default=models.names(), choices=models.names())
    arguments = parser.parse_args()
    types = list(jump_types.names()) if arguments.type == ["all"] else arguments.type
    print(
        "| type | model | Ixx | Iyy | Izz | Lx | Ly | Lz | Lz largest | peak of L | worst error | "
        "turn error | feet radius | peak yaw rate | joint speed |"
    )
    print("|---" * 15 + "|")
    for name in types:
        for model in arguments.model:
            jump = llsrbm.Jump(
                arguments.robot,
                model,
                math.radians(arguments.twist),
                arguments.forward,
                type=name,
            )
            print(row(with_defaults(jump)), flush=True)


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
    shares = [*truth.inertia_errors, *truth.momentum_errors, truth.momentum_error[1]]
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


if __name__ == "__main__":
    main()

"""What each model plans against what the whole robot does with it, on the 90 degree twist.

python benchmarks/model_truth.py [--robot anymal] [--twist 90]
"""

from __future__ import annotations

import argparse
import math

import numpy as np

import llsrbm
from llsrbm import models
from llsrbm.analysis.realised import realise
from llsrbm.planning.planner import planner_for
from llsrbm.robots import load_robot


def main() -> None:
    """Print a line a model."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="anymal")
    parser.add_argument("--twist", type=float, default=90.0)
    parser.add_argument("--forward", type=float, default=0.0)
    arguments = parser.parse_args()
    robot = load_robot(arguments.robot)
    print("| model | Izz RMS | Lz RMS | Lz largest | feet radius | peak yaw rate | joint speed |")
    print("|---|---|---|---|---|---|---|")
    for model in models.names():
        jump = llsrbm.Jump(arguments.robot, model, math.radians(arguments.twist), arguments.forward)
        planner = planner_for(arguments.robot, model)
        plan = planner.plan(jump)
        truth = realise(planner.last_knots(), robot)
        feet = plan.foot_position[plan.phase == 1][..., :2]
        radius = np.linalg.norm(feet - plan.com[plan.phase == 1][:, None, :2], axis=-1).mean(axis=1)
        rms, worst = truth.momentum_error
        print(
            f"| {model} | {truth.inertia_error:.1%} | {rms:.1%} | {worst:.1%} | "
            f"{radius.min():.3f} m | {np.abs(plan.angular_velocity[:, 2]).max():.2f} rad/s | "
            f"{np.abs(truth.joint_speed).max():.1f} rad/s |"
        )


if __name__ == "__main__":
    main()

"""Crocoddyl's own jump of 30 cm with ANYmal, solved on request: a line in, JSON out.

For an environment of its own (`solve_times.py --crocoddyl` makes it): it knows nothing of this
project. A whole-body plan with a given sequence of contacts, from its example
`quadrupedal_gaits_fwddyn.py`, sideways; 10 ms a knot.
"""

from __future__ import annotations

import json
import sys
import time

import crocoddyl
import example_robot_data
import numpy as np
import pinocchio
from crocoddyl.utils.quadruped import SimpleQuadrupedalGaitProblem

FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")


def main() -> None:
    anymal = example_robot_data.load("anymal")
    gait = SimpleQuadrupedalGaitProblem(anymal.model, *FEET)
    q0 = anymal.model.referenceConfigurations["standing"].copy()
    x0 = np.concatenate([q0, pinocchio.utils.zero(anymal.model.nv)])
    print("ready", flush=True)
    for _ in sys.stdin:
        problem = gait.createJumpingProblem(x0, 0.15, np.array([0.0, 0.3, 0.0]), 1e-2, 10, 20)
        solver = crocoddyl.SolverFDDP(problem)
        start = time.perf_counter()
        xs = [x0] * (problem.T + 1)
        converged = solver.solve(xs, problem.quasiStatic([x0] * problem.T), 100, False)
        seconds = time.perf_counter() - start
        figures = {"solve": seconds, "iterations": solver.iter, "knots": problem.T}
        print(json.dumps(figures | {"converged": int(converged)}), flush=True)


if __name__ == "__main__":
    main()

"""Crocoddyl's own jump of 30 cm with ANYmal, solved on request: a line in, JSON out.

    python benchmarks/crocoddyl_jump.py [--forward] [--solver fddp|box-fddp|csqp] [--out FILE]

For an environment of its own (`interleaved.crocoddyl_python` makes it): it knows nothing of this
project. A whole-body plan with a given sequence of contacts, from its example
`quadrupedal_gaits_fwddyn.py`, sideways as there; 10 ms a knot. The motion is written as npz. FDDP
has no limits; BoxFDDP and mim_solvers' CSQP have the drives' torques as bounds of the controls.
"""

from __future__ import annotations

import argparse
import json
import sys
import time

import crocoddyl
import example_robot_data
import mim_solvers
import numpy as np
import pinocchio
from crocoddyl.utils.quadruped import SimpleQuadrupedalGaitProblem

FEET = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
LENGTH = 0.3  # m
TORQUE = 40.0  # Nm, of ANYmal's drives
ITERATIONS = 100  # at most, all solvers


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--forward", action="store_true", help="in place of sideways")
    parser.add_argument("--out", help="npz for the last motion")
    parser.add_argument("--solver", choices=SOLVERS, default="fddp")
    arguments = parser.parse_args()
    anymal = example_robot_data.load("anymal")
    gait = SimpleQuadrupedalGaitProblem(anymal.model, *FEET)
    q0 = anymal.model.referenceConfigurations["standing"].copy()
    x0 = np.concatenate([q0, pinocchio.utils.zero(anymal.model.nv)])
    length = np.array([LENGTH, 0.0, 0.0] if arguments.forward else [0.0, LENGTH, 0.0])
    print("ready", flush=True)
    for _ in sys.stdin:
        problem = gait.createJumpingProblem(x0, 0.15, length, 1e-2, 10, 20)
        solver = SOLVERS[arguments.solver](problem)
        problem = solver.problem
        start = time.perf_counter()
        xs = [x0] * (problem.T + 1)
        converged = solver.solve(xs, problem.quasiStatic([x0] * problem.T), ITERATIONS, False)
        seconds = time.perf_counter() - start
        if arguments.out:
            np.savez(arguments.out, **motion(anymal.model, solver))
        figures = {"solve": seconds, "iterations": solver.iter, "knots": problem.T}
        print(json.dumps(figures | {"converged": int(converged)}), flush=True)


def box_fddp(problem: crocoddyl.ShootingProblem) -> crocoddyl.SolverBoxFDDP:
    for action in problem.runningModels:
        if action.nu:  # impulses have none
            action.u_lb, action.u_ub = (sign * np.full(action.nu, TORQUE) for sign in (-1, 1))
    return crocoddyl.SolverBoxFDDP(problem)


def csqp(problem: crocoddyl.ShootingProblem) -> mim_solvers.SolverCSQP:
    actions = [bounded(action) if action.nu else action for action in problem.runningModels]
    return mim_solvers.SolverCSQP(
        crocoddyl.ShootingProblem(problem.x0, actions, problem.terminalModel)
    )


def bounded(action: crocoddyl.IntegratedActionModelEuler) -> crocoddyl.IntegratedActionModelEuler:
    own = action.differential
    limits = crocoddyl.ConstraintModelManager(own.state, own.nu)
    most = np.full(own.nu, TORQUE)
    torque = crocoddyl.ResidualModelControl(own.state, own.nu)
    limits.addConstraint(
        "torque", crocoddyl.ConstraintModelResidual(own.state, torque, -most, most)
    )
    parts = own.state, own.actuation, own.contacts, own.costs, limits
    inner = crocoddyl.DifferentialActionModelContactFwdDynamics(*parts, 0.0, True)
    return crocoddyl.IntegratedActionModelEuler(inner, action.dt)


SOLVERS = {"fddp": crocoddyl.SolverFDDP, "box-fddp": box_fddp, "csqp": csqp}


def motion(model: pinocchio.Model, solver: crocoddyl.SolverAbstract) -> dict[str, np.ndarray]:
    """N intervals: velocities and torques of the joints, forces, feet; what the impacts give."""
    data = model.createData()
    frames = [model.getFrameId(name) for name in FEET]
    problem, nq = solver.problem, model.nq
    feet, coms = [], []
    for x in solver.xs:
        pinocchio.framesForwardKinematics(model, data, x[:nq])
        coms.append(np.array(pinocchio.centerOfMass(model, data, x[:nq])))
        feet.append([np.array(data.oMf[frame].translation) for frame in frames])
    rows = {"joint_velocity": [], "joint_torque": [], "contact_force": [], "standing": []}
    kept, impulse = [], 0.0
    for k, (action, step) in enumerate(zip(problem.runningModels, problem.runningDatas)):
        if isinstance(action, crocoddyl.ActionModelImpulseFwdDynamics):
            impulse += float(
                np.linalg.norm(forces(model, step.multibody.impulses.impulses, step).sum(0))
            )
            continue
        inner = step.differential
        contacts = inner.multibody.contacts.contacts
        found = forces(model, contacts, inner)
        kept.append(k)
        rows["joint_velocity"].append(np.array(solver.xs[k][nq + 6 :]))
        rows["joint_torque"].append(np.array(solver.us[k]))
        rows["contact_force"].append(found)
        rows["standing"].append([any(foot in name for name in names(contacts)) for foot in FEET])
    return {
        **{name: np.array(values) for name, values in rows.items()},
        "foot_position": np.array([feet[k] for k in [*kept, len(feet) - 1]]),
        "joint_names": np.array(list(model.names)[2:]),
        "feet": np.array(FEET),
        "impulse": np.array(impulse),
        "moved": np.array(coms[-1][0] - coms[0][0]),
    }


def names(contacts: object) -> list[str]:
    """Names of the contacts or impulses of a knot."""
    return [item.key() for item in contacts]


def forces(model: pinocchio.Model, contacts: object, data: object) -> np.ndarray:
    """(4, 3) N, or N s, world frame: of the feet that touch."""
    found = np.zeros((len(FEET), 3))
    for item in contacts:
        contact = item.data()
        index = next(i for i, foot in enumerate(FEET) if foot in item.key())
        joint = model.frames[model.getFrameId(FEET[index])].parentJoint
        R_world_joint = np.array(data.pinocchio.oMi[joint].rotation)
        found[index] = R_world_joint @ np.array(contact.fext.linear)
    return found


if __name__ == "__main__":
    main()

"""Changes of a plan's cost with the robot's numbers, from the multipliers of its solution.

The cost is the planner's: roughness, duration, torques as shares of the drives', forces as shares
of the weight, so that those of a heavier robot count less. At an optimum it changes with a number
of the problem as its Lagrangian does with the motion and the multipliers left as they are (the
envelope theorem): of each number two evaluations do. The problem is the whole body's, near the
plan, solved once more for its multipliers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import pinocchio as pin

from llsrbm.arrays import Array
from llsrbm.errors import InputError, NotConverged
from llsrbm.mechanics import turns_about_z
from llsrbm.motion.plan import Plan
from llsrbm.number_text import short
from llsrbm.ocp.horizon import Problem, Solution
from llsrbm.ocp.progress import solving
from llsrbm.ocp.solvers import SolveOptions
from llsrbm.planning.whole_body.bounds import RowBounds
from llsrbm.planning.whole_body.problem import make_problem
from llsrbm.planning.whole_body.refine import Refiner, refiner_of
from llsrbm.planning.whole_body.sizes import Sizes, parts
from llsrbm.planning.whole_body.start import Start, start_of, variables
from llsrbm.request.messages import check_kind
from llsrbm.robots.robot import Robot

# Multipliers are good to four digits; Fatrop takes some 15 iterations from a plan.
EXACTLY = SolveOptions(mu=1e-5, iterations=200, tolerance=1e-6, push=0.01)
STEP = 1e-3  # units of a number, either way: the Lagrangian is smooth in all of them
CENTIMETRE = 0.01
SHORTEST = 0.05  # m: what is between joints that lie closer is no link of a leg
NOTHING = 5e-6  # share of the cost


@dataclass(frozen=True)
class Sensitivity:
    """Change of the cost with one more unit of something.

    Attributes:
        name: "payload", a drive's "torque of JOINT" or "speed of JOINT", a link's "length from
            JOINT to JOINT" or "to the foot", of all legs alike, named by the first leg's joints.
        unit: kg at the origin of the trunk's frame; Nm or N; rad/s or m/s; cm, the masses staying.
        share: change of the plan's cost for one unit more, as a share of the cost.
    """

    name: str
    unit: str
    share: float

    def __str__(self) -> str:
        """A sentence."""
        if abs(self.share) < NOTHING:
            return f"1 {self.unit} more {self.name} changes nothing"
        does = "raises" if self.share > 0 else "lowers"
        percent = short(float(f"{100 * abs(self.share):.2g}"))
        return f"1 {self.unit} more {self.name} {does} the cost by {percent} %"


def sensitivity(plan: Plan) -> tuple[Sensitivity, ...]:
    """Changes of a plan's cost with payload, drives and lengths of links, the largest first.

    Raises:
        InputError: it is no plan, or a draft, whose cost is not the whole body's.
        NotConverged: the whole body's problem is not solved closely enough from there.
    """
    check_kind("plan", plan, Plan, "a Plan")
    if not plan.refined:
        raise InputError(
            "sensitivity: the plan is a draft of the first stage; expected one of the whole body"
        )
    optimum = Optimum.of(plan)
    found = [
        Sensitivity(name, unit, optimum.slope(moved) / optimum.solution.cost)
        for name, unit, moved in optimum.moves()
    ]
    return tuple(sorted(found, key=lambda each: -abs(each.share)))


@dataclass(frozen=True, eq=False)
class Optimum:
    """The whole body's problem near a plan, and its solution."""

    refiner: Refiner
    start: Start
    problem: Problem
    solution: Solution

    @classmethod
    def of(cls, plan: Plan) -> Optimum:
        """Raises `NotConverged`: see `sensitivity`."""
        refiner = refiner_of(plan)
        robot, grid = refiner.robot, refiner.grid
        start, sizes = start_of(plan, robot, grid), Sizes.of(robot, len(grid.phases))
        problem = make_problem(RowBounds(robot, grid, sizes, start))
        solution = refiner.solver.solve(problem, variables(start, grid, sizes), EXACTLY)
        if not solution.converged:
            raise NotConverged(f"sensitivity: {solution.message} near the plan", plan)
        return cls(refiner, start, problem, solution)

    @property
    def robot(self) -> Robot:
        """The plan's."""
        return self.refiner.robot

    @cached_property
    def sizes(self) -> Sizes:
        """The problem's."""
        return Sizes.of(self.robot, len(self.refiner.grid.phases))

    def slope(self, moved: Callable[[float], Problem]) -> float:
        """Change of the cost with what `moved` changes."""
        ahead, behind = (self._lagrangian(moved(step)) for step in (STEP, -STEP))
        return (ahead - behind) / (2 * STEP)

    def _lagrangian(self, problem: Problem) -> float:
        w, multipliers = self.solution.variables, self.solution.multipliers
        with solving:
            cost, rows = (
                np.array(self.refiner.solver.function(name)(w, problem.parameters)).ravel()
                for name in ("nlp_f", "nlp_g")
            )
        bounds = np.where(multipliers > 0, problem.upper, problem.lower)
        return float(cost[0] + multipliers @ (rows - np.where(np.isfinite(bounds), bounds, 0.0)))

    def moves(self) -> Iterator[tuple[str, str, Callable[[float], Problem]]]:
        """Name, unit, and the problem with so many units more."""
        yield "payload", "kg", self._loaded
        for joint, name in enumerate(self.robot.joint_names):
            slides = name in self.robot.sliding_joints
            yield f"torque of {name}", "N" if slides else "Nm", self._driven("torque_limit", joint)
            yield (
                f"speed of {name}",
                "m/s" if slides else "rad/s",
                self._driven("speed_limit", joint),
            )
        for name, link in self._links():
            yield name, "cm", partial(self._longer, link)

    def _loaded(self, mass: float) -> Problem:
        problem, numbers = self._copy(self.problem)
        numbers["trunk"][0] += mass
        numbers["weight"] += mass * numbers["weight"] / self.robot.mass
        return problem

    def _driven(self, name: str, joint: int) -> Callable[[float], Problem]:
        def moved(more: float) -> Problem:
            problem, numbers = self._copy(self.problem)
            numbers[name][joint] += more
            return problem

        return moved

    def _links(self) -> Iterator[tuple[str, int]]:
        """Name and place of each link of the legs: between a joint and the next, or the foot."""
        leg = self.robot.legs[0]
        for k in range(1, len(leg.joints)):
            if np.linalg.norm(self.robot.model.jointPlacements[leg.joint_ids[k]].translation) > (
                SHORTEST
            ):
                yield f"length from {leg.joints[k - 1]} to {leg.joints[k]}", k
        if self.robot.file.foot.is_point:
            yield f"length from {leg.joints[-1]} to the foot", len(leg.joints)

    def _longer(self, link: int, centimetres: float) -> Problem:
        """With longer links: the base stands as much higher, the feet land where they stand."""
        more = CENTIMETRE * centimetres
        grid, along = self.refiner.grid, more * self._stretched(link)
        state = {name: values.copy() for name, values in self.start.state.items()}
        state["position"][[0, -1], 2] -= along[:, 2].mean()
        place, along[:, 2] = self.start.place.copy(), 0.0
        for half in range(len(place)):
            lands = self.start.task.footholds_after(grid.phase_at(half))
            place[half] += along @ turns_about_z(lands.heading).T
        start = replace(self.start, state=state, place=place)
        rows = RowBounds(self.robot, grid, self.sizes, start)
        problem, numbers = self._copy(make_problem(rows))
        for i, kind in enumerate(self.sizes.limbs[: self.sizes.legs]):
            own = parts(numbers[f"limb {i}"], kind.numbers)
            last = link == len(kind.joints)
            arm = own["place" if last else f"arm {link}"]
            shift = more * arm / np.linalg.norm(arm)
            arm += shift
            for name in ("contacts", "balls") if last else ():
                own[name].reshape(-1, 3)[:] += shift
        return problem

    def _stretched(self, link: int) -> Array:
        """(L, 3) by how much a foot of the default posture moves, m a metre of the link."""
        model, found = self.robot.model, []
        data = model.createData()
        pin.forwardKinematics(model, data, self.robot.posture)
        for leg in self.robot.legs:
            last = link == len(leg.joints)
            if last:
                arm = model.frames[leg.foot_frame_id].placement.translation
            else:
                arm = model.jointPlacements[leg.joint_ids[link]].translation
            carrier = data.oMi[leg.joint_ids[link - 1]].rotation
            found.append(carrier @ arm / np.linalg.norm(arm))
        return np.array(found)

    def _copy(self, problem: Problem) -> tuple[Problem, dict[str, Array]]:
        """A problem whose robot's numbers may be written to, and these by name."""
        values = problem.parameters.copy()
        every = sum(self.sizes.robot.values())
        return replace(problem, parameters=values), parts(values[:every], self.sizes.robot)

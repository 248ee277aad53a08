"""The motion nearest to a jump of another's whose certificate holds.

It is sought near to that motion first, then a little less so. Where it is found and misses its
certificate, which is between the nodes, it is found again with more intervals.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from llsrbm.certificate import certified
from llsrbm.certified_nearest import all_or_less
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.motion.plan import Plan
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.solve.jump_layout import layout_of
from llsrbm.planning.solve.watch import Watch
from llsrbm.planning.whole_body.grid import Grid
from llsrbm.planning.whole_body.refine import Refiner
from llsrbm.repairing.begun import begun
from llsrbm.repairing.request import Request
from llsrbm.robots.robot import Robot

# Weights of nearness. The second is that to drafts (`llsrbm.planning.whole_body.start.NEAR_DRAFT`).
NEAR = (30.0, 3.0)
FINER = 1.5  # times as many intervals, where a certificate does not hold


def nearest(request: Request, robot: Robot, watch: Watch) -> Plan:
    """The plan, with its certificate; `Plan.certified`: it holds; `Plan.refined`: it was found.

    Raises:
        NoJump: the robot cannot stand as the motion does.
        Cancelled: it is not wanted any more.
    """
    task = request.task
    watch.wait()
    watch.begin("preparing the whole body's equations")
    grid = Grid.at(task.schedule, layout_of(task.jump, robot).intervals)
    refiner = watch.built(partial(Refiner, robot, grid))
    motion = begun(request, robot, grid, refiner.solver.name)
    found, missed = motion, None
    for near in NEAR:
        found = refiner.keep(motion, task, near, watch)
        if found.refined:
            found = _checked(found, robot, watch)
            if found.certified:
                return found
            missed = missed or found
    if missed is None:
        return found
    finer = watch.built(partial(Refiner, robot, Grid.of(missed, FINER)))
    again = finer.keep(missed, task, NEAR[-1], watch)
    again = _checked(again, robot, watch) if again.refined else missed
    return again if again.certified else missed


def jump_alone(request: Request, watch: Watch) -> Plan | None:
    """The robot's own jump that lands nearest to where the motion does, whatever its limbs do.

    None: its robot has no table of solved jumps like it, or none is found from there. Raises
    `Cancelled`.
    """
    jump = replace(request.task.jump, stones=())
    planner = CertifiedPlanner(cancelled=watch.cancelled, progress=watch.progress)
    found = all_or_less(planner, make_task(jump, request.task.robot))
    return None if found is None else found.plan


def _checked(plan: Plan, robot: Robot, watch: Watch) -> Plan:
    watch.begin("checking the motion at 1 kHz")
    return watch.built(partial(certified, plan, robot))

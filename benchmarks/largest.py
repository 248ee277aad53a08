"""The largest jumps of robots (`llsrbm largest`), and the largest that are strict in simulations.

    python -m benchmarks.largest --robots go2,anymal --components forward,up --seeds 15000:15020
    python -m benchmarks.largest --robots go2 --components forward --types rear-last,run-up

A line a robot, jump type and component: the largest that is planned, what stops it, and the time
it took. With `--seeds` each plan is simulated with every seed, everything disturbed: the largest,
and then smaller ones, planned by themselves, until one is strict in nine of ten; each is named,
with its counts.
"""

import math
import time
from collections.abc import Iterator
from contextlib import suppress
from itertools import product
from typing import Annotated

import typer

import llsrbm
from benchmarks.counting import Counts, count, seeds_of
from benchmarks.jump_types import failures
from llsrbm.largest_jump import DIRECTIONS, Largest
from llsrbm.motion.plan import Plan
from llsrbm.request.jump import PLAIN

COMPONENTS = "twist,forward,backward,lateral,up,down"  # robots are mirrored: not to the right too
LESS = (0.97, 0.94, 0.9, 0.85, 0.8, 0.7, 0.5)  # shares of the largest
STRICT = 0.9  # share of the seeds


def simulated(plan: Plan, seeds: range) -> tuple[Counts, str]:
    """Counts of a plan's seeds, and why those that were not strict were not."""
    outcomes = [llsrbm.simulate(plan, seed=seed).outcome for seed in seeds]
    return count(outcomes), failures(outcomes)


def in_words(found: Largest, plan: Plan) -> str:
    """How much of the component a plan does."""
    direction = DIRECTIONS[found.component]
    return direction.in_words(abs(getattr(plan.jump, direction.field)))


def smaller(found: Largest) -> Iterator[Plan]:
    """Certified plans of ever less of the component."""
    direction = DIRECTIONS[found.component]
    most = direction.steps(getattr(found.plan.jump, direction.field))
    for share in LESS:
        jump = direction.of(found.plan.jump, math.floor(share * most))
        with suppress(llsrbm.NotConverged):
            plan = llsrbm.plan(jump, patient=False)
            if plan.certified:
                yield plan


def score(found: Largest, seeds: range) -> None:
    """Print what becomes of the plans, the largest first, until enough seeds are strict."""
    for plan in (found.plan, *smaller(found)):
        counts, why = simulated(plan, seeds)
        strict = f"{counts.strict} of {counts.requests} strict, {counts.stand} stand"
        print(f"  {in_words(found, plan)}: {strict}{why and f'; {why}'}", flush=True)
        if counts.strict >= STRICT * counts.requests:
            break


def main(
    robots: Annotated[str, typer.Option(help="Names, with commas.")] = "go2",
    components: Annotated[str, typer.Option(help="Likewise.")] = COMPONENTS,
    types: Annotated[str, typer.Option(help="Jump types, likewise.")] = PLAIN,
    arms: Annotated[str, typer.Option(help="free or held.")] = "free",
    seeds: Annotated[str, typer.Option(help="First:last+1 of simulations.")] = "",
) -> None:
    for robot, kind, component in product(
        *(each.split(",") for each in (robots, types, components))
    ):
        name, start = f"{robot} {kind} {component}", time.perf_counter()
        try:
            found = llsrbm.largest(llsrbm.Jump(robot=robot, type=kind, arms=arms), component)
        except llsrbm.NotConverged as error:
            print(f"{name}: {error}", flush=True)
            continue
        seconds, words = time.perf_counter() - start, in_words(found, found.plan)
        print(f"{name}: {words}; {found.limit}; {seconds:.0f} s", flush=True)
        if seeds:
            score(found, seeds_of(seeds))


if __name__ == "__main__":
    typer.run(main)

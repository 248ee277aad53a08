"""Memory of one process that plans for many robots, models and types, with interpreted solvers.

    LLSRBM_COMPILE=0 python -m benchmarks.resident_memory [ROBOT ...]

Prints after each request the resident memory, the largest so far, and the solvers that are kept.
"""

import argparse
import os
import resource

import llsrbm
from benchmarks.served import resident
from llsrbm import models
from llsrbm.errors import Error
from llsrbm.planning.solve import kept

ROBOTS = ("anymal", "go2", "slider", "a1", "solo12", "g1_legs")
TYPES = ("together", "rear-last", "run-up", "hops", "flip")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("robots", nargs="*", default=ROBOTS)
    print(f"{'request':38} {'now':>6} {'most':>6} {'solvers':>8}  MB")
    for robot in parser.parse_args().robots:
        for jump in (
            *(llsrbm.Jump(robot=robot, model=name) for name in models.names()),
            llsrbm.Jump(robot=robot, twist=3.0, height=0.1),  # of which the nearest is looked for
            *(llsrbm.Jump(robot=robot, type=name) for name in TYPES[1:]),
        ):
            try:
                llsrbm.plan(jump, explains=False)
                outcome = ""
            except Error as error:
                outcome = type(error).__name__
            now, _ = resident(os.getpid())
            most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
            name = f"{robot} {jump.model} {jump.type} {outcome}"
            print(f"{name:38} {now:6.0f} {most:6.0f} {kept.size():8.0f}", flush=True)


if __name__ == "__main__":
    main()

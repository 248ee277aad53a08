"""A fixed set of plans and rollouts: written, and compared with the set of another version.

    python -m benchmarks.fixed_set --out before                    # on one version
    python -m benchmarks.fixed_set --out after --against before    # on another

Every robot, each jump type that it has, and each model; LLSRBM_COMPILE=0 keeps a solver that is
compiled halfway through from changing the last bits.
"""

import argparse
import math
from pathlib import Path

import numpy as np

import llsrbm
from llsrbm.robots import names

FORWARD = {"hurdle": 0.5, "gap": 0.45}  # m
ROBOTS_FORWARD = {"g1_legs": 0.05, "talos": 0.05}  # m, its range is short
CLOSE = 1e-9  # largest difference that counts as the same, in each quantity's own unit


def jumps():
    """(name, jump) of the set."""
    for robot in names():
        forward = ROBOTS_FORWARD.get(robot, 0.2)
        yield f"{robot}-twist", llsrbm.Jump(robot=robot, twist=math.radians(20))
        yield f"{robot}-forward", llsrbm.Jump(robot=robot, forward=forward)
        for model in ("srbm", "llsrbm"):
            yield f"{robot}-{model}", llsrbm.Jump(robot=robot, model=model, twist=math.radians(15))
        for kind in ("rear-last", "hops", "run-up", "one-foot-first", "hurdle", "gap"):
            speed = 0.3 if kind == "run-up" else 0.0
            length = FORWARD.get(kind, forward)
            jump = llsrbm.Jump(robot=robot, type=kind, forward=length, speed=speed)
            yield f"{robot}-{kind}", jump
    yield "go2-flip-front", llsrbm.Jump(robot="go2", type="flip", pitch=2 * math.pi)
    yield "go2-flip-back", llsrbm.Jump(robot="go2", type="flip", pitch=-2 * math.pi)


def write(folder, name, jump):
    """Plan and simulate one; a refusal is written as text."""
    flip = jump.type == "flip"
    try:
        plan = llsrbm.plan(jump, patient=flip, draft=True)
    except llsrbm.Error as error:
        (folder / f"{name}.txt").write_text(str(error), encoding="utf-8")
        return "refused"
    plan.save(folder / f"{name}.plan.npz")
    rollout = llsrbm.simulate(plan, seed=7)
    rollout.save(folder / f"{name}.rollout.npz")
    return f"{plan.effort.iterations} iterations, {rollout.outcome.status}"


def largest_difference(one, other):
    """(difference, key) over all arrays of numbers that both files have; NaN beside NaN is none."""
    with np.load(one) as a, np.load(other) as b:
        shared = [key for key in a.files if key in b.files and a[key].dtype.kind == "f"]
        differences = {
            key: float(np.nanmax(np.abs(a[key] - b[key]), initial=0.0))
            if a[key].shape == b[key].shape
            else math.inf
            for key in shared
        }
    key = max(differences, key=differences.__getitem__)
    return differences[key], key


def compare(folder, against):
    """Print the largest difference of each file, and how many are the same."""
    differences = []
    for path in sorted(against.glob("*.npz")):
        other = folder / path.name
        if not other.exists():
            print(f"{path.name}: missing")
            differences.append(math.inf)
            continue
        amount, key = largest_difference(path, other)
        differences.append(amount)
        if amount > 0.0:
            print(f"{path.name}: {amount:.2e} in {key}")
    every = np.array(differences)
    print(
        f"{(every == 0.0).sum()} of {len(every)} files are the same to the last bit, "
        f"{(every <= CLOSE).sum()} within {CLOSE:g}"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder to write to")
    parser.add_argument("--against", type=Path, help="folder of the other version")
    parser.add_argument("--robots", help="only these, separated by commas")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    wanted = options.robots.split(",") if options.robots else None
    for name, jump in jumps():
        if wanted is None or jump.robot in wanted:
            print(name, write(options.out, name, jump), flush=True)
    if options.against is not None:
        compare(options.out, options.against)


if __name__ == "__main__":
    main()

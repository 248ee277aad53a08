"""How often the guess from tables of solved jumps, whether a jump can be planned, is right.

    python -m benchmarks.range --robots go2 --requests 200 --seed 10061 --once --out FILE
    python -m benchmarks.feasible FILE

Columns: requests of a robot; whose plan is certified; guessed right; refused ones that were found;
requests that were wrongly said not to be there. Rows are those of `benchmarks.range`.
"""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from benchmarks.counting import count
from llsrbm.planning.whole_body.feasible import feasible_of
from llsrbm.request.jump import COMPONENTS, Jump
from llsrbm.robots import load_robot


def main(rows: Annotated[list[Path], typer.Argument(help="Files of `benchmarks.range`.")]) -> None:
    """Print a line a robot."""
    lines = [line for path in rows for line in path.read_text(encoding="utf-8").splitlines()]
    found = [json.loads(line) for line in lines]
    print("| robot | requests | certified | right | refused ones found | wrongly refused |")
    print("|---|---|---|---|---|---|")
    for name in dict.fromkeys(row["robot"] for row in found):
        mine = [row for row in found if row["robot"] == name]
        can = np.array([bool(row.get("certified")) for row in mine])
        jumps = [Jump(robot=name, **{key: row.get(key, 0.0) for key in COMPONENTS}) for row in mine]
        feasible = feasible_of(load_robot(name))
        if feasible is None:
            print(f"| {name} | {count(len(mine), 'request')} | no table | | | |")
            continue
        guess = np.array([feasible.score(jump) for jump in jumps]) > 0
        print(
            f"| {name} | {len(mine)} | {can.mean():.0%} | {(guess == can).mean():.1%} "
            f"| {(~guess & ~can).sum()} of {(~can).sum()} | {(~guess & can).sum()} |"
        )


if __name__ == "__main__":
    typer.run(main)

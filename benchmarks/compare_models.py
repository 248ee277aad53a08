"""Ten requests made with each model, in the page's sentence: `python -m benchmarks.compare_models`.

Each is planned as a draft with each model and simulated, and the sentence's figures are looked up
in the rows of `llsrbm compare`, to the digits that are shown. `--request K` does one of them.
"""

import argparse
import math
import re
import sys
import time

import llsrbm
from app.panel.jump_controls import title_of_model
from llsrbm import models
from llsrbm.analysis.figures import figures_of_plan
from llsrbm.analysis.side_by_side import Way, rows, sentence, turning
from llsrbm.errors import NotConverged
from llsrbm.request.jump import Jump

REQUESTS = (
    {"robot": "anymal", "twist": 90},
    {"robot": "go2", "twist": 90},
    {"robot": "slider", "twist": 90},
    {"robot": "anymal", "twist": 180},
    {"robot": "anymal", "twist": -45, "forward": 0.2},
    {"robot": "anymal", "forward": 0.4, "height": 0.1},
    {"robot": "go2", "twist": 150, "lateral": 0.1},
    {"robot": "go2", "forward": 0.5},
    {"robot": "slider", "twist": -120, "forward": 0.1},
    {"robot": "slider", "forward": 0.2, "height": 0.2},
)


def main() -> None:
    """Print sentences and tables; exit status 1 where a sentence has another figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--request", type=int, choices=range(len(REQUESTS)))
    chosen = parser.parse_args().request
    wrong = 0
    for request in REQUESTS if chosen is None else [REQUESTS[chosen]]:
        began = time.perf_counter()
        ways = [_way(request, model) for model in models.MODELS]
        text = sentence(ways)
        faults = _faults(text, ways)
        wrong += len(faults)
        print(f"{request} ({time.perf_counter() - began:.0f} s)\n  {text}")
        for title, values in rows(ways):
            print(f"    {title:42}{'  '.join(f'{value:>18}' for value in values)}")
        for fault in faults:
            print(f"  WRONG: {fault}")
        sys.stdout.flush()
    print(f"{wrong} figures differ from those of `llsrbm compare`")
    sys.exit(wrong > 0)


def _way(request: dict[str, object], model: str) -> Way:
    fields = {**request, "twist": math.radians(request.get("twist", 0.0))}  # type: ignore[arg-type]
    name = title_of_model(model)
    try:
        plan = llsrbm.plan(Jump(model=model, **fields), draft=True)  # type: ignore[arg-type]
    except NotConverged as error:
        return Way(name, why_not=error.reason or str(error))
    return Way(name, llsrbm.simulate(plan))


def _faults(text: str, ways: list[Way]) -> list[str]:
    """Where the clause of a way has other figures than its row of the comparison."""
    found = []
    clauses = text.split("; ")
    for way, clause in zip(ways, clauses, strict=True):
        if way.rollout is None:
            expected = [f"{way.name} has no plan"]
        else:
            figures, turn = figures_of_plan(way.rollout.plan, way.rollout), turning(way.rollout)
            expected = [way.name]
            if turn.axis == "yaw" and figures.yaw_error_at_touchdown is not None:
                expected += [_size(figures.yaw_error_at_touchdown)]
                expected += [_size(figures.yaw_error_in_flight)]
            if figures.status == "fell":
                expected += ["falls at"]
        found += [
            f"{way.name}: no {word!r} in {clause!r}" for word in expected if word not in clause
        ]
    named = re.search(r": (.*) foresees? the flight best", text)
    errors = {
        way.name: round(math.degrees(abs(turn)), 1)
        for way in ways
        if way.rollout is not None and (turn := turning(way.rollout).in_flight) is not None
    }
    best = [name for name, error in errors.items() if error == min(errors.values())]
    if named is not None and named.group(1).split(" and ") != best:
        found.append(f"the best is {best}")
    return found


def _size(angle: float | None) -> str:
    return "" if angle is None else f"{abs(math.degrees(angle)):.1f}°"


if __name__ == "__main__":
    main()

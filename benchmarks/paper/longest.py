"""How far ANYmal can be planned to jump, by model: whether inertia shaping moves that limit."""

import re
import tempfile
from pathlib import Path

import llsrbm
from benchmarks.paper.drawing import TITLE
from benchmarks.paper.result import Table
from llsrbm.errors import NotConverged
from llsrbm.planning.answer.planner import planner_for
from llsrbm.robots import load_robot

MODELS = ("llsrbm-plus", "srbm")
NEAREST, FARTHEST = 0.6, 1.4  # m; the robot file offers the nearest
STEP = 0.02  # m
SEEDS = range(6000, 6005)


def longest() -> tuple[dict[str, float], dict[str, str], Table]:
    """Model -> distance, m, by bisection; model -> how many land; both as a table."""
    text = load_robot("anymal").path.read_text(encoding="utf-8")
    wider = re.sub(r"(?m)^forward = \[(.*?),.*?\]", rf"forward = [\1, {FARTHEST}]", text)
    found: dict[str, float] = {}
    landed: dict[str, str] = {}
    rows = []
    with tempfile.TemporaryDirectory(prefix="llsrbm-") as folder:
        robot = Path(folder, "anymal.toml")
        robot.write_text(wider, encoding="utf-8")
        for model in MODELS:
            planner = planner_for(str(robot), model)

            def planned(distance: float, model: str = model, planner=planner) -> llsrbm.Plan | None:
                jump = llsrbm.Jump(robot=str(robot), model=model, forward=distance)
                try:
                    return planner.plan(jump)
                except NotConverged:
                    return None

            low, high = NEAREST, FARTHEST
            plan = planned(low)
            while high - low > STEP and plan is not None:
                middle = (low + high) / 2
                further = planned(middle)
                if further is None:
                    high = middle
                else:
                    low, plan = middle, further
            if plan is None:
                rows.append([TITLE[model], f"less than {NEAREST:g} m", ""])
                continue
            found[model] = low
            runs = [llsrbm.simulate(plan, llsrbm.Scenario(seed=seed)) for seed in SEEDS]
            strict = sum(run.outcome.strict for run in runs)
            landed[model] = f"{strict} of {len(runs)} land strictly"
            rows.append([TITLE[model], f"{low:.2f} m", f"{strict} of {len(runs)}"])
    return found, landed, Table(("model", "longest jump planned", "strict"), rows)

"""SLIDER's 90 deg twist and its jump onto a box of 35 cm, and how high it gets here."""

import math
from pathlib import Path

import llsrbm
from benchmarks.paper.drawing import TITLE, snapshots
from benchmarks.paper.result import AGREES, NOT, PARTLY, Result, Table
from llsrbm.errors import Error

MODELS = ("llsrbm-plus", "llsrbm", "srbm")
SEEDS = range(6000, 6010)
HIGHER = "box of 45 cm, 20 cm forward"
JUMPS = {
    "90° twist": {"twist": math.radians(90)},
    "box of 35 cm, 20 cm forward": {"forward": 0.2, "height": 0.35},
    HIGHER: {"forward": 0.2, "height": 0.45},
}
MOST = 0.9  # share of the seeds that makes a jump one that is done


def result(folder: Path) -> Result:
    rows, strict = [], {}
    kept = []
    for name, motion in JUMPS.items():
        for model in MODELS if name != HIGHER else MODELS[:1]:
            try:
                plan = llsrbm.plan(llsrbm.Jump(robot="slider", model=model, **motion), draft=True)
            except Error as error:
                rows.append([name, TITLE[model], "not planned", "", str(error)[:60]])
                continue
            seeds = SEEDS if model == MODELS[0] else SEEDS[:5]
            runs = [llsrbm.simulate(plan, llsrbm.Scenario(seed=seed)) for seed in seeds]
            strict[name, model] = sum(run.outcome.strict for run in runs)
            tilt = max(run.outcome.peak_tilt for run in runs)
            rows.append(
                [
                    name,
                    TITLE[model],
                    f"{strict[name, model]} of {len(runs)}",
                    f"{plan.com[:, 2].max() - plan.com[0, 2]:.2f} m",
                    f"{math.degrees(tilt):.1f}°",
                ]
            )
            if model == "llsrbm-plus" and name != HIGHER:
                kept.append((name.partition(",")[0], runs[0]))
    snapshots(kept, (0.1, 0.25, 0.35, 0.45, 0.8), folder / "biped_snapshots.png")
    twist, box, _ = JUMPS
    enough = MOST * len(SEEDS)
    done = [strict.get((name, "llsrbm-plus"), 0) >= enough for name in (twist, box)]
    beyond = strict.get((HIGHER, "llsrbm-plus"), 0)
    twists, boxes = (strict.get((name, "llsrbm-plus"), 0) for name in (twist, box))
    reason = (
        f"With everything disturbed {twists} of {len(SEEDS)} twists and {boxes} jumps onto the box "
        "land strictly. The paper calls 35 cm the maximum; here "
        f"{beyond} of {len(SEEDS)} land on 45 cm: the slides are given 6 m/s, for which nothing is "
        "published, and the pelvis' mass follows from the total alone. Of the paper's LL-SRBM "
        f"{strict.get((box, 'llsrbm'), 0)} of 5 land on the box. The box stands from the start."
    )
    return Result(
        "SLIDER: 90° twist, box of 35 cm",
        "SLIDER can twist by 90° with a yaw joint added to each leg, and jump at most onto a box "
        "of 35 cm, 20 cm forward.",
        [Table(("jump", "model", "strict", "CoM rises by", "largest tilt"), rows)],
        [("biped_snapshots.png", "Above the twist, below the box")],
        AGREES if all(done) and not beyond else PARTLY if any(done) else NOT,
        reason,
    )

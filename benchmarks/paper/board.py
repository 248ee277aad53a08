"""ANYmal's 30 deg twist onto a board of 25 mm that it does not know of."""

import math
from pathlib import Path

import numpy as np

import llsrbm
from benchmarks.paper.drawing import axes, phases, snapshots
from benchmarks.paper.result import AGREES, NOT, PARTLY, Result, Table
from llsrbm.motion.rollout import Mode

BOARD = 0.025  # m
SEEDS = range(6000, 6020)
DETECTORS = {"norm": "the paper's norm", "residual": "ours, in standard deviations"}


def result(folder: Path) -> Result:
    plan = llsrbm.plan(llsrbm.Jump(robot="anymal", twist=math.radians(30)), draft=True)
    runs = {
        name: [
            llsrbm.simulate(plan, llsrbm.Scenario(seed=seed, board=BOARD, detector=name))
            for seed in SEEDS
        ]
        for name in DETECTORS
    }
    shown = runs["residual"][0]
    figures = [
        (
            "board_detection.png",
            "Norm of the average spatial velocity, its derivative, residual, vertical force",
        ),
        ("board_snapshots.png", "On the board that was put there in flight"),
    ]
    _curves(runs["norm"][0], shown, folder / figures[0][0])
    snapshots([("30°, board", shown)], (0.1, 0.19, 0.25, 0.32, 0.5), folder / figures[1][0])
    rows = [[title, *_row(runs[name])] for name, title in DETECTORS.items()]
    landed = {name: sum(run.outcome.strict for run in runs[name]) for name in DETECTORS}
    false = {name: sum(run.outcome.false_touchdowns for run in runs[name]) for name in DETECTORS}
    works = landed["norm"] >= len(SEEDS) - 2 and not false["norm"]
    verdict = AGREES if works else PARTLY if landed["residual"] >= len(SEEDS) - 2 else NOT
    reason = (
        f"The norm's derivatives find the contact {rows[0][4]} later at the median; then the robot "
        f"follows forces as in the paper: {landed['norm']} of {len(SEEDS)} disturbed runs land "
        f"strictly with the paper's detector, with {false['norm']} false touchdowns; "
        f"{landed['residual']} and {false['residual']} with the "
        "residual, whose threshold follows from the sensors' noise and the trunk's uncertain mass. "
        "The paper gives neither its threshold nor its window, "
        "and shows one run on hardware."
    )
    heading = (
        *("detector", "strict", "false", "missed"),
        *("after the contact, median", "90 %", "contact felt"),
    )
    return Result(
        "ANYmal, 30° twist onto a board of 25 mm",
        "the norm of the average spatial velocity is smooth and a reliable judgement; the robot "
        "detected the unknown board and landed softly.",
        [Table(heading, rows)],
        figures,
        verdict,
        reason,
    )


def _row(runs: list[llsrbm.Rollout]) -> list[str]:
    outcomes = [run.outcome for run in runs]
    found = [o for o in outcomes if o.touchdown_detected_s is not None and o.touchdown_true_s]
    late = 1e3 * np.array([o.touchdown_detected_s - o.touchdown_true_s for o in found])
    early = 1e3 * np.median([o.touchdown_planned_s - o.touchdown_detected_s for o in found])
    return [
        f"{sum(o.strict for o in outcomes)} of {len(outcomes)}",
        f"{sum(o.false_touchdowns for o in outcomes)}",
        f"{len(outcomes) - len(found)}",
        f"{np.median(late):.1f} ms",
        f"{np.percentile(late, 90):.1f} ms",
        f"{abs(early):.0f} ms {'before' if early > 0 else 'after'} the plan",
    ]


def _curves(norm: llsrbm.Rollout, residual: llsrbm.Rollout, path: Path) -> None:
    figure, (velocity, slope, signal, force) = axes(4, 1, (6.0, 6.6))
    time, values = norm.time, norm.average_spatial_velocity_norm
    velocity.plot(time, values)
    velocity.set_ylabel("‖v_G‖ [–]")
    slope.plot(time, np.gradient(values, time), linewidth=0.8)
    slope.set_ylabel("its derivative [1/s]")
    slope.set_ylim(-40, 20)
    signal.plot(residual.time, residual.detection_signal, label="signal")
    signal.axhline(residual.detection_threshold, linestyle="--", label="threshold")
    signal.set_ylabel("residual [σ]")
    signal.legend()
    total = residual.contact_force[..., 2].sum(axis=1)
    force.plot(residual.time, total)
    phase = residual.mode == Mode.FORCE
    force.fill_between(residual.time, 0, total.max(), where=phase, alpha=0.2, label="force phase")
    force.set_ylabel("vertical force [N]")
    force.legend()
    for ax, run in ((velocity, norm), (slope, norm), (signal, residual), (force, residual)):
        outcome = run.outcome
        lift_off = float(run.time[np.argmax(~run.contact.any(axis=1))])
        phases(ax, lift_off, outcome.touchdown_true_s or math.nan)
        if outcome.touchdown_detected_s is not None:
            ax.axvline(outcome.touchdown_detected_s, color="tab:red", linewidth=0.8)
    figure.savefig(path, dpi=140)

"""ANYmal's 30 cm forward: do the feet stretch, does the pitch change less?"""

import math
from pathlib import Path

import numpy as np

import llsrbm
from benchmarks.paper.drawing import STYLE, TITLE, axes, phases, snapshots
from benchmarks.paper.longest import longest
from benchmarks.paper.result import AGREES, NOT, PARTLY, Result, Table
from llsrbm.errors import NotConverged
from llsrbm.mechanics import rotation_matrices

MODELS = ("llsrbm-plus", "llsrbm", "srbm")
SEEDS = range(6000, 6010)
SAME = 0.02  # m and 0.5 deg: differences below are none
SAME_PITCH = 0.5  # deg
RUN_UPS = (0.4, 0.8, 1.2)  # m/s, of jumps that begin and end moving: momentum is carried through


def result(folder: Path) -> Result:
    plans = {
        m: llsrbm.plan(llsrbm.Jump(robot="anymal", model=m, forward=0.3), draft=True)
        for m in MODELS
    }
    runs = {
        m: [llsrbm.simulate(plan, llsrbm.Scenario(seed=seed)) for seed in SEEDS]
        for m, plan in plans.items()
    }
    figures = [
        (
            "forward_curves.png",
            "Planned: pitch, angular momentum and inertia about y, distance of the feet",
        ),
        ("forward_snapshots.png", "Above LL-SRBM+, below SRBM"),
    ]
    _curves(plans, folder / figures[0][0])
    shown = [(TITLE[m], llsrbm.simulate(plans[m])) for m in ("llsrbm-plus", "srbm")]
    snapshots(shown, (0.1, 0.19, 0.25, 0.32, 0.5), folder / figures[1][0])
    rows, stretch, pitch = [], {}, {}
    for model in MODELS:
        stretch[model], pitch[model] = _stretch(plans[model]), _pitch_change(plans[model])
        done = [_pitch_of(run) for run in runs[model]]
        rows.append(
            [
                TITLE[model],
                f"{stretch[model]:.3f} m",
                f"{pitch[model]:.2f}°",
                f"{np.median(done):.2f}°",
                f"{np.abs(plans[model].angular_momentum[:, 1]).max():.2f}",
                f"{sum(run.outcome.strict for run in runs[model])} of {len(SEEDS)}",
            ]
        )
    stretches = stretch["llsrbm"] > stretch["srbm"] + SAME
    steadier = pitch["llsrbm"] < pitch["srbm"] - SAME_PITCH
    verdict = AGREES if stretches and steadier else PARTLY if stretches or steadier else NOT
    moving, table = _with_run_up()
    furthest, landed, limits = longest()
    reason = (
        f"In flight the feet are {stretch['llsrbm']:.3f} m from the CoM along x with LL-SRBM, "
        f"{stretch['srbm']:.3f} m with SRBM; the pitch changes by {pitch['llsrbm']:.2f}° and "
        f"{pitch['srbm']:.2f}°. From stand to stand take-off can end with no angular momentum, and "
        "then no inertia changes the pitch: the plans' largest about y is "
        f"{max(np.abs(plan.angular_momentum[:, 1]).max() for plan in plans.values()):.2f} kg m²/s. "
        + moving
    )
    listed = ", ".join(f"{TITLE[m]} {far:.2f} m ({landed[m]})" for m, far in furthest.items())
    reason += f" At the limit of reach (third table) the longest jumps planned are {listed}."
    heading = ("model", "feet from the CoM, fore and aft", "pitch, planned change in flight",
               "simulated", "largest Ly, planned [kg m²/s]", "strict")  # fmt: skip
    return Result(
        "ANYmal, 30 cm forward",
        "with LL-SRBM the feet stretch out more in the air than with SRBM, to increase the inertia "
        "about y and so reduce the change of the base's pitch.",
        [Table(heading, rows), table, limits],
        figures,
        verdict,
        reason,
    )


def _with_run_up() -> tuple[str, Table]:
    """The same distance from and into a run: the take-off is short for what it has to do."""
    rows, found = [], {}
    for speed in RUN_UPS:
        for model in ("llsrbm-plus", "srbm"):
            jump = llsrbm.Jump(robot="anymal", model=model, type="run-up", forward=0.5, speed=speed)
            try:
                plan = llsrbm.plan(jump, draft=True)
            except NotConverged:
                rows.append([f"{speed:g} m/s", TITLE[model], "not planned", "", "", ""])
                continue
            runs = [llsrbm.simulate(plan, llsrbm.Scenario(seed=seed)) for seed in SEEDS[:5]]
            strict = sum(run.outcome.strict for run in runs)
            off = float(np.median([_pitch_off(plan, run) for run in runs]))
            found[speed, model] = (_stretch(plan), _pitch_change(plan), off)
            rows.append(
                [
                    f"{speed:g} m/s",
                    TITLE[model],
                    f"{_stretch(plan):.3f} m",
                    f"{_pitch_change(plan):.2f}°",
                    f"{off:.2f}°",
                    f"{strict} of {len(runs)}",
                ]
            )
    both = [s for s in RUN_UPS if {(s, "llsrbm-plus"), (s, "srbm")} <= found.keys()]
    helped = [s for s in both if found[s, "llsrbm-plus"][2] < found[s, "srbm"][2] - SAME_PITCH]
    sentence = "From a run-up (second table) momentum has to be carried through the flight: there "
    if helped:
        speeds = ", ".join(f"{speed:g}" for speed in helped)
        nearer = max(found[s, "srbm"][2] - found[s, "llsrbm-plus"][2] for s in helped)
        sentence += (
            f"the base ends nearer to its planned pitch with LL-SRBM+ at {speeds} m/s, by "
            f"{nearer:.1f}° at most."
        )
    else:
        sentence += f"the base ends nowhere more than {SAME_PITCH:g}° nearer to its planned pitch."
    heading = (
        *("run-up", "model", "feet from the CoM", "pitch, planned change"),
        *("pitch − plan at touchdown", "strict"),
    )
    return sentence, Table(heading, rows)


def _pitch(quat: np.ndarray) -> np.ndarray:
    """(K,) deg, positive nose down."""
    return np.degrees(-np.arcsin(np.clip(rotation_matrices(quat)[:, 2, 0], -1, 1)))


def _stretch(plan: llsrbm.Plan) -> float:
    """Largest mean distance of the feet from the CoM along x in flight, m."""
    flying = ~plan.contact.any(axis=1)
    away = np.abs(plan.foot_position[flying, :, 0] - plan.com[flying, None, 0])
    return float(away.mean(axis=1).max())


def _pitch_change(plan: llsrbm.Plan) -> float:
    flying = (plan.time >= plan.lift_off) & (plan.time <= plan.touchdown)
    return float(np.ptp(_pitch(plan.base_quat[flying])))


def _pitch_of(rollout: llsrbm.Rollout) -> float:
    return float(np.ptp(_pitch(rollout.base_quat[~rollout.contact.any(axis=1)])))


def _pitch_off(plan: llsrbm.Plan, rollout: llsrbm.Rollout) -> float:
    """How far the pitch is from the planned one at the true touchdown, deg."""
    when = rollout.outcome.touchdown_true_s
    if when is None:
        return math.nan
    tick = np.searchsorted(rollout.time, when)
    planned = np.interp(plan.touchdown, plan.time, _pitch(plan.base_quat))
    return float(abs(_pitch(rollout.base_quat[tick : tick + 1])[0] - planned))


def _curves(plans: dict[str, llsrbm.Plan], path: Path) -> None:
    figure, (pitch, momentum, inertia, stretch) = axes(2, 2)
    for model, plan in plans.items():
        style, label = STYLE[model], TITLE[model]
        pitch.plot(plan.time, _pitch(plan.base_quat), style, label=label)
        momentum.plot(plan.time, plan.angular_momentum[:, 1], style, label=label)
        inertia.plot(plan.time, plan.inertia[:, 1, 1], style, label=label)
        away = np.abs(plan.foot_position[:, :, 0] - plan.com[:, None, 0]).mean(axis=1)
        stretch.plot(plan.time, away, style, label=label)
    for ax, label in (
        (pitch, "pitch of the base [deg]"),
        (momentum, "angular momentum, y [kg m²/s]"),
        (inertia, "centroidal inertia, yy [kg m²]"),
        (stretch, "feet from the CoM along x [m]"),
    ):
        phases(ax, plans["llsrbm-plus"].lift_off, plans["llsrbm-plus"].touchdown)
        ax.set_ylabel(label)
        ax.legend()
    figure.savefig(path, dpi=140)

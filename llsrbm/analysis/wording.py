"""Plans and rollouts in words: rows of a title and a value, the same wherever they are read."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from llsrbm.analysis.diagnosis import diagnose, fall_in_words
from llsrbm.analysis.drafts import certificate_words
from llsrbm.analysis.figure_table import FIGURE
from llsrbm.analysis.figures import DesignFigures, figures_of_plan
from llsrbm.analysis.model_turn import model_turn
from llsrbm.analysis.summaries import planned_peak_load, power_forecast
from llsrbm.certificate import Certificate
from llsrbm.certificate.power import CUT, PowerForecast
from llsrbm.motion.outcome import Outcome
from llsrbm.motion.plan import Plan
from llsrbm.motion.rollout import Disturbance, Rollout
from llsrbm.motion.solve_report import Refinement, Violation
from llsrbm.motion.trajectory import Trajectory
from llsrbm.number_text import decimal, degrees, percent, power, short
from llsrbm.request.scenario import Push, Scenario
from llsrbm.robots import Robot, load_robot
from llsrbm.robots.drives.stated import known_drives

TitledValue = tuple[str, str]
"""Title and value."""

_LOSSES = (
    ("armature", "Rotors", ("kg m²", "kg")),
    ("friction", "Friction", ("Nm", "N")),
    ("damping", "Damping", ("Nm s/rad", "N s/m")),
)
_EVENTS_OF_A_FALL = 4  # events; what follows them is the fall itself


@dataclass(frozen=True)
class InWords:
    """Figures of one design or outcome in words, by their names."""

    figures: DesignFigures | Outcome

    def __getitem__(self, name: str) -> str:
        return FIGURE[name].words(self.figures)

    def row(self, name: str) -> TitledValue:
        """A figure's title and value."""
        return FIGURE[name].title, self[name]

    def listed(self, names: Sequence[tuple[str, str]]) -> str:
        """Figures that are known, each before what it is of: "−2.9° at touchdown, ..."."""
        known = [
            (name, when) for name, when in names if FIGURE[name].value(self.figures) is not None
        ]
        return ", ".join(f"{self[name]} {when}" for name, when in known)


# ---- plans


def plan_rows(plan: Plan) -> list[TitledValue]:
    """The plan's figures; of one that was not found how it was looked for, and what is violated."""
    rows = _motion_rows(plan) if plan.solved else []
    rows.append(("Solver", _solver(plan)))
    if plan.refinement is not None:
        rows.append(("Whole body", _refinement(plan.refinement)))
    rows.append(("Certificate", certificate_words(plan)))
    return [*rows, ("Largest violation", worst_violation(plan))]


def _motion_rows(plan: Plan) -> list[TitledValue]:
    """Figures of a motion that satisfies the planner's constraints."""
    shown, load = InWords(figures_of_plan(plan)), planned_peak_load(plan)
    standing = float(plan.inertia[0, 2, 2])
    rows = [
        ("Duration", f"{shown['duration_s']} = {_phases(plan)}"),
        ("Turn", f"{shown['final_yaw']}, at most {shown['peak_yaw_rate']}"),
        (
            FIGURE["smallest_Izz"].title,
            f"{shown['smallest_Izz']} ({decimal(standing, 2)} standing)",
        ),
        shown.row("feet_radius"),
        (FIGURE["peak_force"].title, f"{shown['peak_force']}, {shown['peak_force_in_weights']}"),
        *_model_rows(plan),
    ]
    if load is not None:
        sliding = load_robot(plan.jump.robot).sliding_joints
        rows.append(("Most loaded joint", f"{load.joint} {load.in_words(sliding)}"))
    return [*rows, *power_rows(power_forecast(plan))]


def _phases(plan: Plan) -> str:
    """Names and durations, s; the feet that stand where it is some of them."""
    schedule = plan.schedule
    return " + ".join(
        phase.name
        + (f" ({', '.join(phase.feet)})" if 0 < len(phase.feet) < len(schedule.legs) else "")
        + f" {decimal(seconds, 2)}"
        for phase, seconds in zip(schedule, np.diff(plan.phase_start), strict=True)
    )


def _model_rows(plan: Plan) -> list[TitledValue]:
    """Turn of the whole body beyond what the model promises."""
    error = model_turn(plan)
    if error is None:
        return []
    takeoff, flight = (degrees(turn, signed=True) for turn in (error.takeoff, error.flight))
    words = f"{takeoff} until lift-off, {flight} in flight"
    return [(FIGURE["model_turn_in_flight"].title, words)]


def _solver(plan: Plan) -> str:
    report = plan.report
    if not report.attempts:
        return f"no draft: begun from {report.guess}"
    how = f"{counted(report.iterations, 'iteration')} {report.guess}".rstrip()
    guesses = f" ({report.attempts} guesses)" if report.attempts > 1 else ""
    compiling = ", still being compiled: twice as fast once it is" if report.compiling else ""
    return (
        f"{report.status} by {report.solver} in {how}{guesses}, {_ms(report.solve_time_s)} "
        f"({_ms(report.total_time_s)} from request to plan, {decimal(report.build_time_s, 2)} s "
        f"to build the solver{compiling})"
    )


def _refinement(of: Refinement) -> str:
    effort = f"{counted(of.iterations, 'iteration')}, {_ms(of.solve_time_s)}"
    if of.status != "solved":
        how = f"not found ({effort})" if of.iterations else "not looked for"
        return f"{how}: this is the draft"
    building = f", {of.build_time_s:.1f} s to build the solver" if of.build_time_s > 0.1 else ""
    compiling = ", still being compiled" if of.compiling else ""
    return f"found in {effort}{building}{compiling}"


def worst_violation(plan: Plan) -> str:
    """The constraint that is violated most, each measured in its own SI unit."""
    if not plan.violations:
        return "none is known"
    rows = dict(violation_rows(plan.violations))
    name, amount = next(iter(rows.items()))
    return f"{amount} ({name})"


def violation_rows(violations: dict[str, Violation]) -> list[TitledValue]:
    """Every constraint's largest violation, the largest first."""

    def size(violation: Violation) -> float:
        return math.inf if math.isnan(violation.amount) else violation.amount

    return [
        (
            name.replace("_", " "),
            f"{power(v.amount)}{_unit(v.unit)}, {v.phase} at {decimal(v.time, 2)} s"
            if v.amount
            else "0",
        )
        for name, v in sorted(violations.items(), key=lambda item: -size(item[1]))
    ]


def _unit(unit: str) -> str:
    """A unit after a number; of a plain number none."""
    return "" if unit == "1" else f" {unit.replace('m2', 'm²')}"


# ---- rollouts


def outcome_words(trajectory: Trajectory) -> str:
    """The result in one line, the most important thing first."""
    if isinstance(trajectory, Plan):
        if trajectory.solved:
            return f"Planned in {_ms(trajectory.effort.solve_time_s)}"
        return "Not a feasible plan: the solver did not converge"
    outcome = trajectory.outcome
    if not trajectory.landed:
        return f"Fell {fall_in_words(trajectory)}"
    shown = InWords(outcome)
    return (
        f"{landing(outcome)}; {shown['final_yaw_error']}, {shown['final_position_error']} and feet "
        f"{shown['foot_error']} from the plan at the end"
    )


def landing(outcome: Outcome) -> str:
    """For instance "Landed" or "Landed, not strict: feet misplaced by 80 mm"."""
    return "Landed" if outcome.strict else f"Landed, not strict: {shortfalls(outcome)}"


def shortfalls(outcome: Outcome) -> str:
    """Why a landing is not strict (`llsrbm.simulation.verdict`), in words."""
    shown = InWords(outcome)
    of = outcome.shortfalls
    words = {
        "feet": f"feet misplaced by {shown['foot_error']}",
        "touched": outcome.touched,
        "tilt": f"tilted by {shown['final_tilt']} at the end",
        "peak_tilt": f"tilted by up to {shown['peak_tilt']} after touchdown",
        "second_flight": f"bounced for {shown['second_flight_s']}",
        "unsolved": f"QP unsolved in {counted(outcome.unsolved_ticks, 'tick')}",
        "rebound": "a flight before the last ended on too few feet",
    }
    return ", ".join(words[name] for name in of)


def rollout_rows(rollout: Rollout) -> list[TitledValue]:
    """The simulation's figures; what went wrong before a fall comes first."""
    outcome, shown = rollout.outcome, InWords(rollout.outcome)
    rows = []
    if not rollout.landed:
        rows = [
            (f"Wrong from {decimal(event.time, 2)} s", event.words)
            for event in diagnose(rollout)[:_EVENTS_OF_A_FALL]
        ]
    pushes = rollout.pushes
    rows.append(("World", _world(rollout)))
    rows += [
        (f"Push {number}" if len(pushes) > 1 else "Push", push_words(push))
        for number, push in enumerate(pushes, start=1)
    ]
    if outcome.replan_median_s is not None:
        times = f"{shown['replan_median_s']}, p95 {shown['replan_p95_s']}"
        rows.append(("New plans", f"{followed_plans(rollout)} followed, {times}"))
    yaw_errors = (
        ("yaw_error_at_lift_off", "at lift-off"),
        ("yaw_error_in_flight", "gained in flight"),
        ("yaw_error_at_touchdown", "at touchdown"),
        ("final_yaw_error", "at the end"),
    )
    place = (
        ("final_position_error", "CoM"),
        ("foot_error_at_touchdown", "feet at touchdown"),
        ("foot_error", "feet at the end"),
        ("final_tilt", "tilt"),
    )
    return [
        *rows,
        ("Touchdown", _touchdown(outcome)),
        ("Yaw from the plan", shown.listed(yaw_errors)),
        ("Place from the plan", shown.listed(place)),
        (
            "Drives",
            (
                f"{shown['peak_torque_ratio']} of torque, {shown['peak_speed_ratio']} of speed, "
                f"saturated in {shown['saturated_fraction']} of the ticks"
            ),
        ),
        *power_rows(power_forecast(rollout)),
        ("Controller", _controller(rollout)),
        (
            "Computing",
            (
                f"{shown['real_time_factor']}, a tick {shown['tick_median_s']}, p99 "
                f"{shown['tick_p99_s']} at {shown['control_rate_hz']}"
            ),
        ),
    ]


def _world(rollout: Rollout) -> str:
    scenario, disturbance = rollout.scenario, rollout.disturbance
    parts = []
    if scenario.board > 0:
        kind = "half board" if scenario.half_board else "board"
        parts.append(f"{kind} of {decimal(1e3 * scenario.board)} mm")
    if scenario.seed is None or scenario.noise is None:
        parts.append("undisturbed")
    else:
        parts.append(
            f"seed {scenario.seed} with noise {short(scenario.noise)}: "
            f"trunk {percent(disturbance.trunk_mass_factor - 1, 1, signed=True)}, "
            f"friction {decimal(disturbance.friction, 2)}, "
            f"contacts {decimal(1e3 * disturbance.contact_time)} ms, "
            f"torque delayed by {counted(disturbance.torque_delay_ticks, 'tick')}"
            + ("" if scenario.drives == "ideal" else f", {_drives(disturbance)}")
        )
    if scenario.trunk_mass is not None:
        parts.append(f"trunk {percent(scenario.trunk_mass, 1, signed=True)} of its believed mass")
    if scenario.drives != Scenario.drives:
        parts.append(f"{scenario.drives} drives")
    if scenario.estimator != Scenario.estimator:
        parts.append(f"estimator {scenario.estimator}")
    return ", ".join(parts)


def _drives(of: Disturbance) -> str:
    """For instance "rotors +12.0 %, joint friction 1.4 ×"."""
    rotors = percent(of.armature_factor - 1, 1, signed=True)
    return f"rotors {rotors}, joint friction {decimal(of.joint_friction_factor, 1)} ×"


def drive_rows(robot: Robot) -> list[TitledValue]:
    """The numbers of a robot's drives, a limb's from the base outwards, and how they are known."""
    known, rows = known_drives(robot.file), []
    limbs = [("", robot.legs[0].joints), *(("arms.", arm.joints) for arm in robot.arms[:1])]
    for of, joints in limbs:
        index = [robot.joint_names.index(name) for name in joints]
        sliding = bool({*joints} & robot.sliding_joints)
        for name, title, units in _LOSSES:
            shown = ", ".join(short(value, 3) for value in getattr(robot, name)[index])
            unit = " or ".join(units if sliding else units[:1])
            row = f"Arms' {title.lower()}" if of else title
            rows.append((row, f"{shown} {unit}, {known[of + name]}"))
    return [*rows, ("Delay", f"{short(1e3 * robot.drive_delay, 3)} ms, {known['delay']}")]


def push_words(push: Push) -> str:
    """For instance "0, 12, 0 N s at 0.400 s"."""
    vectors = [(push.impulse, "N s"), (push.moment, "N m s")]
    sizes = [
        f"{', '.join(short(value, 3) for value in vector)} {unit}"
        for vector, unit in vectors
        if any(vector) or unit == "N s"
    ]
    return f"{' and '.join(sizes)} at {decimal(push.time, 3)} s"


def followed_plans(rollout: Rollout) -> str:
    """How many of the plans made in the simulation the controller took over: "3 of 5"."""
    replans = rollout.replans
    return f"{sum(math.isfinite(replan.applied) for replan in replans)} of {len(replans)}"


def _touchdown(outcome: Outcome) -> str:
    shown, true, detected = InWords(outcome), outcome.touchdown_true_s, outcome.touchdown_detected_s
    parts = [f"planned {shown['touchdown_planned_s']}"]
    parts.append("never came" if true is None else f"came {shown['touchdown_true_s']}")
    if detected is None:
        parts.append("not detected")
    else:
        late = "" if true is None else f" ({decimal(1e3 * (detected - true), 1, signed=True)} ms)"
        parts.append(f"detected {shown['touchdown_detected_s']}{late}")
    return ", ".join([*parts, f"{outcome.false_touchdowns} false"])


def _controller(rollout: Rollout) -> str:
    outcome, scenario = rollout.outcome, rollout.scenario
    words = f"landing strategy {outcome.landing_strategy or scenario.landing}"
    if scenario.landing == "auto" and outcome.landing_strategy == "tracking":
        words += " (the robot file has no force phase)"
    if not outcome.unsolved_ticks:
        return f"{words}, QP solved in every tick"
    return f"{words}, QP unsolved in {outcome.unsolved_ticks} of {len(rollout.time)} ticks"


# ---- drives


def power_rows(forecast: PowerForecast) -> list[TitledValue]:
    """Powers that drives and battery give and take back, where known."""
    of, rows = forecast, []
    if of.peak_w is not None and of.peak_s is not None:
        back = f"{_watts(of.back_w)} at {decimal(of.back_s or 0.0, 2)} s"
        energy = f"{decimal(of.energy_j or 0.0)} J given, {decimal(of.energy_back_j or 0.0)} J back"
        peak = f"{_watts(of.peak_w)} at {decimal(of.peak_s, 2)} s"
        rows.append(("Peak power", f"{peak}, takes back {back}; {energy}"))
    if of.electrical_peak_w is not None and of.heat_j is not None:
        current = of.battery_current_a
        amperes = "" if current is None else f", {decimal(current)} A"
        hottest = max(of.heat_j, key=of.heat_j.__getitem__)
        heat = f"{decimal(of.heat_j[hottest])} J of heat in the winding of {hottest}"
        rows.append(("Battery", f"gives up to {_watts(of.electrical_peak_w)}{amperes}; {heat}"))
    return rows


def _watts(watts: float | None) -> str:
    """For instance "1.9 kW" or "640 W"."""
    watts = watts or 0.0
    return f"{decimal(watts / 1e3, 1)} kW" if watts >= 1e3 else f"{decimal(watts)} W"


def power_cut(certificate: Certificate) -> str:
    """When the robot will cut its power, and why; "" if it will not."""
    cuts = sorted((found.time_s or 0.0, found) for found in certificate.broken if found.why == CUT)
    if not cuts:
        return ""
    time, found = cuts[0]
    return f"The robot will cut its power at {decimal(time, 2)} s: {found.name.replace('_', ' ')}."


def counted(count: int, thing: str) -> str:
    """For instance "1 tick" or "3 ticks"."""
    return f"{count} {thing}" if count == 1 else f"{count} {thing}s"


def _ms(seconds: float) -> str:
    return f"{decimal(1e3 * seconds)} ms"

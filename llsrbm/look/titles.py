"""Short names of designs: what matters about one, and what tells several apart."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory
from llsrbm.request.jump import INCLINES, Jump
from llsrbm.request.route import SLOPES, Landing
from llsrbm.request.scenario import Push, Scenario
from llsrbm.request.tuning import Tuning
from llsrbm.robots import read_robot_file
from llsrbm.robots.schema import robot_files

Decisions = tuple[Jump, Tuning, Scenario | None]
"""What a title is made from; without a scenario where nothing is simulated."""

WHOLE_BODY = "whole body"
"""In place of the model, for plans that are the whole body's, whatever model they began with."""

_MODELS = {"srbm": "SRBM", "llsrbm": "LL-SRBM", "llsrbm-plus": "LL-SRBM+"}

_ALWAYS = ("robot", "task", "model")
_LISTED = 2  # landings of a route; more would be cut wherever there is a line for a title
_IN_WORDS = (  # fields of a scenario whose names and values alone would say too little
    *("board", "half_board", "trunk_mass"),
    *("pushes", "random_push", "estimator", "replan", "replan_latency"),
)


def title_of(jump: Jump, tuning: Tuning | None = None, scenario: Scenario | None = None) -> str:
    """A design's name by what was decided about it: "90° llsrbm-plus, friction 0.4"."""
    return _joined(_parts(jump, tuning or Tuning(), scenario))


def title(trajectory: Trajectory) -> str:
    """Robot, jump and model of a motion, whatever robot it is: "Unitree Go2: 90° LL-SRBM+"."""
    jump, tuning, scenario = decisions_of(trajectory)
    task = title_of(replace(jump, robot=Jump().robot), tuning, scenario)
    return f"{title_of_robot(jump.robot)}: {task}"


def decisions_of(trajectory: Trajectory) -> Decisions:
    """A motion's, with its model as in menus, or the whole body in its place."""
    if isinstance(trajectory, Plan):
        plan, scenario = trajectory, None
    else:
        plan, scenario = trajectory.plan, trajectory.scenario
    model = WHOLE_BODY if plan.refined else title_of_model(plan.jump.model)
    return replace(plan.jump, model=model), plan.tuning, scenario


def title_of_model(name: str) -> str:
    """As in menus: "LL-SRBM+"."""
    return _MODELS.get(name, name)


def title_of_robot(name: str) -> str:
    """As in menus: "Unitree Go2"; of a robot that is none of the built-in ones its file's name."""
    files = robot_files()
    return read_robot_file(files[name]).title if name in files else Path(name).stem


def file_words(jump: Jump) -> str:
    """A request in the letters of a file's name: "twist90_forward30cm", "backflip", "hops2_up10cm".

    Whole degrees and centimetres; the model where it is not the default.
    """
    turns = [
        *_turns(jump.pitch, "frontflip", "backflip"),
        *_turns(jump.roll, "roll-right", "roll-left"),
    ]
    parts = [words.replace(" x ", "x") for words in turns]
    if jump.hops > 1:
        parts = [f"hops{jump.hops}", *parts]
    if jump.route:
        parts = [f"route{len(jump.route)}", *parts]
    parts += [f"gap{round(100 * jump.gap)}cm"] if jump.gap else []
    parts += [f"bar{round(100 * jump.bar)}cm"] if jump.bar else []
    if _is_worth_naming(jump):
        parts = [Path(jump.type).stem, *parts]
    if degrees := round(math.degrees(jump.twist)):
        parts.append(f"twist{degrees}")
    parts += [
        f"{onwards if length > 0 else backwards}{centimetres}cm"
        for length, onwards, backwards in _moves(jump)
        if (centimetres := round(100 * abs(length)))
    ]
    parts += [
        f"{name.replace('_', '-')}{degrees}"
        for name in INCLINES
        if (degrees := round(math.degrees(getattr(jump, name))))
    ]
    parts = parts or ["on-the-spot"]
    if jump.model != Jump.model:
        parts.append(jump.model)
    return "_".join(parts)


def titles_of(designs: Sequence[Decisions]) -> tuple[str, ...]:
    """Names of several designs beside each other: the jump and model of each, and what differs.

    What they all share besides is left out; designs that are named alike are numbered.
    """
    every = [_parts(*design) for design in designs]
    keys = {key for parts in every for key in parts}
    differing = {key for key in keys if len({parts.get(key) for parts in every}) > 1}
    differing |= {"task", "model"}
    titles = [
        _joined({key: text for key, text in parts.items() if key in differing}) for parts in every
    ]
    counts, seen = Counter(titles), Counter[str]()
    for index, title in enumerate(titles):
        if counts[title] > 1:
            seen[title] += 1
            titles[index] = f"{title} ({seen[title]})"
    return tuple(titles)


def _parts(jump: Jump, tuning: Tuning, scenario: Scenario | None) -> dict[str, str]:
    """The decisions in order, key -> words; no defaults but the model's."""
    parts = {}
    if jump.robot != Jump().robot:
        parts["robot"] = Path(jump.robot).stem
    parts |= {"task": _task(jump), "model": jump.model}
    if jump.arms != Jump.arms:
        parts["arms"] = f"arms {jump.arms}"
    for name, value in {**tuning.weights, **tuning.limits}.items():
        parts[f"tuning {name}"] = f"{name.replace('_', ' ')} {value:g}"
    if scenario is None:
        return parts
    for name, value in scenario.stated().items():
        if name not in _IN_WORDS:
            parts[name] = f"{name} {value:g}" if isinstance(value, float | int) else str(value)
    if scenario.trunk_mass is not None:
        parts["trunk_mass"] = f"trunk {100 * scenario.trunk_mass:+g} %"
    if scenario.board:
        kind = "half board" if scenario.half_board else "board"
        parts["board"] = f"{kind} {1e3 * scenario.board:g} mm"
    if scenario.pushes:
        parts["pushes"] = _pushes(scenario.pushes)
    if scenario.random_push is not None:
        parts["random_push"] = f"random push {scenario.random_push:g} N s"
    if scenario.estimator != Scenario.estimator:
        parts["estimator"] = f"estimator {scenario.estimator}"
    if scenario.replan:
        parts["replan"] = "replanning"
    if scenario.replan_latency != Scenario.replan_latency:
        parts["replan_latency"] = f"replan latency {scenario.replan_latency}"
    return parts


def _pushes(pushes: Sequence[Push]) -> str:
    """One push by size and moment, several by their number: "push 12 N s at 0.45 s"."""
    if len(pushes) > 1:
        return f"{len(pushes)} pushes"
    (push,) = pushes
    sizes = [(push.impulse, "N s"), (push.moment, "N m s")]
    parts = [f"{math.hypot(*vector):.3g} {unit}" for vector, unit in sizes if any(vector)]
    return f"push {' + '.join(parts) or 'of nothing'} at {push.time:.3g} s"


def _task(jump: Jump) -> str:
    """The jump itself: "90° + 30 cm forward", "back flip", "2 hops of 20 cm forward"."""
    turns = [
        *_turns(jump.pitch, "front flip", "back flip"),
        *_turns(jump.roll, "roll to the right", "roll to the left"),
    ]
    task = " + ".join([*turns, *_components(jump)])
    if not (task or jump.gap or jump.bar):
        task = "on the spot"
    if jump.route:
        task = f"route: {', '.join(map(landing_words, jump.route))}"
        if len(jump.route) > _LISTED:
            task = f"route of {len(jump.route)} landings"
    if jump.hops > 1:
        of = "of " if turns or _components(jump) else ""
        task = f"{jump.hops} hops {of}{task}"
    if _is_worth_naming(jump):
        task = f"{Path(jump.type).stem} {task}".rstrip()
    if passed := jump.gap or jump.bar:
        task += f" of {round(100 * passed, 1):g} cm"
    for name in INCLINES:
        if angle := round(math.degrees(getattr(jump, name)), 1):
            task += f", {name.replace('_', ' ').replace('takeoff', 'take-off')} {angle:g}°"
    if jump.speed:
        task += f" from {jump.speed:g} m/s"
    if jump.end_speed:
        task += f" to {jump.end_speed:g} m/s"
    return task


def landing_words(landing: Landing) -> str:
    """Where a landing of a route is: "30 cm forward + 10 cm up, slope 10°"."""
    slopes = [
        f", {name.replace('_', ' ')} {angle:g}°"
        for name in SLOPES
        if (angle := round(math.degrees(getattr(landing, name)), 1))
    ]
    return (" + ".join(_components(landing)) or "on the spot") + "".join(slopes)


def _components(place: Jump | Landing) -> list[str]:
    """Where a jump leads: "90°", "30 cm forward"."""
    parts = [f"{round(math.degrees(place.twist), 1):g}°"] if place.twist else []
    parts += [
        f"{round(100 * abs(length), 1):g} cm {onwards if length > 0 else backwards}"
        for length, onwards, backwards in _moves(place)
        if length
    ]
    return parts


def _moves(jump: Jump | Landing) -> tuple[tuple[float, str, str], ...]:
    """Displacements, m, and their directions in words where they are positive and negative."""
    return (
        (jump.forward, "forward", "back"),
        (jump.lateral, "left", "right"),
        (jump.height, "up", "down"),
    )


def _is_worth_naming(jump: Jump) -> bool:
    """Whether the type is neither the default nor implied by hops or turns; it may be a file."""
    implied = {"hops": jump.jumps > 1, "flip": bool(jump.turns)}
    return jump.type != Jump.type and not implied.get(jump.type, False)


def _turns(angle: float, onwards: str, backwards: str) -> list[str]:
    """Whole turns in words, if there are any: "back flip", "2 x back flip"."""
    count = round(abs(angle) / math.tau)
    words = onwards if angle > 0 else backwards
    return [words if count == 1 else f"{count} x {words}"] if count else []


def _joined(parts: dict[str, str]) -> str:
    head = " ".join(parts[key] for key in _ALWAYS if key in parts)
    return ", ".join([head, *(text for key, text in parts.items() if key not in _ALWAYS)])

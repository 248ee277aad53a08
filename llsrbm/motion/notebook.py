"""Plans and rollouts in a notebook: the replay in a frame, or else a short table of figures."""

import math
import tempfile
from html import escape
from importlib.metadata import entry_points
from pathlib import Path

from llsrbm.errors import Error
from llsrbm.motion.plan import Plan
from llsrbm.motion.trajectory import Trajectory
from llsrbm.request.jump import Jump

LARGEST = 4_000_000
"""Bytes of a replay that a notebook takes in; it keeps each one that is shown."""

_HEIGHT = 560  # pixels
_FORMAT = "html"  # entry point of `llsrbm.formats`: the library does not know the page
_ALONE = "allow-scripts allow-downloads"  # the frame has no part in the notebook's own origin
_AS_FILE = 'llsrbm.export(motion, "jump.html", format="html") writes it as a file'


def notebook_html(trajectory: Trajectory) -> str:
    """A plan or a rollout as a notebook shows it, with the size of what is shown.

    Without the package that replays, or with a replay of more than `LARGEST` bytes, a table that
    says so.
    """
    try:
        page = _replay(trajectory)
    except Error as error:
        return _table(trajectory, f"No replay: {error}")
    if page is None:
        return _table(trajectory, f'No replay: format "{_FORMAT}" is not installed.')
    size = len(page.encode())
    if size > LARGEST:
        limit = f"more than the {LARGEST / 1e6:g} MB that a notebook takes in"
        return _table(trajectory, f"No replay: it has {size / 1e6:.1f} MB, {limit}. {_AS_FILE}.")
    content = page.replace("&", "&amp;").replace('"', "&quot;")
    return (
        f'<iframe sandbox="{_ALONE}" title="{escape(_title(trajectory))}" srcdoc="{content}" '
        f'style="width: 100%; height: {_HEIGHT}px; border: 0"></iframe>'
        f"<div>{escape(_title(trajectory))}: a replay of {size / 1e6:.1f} MB, kept in the "
        "notebook.</div>"
    )


def line(trajectory: Trajectory) -> str:
    """A plan or a rollout as text: its kind, robot and request, and how it ended."""
    if isinstance(trajectory, Plan):
        ended = f"{trajectory.report.status}, {_certified(trajectory)}"
    else:
        ended = trajectory.outcome.status + (", strict" if trajectory.outcome.strict else "")
    of_it = f"{Path(trajectory.jump.robot).stem}: {_request(trajectory.jump)}"
    lasts = f"{len(trajectory.time)} instants in {trajectory.duration:.2f} s"
    return f"<{type(trajectory).__name__} of {of_it}; {ended}; {lasts}>"


def _certified(plan: Plan) -> str:
    return "its certificate holds" if plan.certified else "not certified"


def _replay(trajectory: Trajectory) -> str | None:
    for point in entry_points(group="llsrbm.formats", name=_FORMAT):
        format_ = point.load()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"replay{format_.suffix}"
            format_.write(trajectory, path, format_.defaults)
            return path.read_text(encoding="utf-8")
    return None


def _title(trajectory: Trajectory) -> str:
    kind = "plan" if isinstance(trajectory, Plan) else "simulation"
    return f"{Path(trajectory.jump.robot).stem}, {kind} of {_request(trajectory.jump)}"


def _request(jump: Jump) -> str:
    plain = Jump().as_dict()
    stated = {n: v for n, v in jump.as_dict().items() if v != plain.get(n) and n != "robot"}
    words = (f"{n} {v:.4g}" if isinstance(v, float) else f"{n} {v}" for n, v in stated.items())
    return ", ".join(words) or "a jump on the spot"


def _table(trajectory: Trajectory, why: str) -> str:
    rows = "".join(
        f"<tr><th>{escape(name)}</th><td>{escape(value)}</td></tr>"
        for name, value in _figures(trajectory)
    )
    title = escape(_title(trajectory))
    return f"<table><caption>{title}</caption>{rows}</table><div>{escape(why)}</div>"


def _figures(trajectory: Trajectory) -> list[tuple[str, str]]:
    rows = [("Duration", f"{trajectory.duration:.2f} s")]
    if isinstance(trajectory, Plan):
        return [*rows, ("Plan", f"{trajectory.report.status}, {_certified(trajectory)}")]
    outcome = trajectory.outcome
    rows.append(("Outcome", f"{outcome.status} {outcome.reason}".strip()))
    if outcome.yaw_error_at_touchdown is not None:
        error = math.degrees(outcome.yaw_error_at_touchdown)
        rows.append(("Yaw error at touchdown", f"{error:.1f}°"))
    return [*rows, ("Peak torque", f"{100 * outcome.peak_torque_ratio:.0f} % of the limit")]

"""A plan or a rollout as a file for the browser."""

from __future__ import annotations

import tempfile
from pathlib import Path

from llsrbm.exporters import export, suffix
from llsrbm.trajectory.plan import Plan
from llsrbm.trajectory.rollout import Rollout


def exported(trajectory: Plan | Rollout, format_name: str) -> tuple[str, bytes]:
    """File name and content.

    Raises:
        llsrbm.errors.Error: the format cannot hold it.
    """
    jump = trajectory.jump
    kind = "plan" if isinstance(trajectory, Plan) else "rollout"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{jump.robot}-{jump.model}-{kind}{suffix(format_name)}"
        export(trajectory, path, format=format_name)
        return path.name, path.read_bytes()

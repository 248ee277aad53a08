"""`OfRobot`: names in a plan or a rollout, of the robot as it was."""

from __future__ import annotations

from typing import Any


class OfRobot:
    """Names in a plan or a rollout, of the robot as it was."""

    robot_parameters: dict[str, Any]
    foot_position: Any
    schedule: Any

    @property
    def sliding_joints(self) -> frozenset[str]:
        """Names of the joints whose position is in metres."""
        return frozenset(self.robot_parameters.get("sliding_joints", ()))

    @property
    def leg_names(self) -> tuple[str, ...]:
        """As in the robot file, where the robot's numbers hold them."""
        legs, count = tuple(self.robot_parameters.get("legs", ())), self.foot_position.shape[1]
        return legs if len(legs) == count else tuple(f"leg{i}" for i in range(count))

    @property
    def phase_names(self) -> tuple[str, ...]:
        """(P,) what the numbers of `phase` stand for."""
        return self.schedule.names

    def __repr__(self: Any) -> str:
        """A line, where the fields would fill pages."""
        from llsrbm.motion.notebook import line

        return line(self)

    def _repr_html_(self: Any) -> str:
        """Show it in a notebook: its replay, or a table of figures."""
        from llsrbm.motion.notebook import notebook_html

        return notebook_html(self)

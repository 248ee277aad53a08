"""Motions from files without a plan of this project's: for looking and comparing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.motion.frames import Frames, make_frames
from app.motion.simulated_motion import bake_rollout
from llsrbm.analysis.figures import DesignFigures, figures_of_motion, figures_of_rollout
from llsrbm.motion.rollout import Rollout
from llsrbm.motion.whole_body import WholeBodyMotion, motion_at_ticks


@dataclass(frozen=True, eq=False)
class ForeignMotion:
    """A motion, ready to be drawn.

    Attributes:
        name: of its file.
        motion: at the file's own instants.
        frames: of the robot.
        figures: its row in the comparison.
    """

    name: str
    motion: WholeBodyMotion
    frames: Frames
    figures: DesignFigures


def bake_foreign(name: str, motion: WholeBodyMotion | Rollout) -> ForeignMotion:
    """All frames of a motion.

    Args:
        name: of its file.
        motion: of another tool, or a rollout whose file does not hold the plan that was followed.
    """
    if isinstance(motion, Rollout):
        return ForeignMotion(
            name,
            motion_at_ticks(motion, np.arange(len(motion.time))),
            bake_rollout(motion).frames,
            figures_of_rollout(motion),
        )
    return ForeignMotion(name, motion, make_frames(motion), figures_of_motion(motion))

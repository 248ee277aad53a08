"""Reading motions that trainers and retargeters pickle, of which nothing is run as they are read.

- GMR's: `root_pos`, `root_rot` x, y, z, w, `dof_pos`, `fps`.
- Of human2humanoid and its kin, PHC and ASAP: `root_trans_offset`, `root_rot` x, y, z, w, `dof`,
  `fps`, by joblib or not; in a dictionary of clips by name, of which there is one.
- MimicKit's: `frames` of root, exponential map and joints, `fps`.

None names its joints. They are those of the JSON file beside it, under its name and ".meta.json",
else told by their number: limb after limb as the URDF lists them, held ones among them or not.
"""

from collections.abc import Sequence, Set
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from llsrbm.arrays import Array
from llsrbm.errors import FileFormatError, printable
from llsrbm.files.pickles import read_pickle
from llsrbm.formats.base import ORDERS, joints_beside, read_beside
from llsrbm.formats.foreign import (
    VARIANTS,
    WITHOUT_WRISTS,
    checked_motion,
    checked_rate,
    joint_columns,
    joint_orders,
    one_rate,
)
from llsrbm.motion.bodies import body_order
from llsrbm.motion.whole_body import WholeBodyMotion
from llsrbm.robots import Robot

PICKLES = (".pkl", ".pickle", ".p")
_WXYZ = [3, 0, 1, 2]
_NAMED = 8  # clips or keys that a message names


class _Layout(NamedTuple):
    """Keys of a dictionary: of the root's place, m, its attitude, x y z w, and the joints'."""

    position: str
    attitude: str
    joints: str
    variants: Sequence[Set[str]]


_LAYOUTS = (
    _Layout("root_pos", "root_rot", "dof_pos", VARIANTS),
    _Layout("root_trans_offset", "root_rot", "dof", WITHOUT_WRISTS),
)
_FRAMES = "frames"  # MimicKit's key of all numbers
_EXPECTED = " or ".join(
    (*(f'"{each.position}", "{each.attitude}" and "{each.joints}"' for each in _LAYOUTS), "frames")
)


def read_clip(path: Path, robot: Robot, fps: float | None) -> WholeBodyMotion:
    """The motion in a trainer's pickle; `fps`: frames/s of a file that does not say them.

    Raises `FileFormatError`: another layout, several clips, other joints, damage.
    """
    clip = _clip(read_pickle(path), path)
    qpos, variants = _states(clip, path)
    joints = qpos[:, 7:]
    names = joints_beside(read_beside(path), path)
    if names is None:
        names = _names(joints.shape[1], robot, variants, path)
    columns, remarks = joint_columns(names, joints, robot, str(path))
    stated, requested = (
        None if each is None else checked_rate(each, f"{path}: fps")
        for each in (clip.get("fps"), fps)
    )
    rate, of_rates = one_rate(stated, requested)
    if rate is None:
        raise FileFormatError(f'{path}: key "fps" is missing; expected frames per second with it')
    states = np.hstack([qpos[:, :7], joints[:, columns]])
    found = (*of_rates, *remarks)
    origin = "mimickit-pkl" if _FRAMES in clip else "gmr-pkl"
    return checked_motion(robot, origin, str(path), rate, states, remarks=found, w_first=False)


def _clip(content: Any, path: Path) -> dict[str, Any]:
    if not isinstance(content, dict):
        raise FileFormatError(f"{path}: expected a dictionary with {_EXPECTED}")
    if content and all(isinstance(each, dict) for each in content.values()):
        if len(content) > 1:
            raise FileFormatError(
                f"{path}: has {len(content)} clips ({_listed(content)}); expected a file of each"
            )
        return dict(*content.values())
    return content


def _states(clip: dict[str, Any], path: Path) -> tuple[Array, Sequence[Set[str]]]:
    """(K, 7 + n) root, w x y z, and joints; and what files of that layout leave out of G1."""
    for layout in _LAYOUTS:
        if set(layout[:3]) <= clip.keys():
            position, attitude, joints = (_numbers(clip[key], key, path) for key in layout[:3])
            if not (position.shape[1] == 3 and attitude.shape[1] == 4):
                break
            if len(position) == len(attitude) == len(joints):
                return np.hstack([position, attitude[:, _WXYZ], joints]), layout.variants
    else:
        if _FRAMES in clip:
            rows = _numbers(clip[_FRAMES], _FRAMES, path)
            if rows.shape[1] > 6:
                attitude = Rotation.from_rotvec(rows[:, 3:6]).as_quat(scalar_first=True)
                return np.hstack([rows[:, :3], attitude, rows[:, 6:]]), VARIANTS
    raise FileFormatError(
        f"{path}: has {_listed(clip) or 'no keys'}; expected {_EXPECTED}, with as many frames each"
    )


def _numbers(value: Any, key: str, path: Path) -> Array:
    """(K, n) of a value; raises `FileFormatError`: it is none such."""
    try:
        found = np.asarray(value, dtype=np.float64)
        return found.reshape(len(found), -1)
    except (TypeError, ValueError) as error:
        raise FileFormatError(f'{path}: key "{key}": expected a row of numbers a frame') from error


def _names(count: int, robot: Robot, variants: Sequence[Set[str]], path: Path) -> list[str]:
    orders = joint_orders(body_order(robot, ORDERS[0]).joints, robot, variants)
    if count not in orders:
        counts = " or ".join(str(each) for each in sorted(orders))
        raise FileFormatError(
            f"{path}: has {count} joints; expected {counts} of robot {robot.name}, or "
            f"{path.name}.meta.json beside it with their names as joint_order"
        )
    return list(orders[count])


def _listed(names: dict[str, Any]) -> str:
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return printable(", ".join([*names][:_NAMED]), 200) + more

"""GMR's motion of a robot: a pickled dictionary of arrays.

`fps`; `root_pos` (T, 3) m: origin of the root link; `root_rot` (T, 4): its attitude x, y, z, w
(w last) without jumps of sign; `dof_pos` (T, J) rad, m for joints that slide; `local_body_pos`
(T, B, 3) m: origins of the B = 1 + J bodies in the root link's frame; `link_body_list`: their
names. World frame, z up. Joints and bodies are in MuJoCo's order: leg after leg as the URDF lists
them, the root first. 30 frames/s unless asked otherwise, GMR's own rate.

The arrays are pickled such that NumPy 1 and 2 open them. A JSON file beside it has request, robot,
solver and the names of the joints. Files like this one are not opened here: a pickle can run
anything.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from llsrbm.formats.base import ORDERS, Format, Options
from llsrbm.formats.references.plain_pickle import write_pickle
from llsrbm.formats.sidecar import write_sidecar
from llsrbm.mechanics import rotation_matrices
from llsrbm.motion.bodies import body_motion
from llsrbm.motion.trajectory import Trajectory
from llsrbm.motion.whole_body import whole_body_motion


def write_gmr(trajectory: Trajectory, path: Path, options: Options) -> None:
    """Write the dictionary, and what it does not say beside it."""
    motion = whole_body_motion(trajectory, options.fps, options.pad)
    bodies = body_motion(motion, ORDERS[0])
    from_root = bodies.position - motion.base_position[:, None]
    R_world_base = rotation_matrices(motion.base_quat)
    write_pickle(
        path,
        {
            "fps": options.fps,
            "root_pos": motion.base_position,
            "root_rot": motion.base_quat[:, [1, 2, 3, 0]],
            "dof_pos": motion.joint_position[:, list(bodies.order.joint_index)],
            "local_body_pos": np.einsum("kji,kbj->kbi", R_world_base, from_root),
            "link_body_list": list(bodies.order.bodies),
        },
    )
    write_sidecar(
        path,
        trajectory,
        GMR_PKL.name,
        fps=options.fps,
        pad=options.pad,
        quaternion_order="xyzw",
        joint_order=list(bodies.order.joints),
    )


GMR_PKL = Format(
    name="gmr-pkl",
    title="motion as GMR saves it: root, quaternion x y z w, joints and bodies, pickled",
    suffix=".pkl",
    write=write_gmr,
    conventions=__doc__,
    options=("fps", "pad"),
    defaults=Options(fps=30.0),
)

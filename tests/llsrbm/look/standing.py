import numpy as np
import pinocchio as pin

from llsrbm.look.visuals import forward_kinematics


def standing(robot, visuals):
    """All vertices, (V, 3) m, the robot in its default posture."""
    position, quat = forward_kinematics(
        robot, robot.base_position[None], [[1, 0, 0, 0]], robot.posture[None, 7:]
    )
    points = []
    for visual in visuals:
        w, x, y, z = quat[0, visual.joint_id - 1]
        R = pin.Quaternion(w, x, y, z).matrix()
        points.append(visual.vertices @ R.T + position[0, visual.joint_id - 1])
    return np.vstack(points)

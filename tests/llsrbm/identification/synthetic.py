"""Logs of a robot that follows its equations of motion exactly: no simulator, no noise."""

import numpy as np
import pinocchio as pin

from llsrbm.identification import Log
from llsrbm.identification.excitation import sines
from llsrbm.robots import load_robot

GO2 = load_robot("go2")
JOINTS = len(GO2.joint_names)
PERIOD = 0.002  # s
ARMATURE = np.linspace(0.004, 0.02, JOINTS)
FRICTION = np.linspace(0.1, 0.5, JOINTS)
DAMPING = np.linspace(0.02, 0.1, JOINTS)
DELAY = 0.0023  # s


def joint_torque(model, q, v, a, gyro=None, acceleration=None):
    """(J,) Nm of drives, base at rest and level or moved as an inertial unit has it."""
    data, full_v, full_a = model.createData(), np.zeros(model.nv), np.zeros(model.nv)
    full_q = pin.neutral(model)
    full_q[7:], full_v[6:], full_a[6:] = q, v, a
    if gyro is not None:
        # In a frame that falls freely and moves with the base at this instant.
        full_v[3:6] = gyro
        full_a[:3] = acceleration - 9.81 * np.array([0, 0, 1.0])
    links = pin.rnea(model, data, full_q, full_v, full_a)[6:]
    return links + ARMATURE * a + FRICTION * np.sign(v) + DAMPING * v


def synthetic_log(seconds=12.0, delay=DELAY, moving=slice(None), period=PERIOD):
    """A log of the excitation; joints that are not `moving` rest."""
    model = GO2.model.copy()
    model.armature[:] = 0.0
    times = period * np.arange(round(seconds / period))
    motion = sines(GO2, seconds)
    share = np.zeros(JOINTS)
    share[moving] = 1.0
    motion = motion.scaled(share)
    q, v, _ = motion.at(times)
    # Of what is held for a period the middle is half a period later.
    acting = motion.at(times + delay + period / 2)
    tau = np.array([joint_torque(model, *state) for state in zip(*acting, strict=True)])
    usable = np.ones(len(times), dtype=bool)
    return Log("synthetic.csv", period, q, v, tau, np.zeros_like(tau), usable)


def as_csv(log, path, columns=None, rows=slice(None)):
    """The log as a file; `columns` changes the table by name."""
    table = {"time": PERIOD * np.arange(len(log.q))}
    for kind, values in (("q", log.q), ("dq", log.dq), ("tau", log.sent)):
        table |= {f"{kind}:{name}": values[:, k] for k, name in enumerate(GO2.joint_names)}
    table = table if columns is None else columns(table)
    text = ",".join(table)
    values = np.column_stack(list(table.values()))[rows]
    np.savetxt(path, values, delimiter=",", header=text, comments="", fmt="%.9g")
    return path

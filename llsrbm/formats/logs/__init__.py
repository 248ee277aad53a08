"""Logs for viewers. The writers need packages that a plain installation does not have."""

from pathlib import Path

from llsrbm.formats.base import Extra, Format, Options, Purpose
from llsrbm.motion.trajectory import Trajectory


def _write_mcap(trajectory: Trajectory, path: Path, options: Options) -> None:
    from llsrbm.formats.logs.mcap_log import write

    about = MCAP.described(trajectory, options, quaternion_order="xyzw")
    write(trajectory, path, options.fps, about)


def _write_rrd(trajectory: Trajectory, path: Path, options: Options) -> None:
    from llsrbm.formats.logs.rerun_log import TIMELINE, write

    about = RRD.described(trajectory, options, timeline=TIMELINE)
    write(trajectory, path, options.fps, about)


MCAP = Format(
    name="mcap",
    title="a log for Foxglove and other viewers: joint states, transforms, forces, numbers to plot",
    purpose=Purpose.LOOKING,
    suffix=".mcap",
    write=_write_mcap,
    conventions="""\
A log for Foxglove, rerun and other viewers of MCAP: Foxglove's protobuf schemas.

Log time is ns from 0 at the motion's first instant; messages are 1/fps apart, and there are some
exactly at each lift-off and touchdown (of a rollout: at each change of contact, phase or mode).
Topics, of a rollout for the simulated robot, under /plan/ for the plan that it followed:
  /joint_states       foxglove.JointStates by name: rad or m, per s, effort = torque in Nm or N;
                      joints that the robot's file holds too, without effort
  /tf, /tf_static     foxglove.FrameTransforms from link to link as in the URDF, "world" above the
                      root link, so a URDF layer moves; the plan's frames begin with "plan/", which
                      is the layer's frame prefix then
  /robot              foxglove.SceneUpdate once: the links' meshes, for viewers without the URDF
  /base, /com         foxglove.PoseInFrame in "world"; the CoM's turns with the inertia's axes
  /inertia            foxglove.SceneUpdate: the uniform solid of the same mass and inertia
  /contact_forces     foxglove.SceneUpdate: arrows, 0.8 m as large as the weight
  /state              JSON with a schema, to plot: CoM, momenta, principal moments, base, contacts,
                      forces, joints, torques as shares of their limits; com.x, foot_force.LF.z, ...
  /scene              foxglove.SceneUpdate: ground, box, board, as they come and go
  /reference          JSON, of a rollout: what the controller tracked
rerun draws /tf, /base and /com of it and keeps the rest as it is; format "rrd" has everything.
World frame, SI units; Foxglove's quaternions are x, y, z, w by name, without jumps of sign. Doubles
all through, meshes' too. Everything beside the numbers is the attachment llsrbm.json, and in parts
the metadata record "llsrbm".
""",
    options=("fps",),
    defaults=Options(fps=200.0),
    extra=Extra("mcap", ("foxglove",)),
)

RRD = Format(
    name="rrd",
    title="a recording for rerun: the robot in 3D with forces and trails, and plots beside it",
    purpose=Purpose.LOOKING,
    suffix=".rrd",
    write=_write_rrd,
    conventions="""\
A recording for the rerun viewer, with a layout: the robot in 3D, and plots beside it.

Timeline "time", s from 0 at the motion's first instant; rows are 1/fps apart, and there are some
exactly at each lift-off and touchdown (of a rollout: at each change of contact, phase or mode).
  /world/robot/LINK   Transform3D of each moving body in the world, its mesh with vertex colours
  /world/plan/LINK    the plan that a rollout followed, where it is known: a translucent ghost
  /world/ground, /world/blocks/NAME, /world/com, /world/inertia (the uniform solid of the same mass
                      and inertia), /world/forces/LEG (arrows, 0.8 m as large as the weight),
                      /world/trails/com and /world/trails/LEG
  /plots/NAME         Scalars: com, momenta, principal_moments, base, contact, foot_force/LEG,
                      joints, torque_share (of the drives' limits); names of the parts and, in
                      their AnyValues, the unit
  /planned/NAME       the same of the plan, /tracked/NAME of what a rollout's controller tracked
  /description        who asked what of whom, to read; /description/json: all of it
World frame, x forward, z up; SI units. Scalars are doubles; rerun stores poses, meshes and arrows
as floats, so the base's pose and the joints are under /plots as well. Quaternions are x, y, z, w in
Transform3D and w, x, y, z in /plots, without jumps of sign. There are meshes in place of the URDF:
it names files of packages that other machines may not have.
""",
    options=("fps",),
    defaults=Options(fps=200.0),
    extra=Extra("rerun", ("rerun",)),
)

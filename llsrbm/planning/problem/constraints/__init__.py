"""Constraints of a plan: the paper's, and what a real robot needs beside them.

One small class each, found by name: rows for the solver, and their bounds in numbers. A finished
plan is checked by the same rows, evaluated again; what the whole body makes of it (drives,
clearance, turn) by Pinocchio. Adding a constraint is one class and its place in
`CONSTRAINTS`; limits that it has are rows of `problem.limit_table`.
"""

from llsrbm.planning.problem.constraints.apex_height import ApexHeight
from llsrbm.planning.problem.constraints.base import AgreedConstraint, Constraint
from llsrbm.planning.problem.constraints.body_clearance import BodyClearance
from llsrbm.planning.problem.constraints.contacts import FeetAtRest, FrictionPyramid, GivenContacts
from llsrbm.planning.problem.constraints.drives import DRIVES
from llsrbm.planning.problem.constraints.edge import Edge
from llsrbm.planning.problem.constraints.knees import KneeHeight, LegsApart
from llsrbm.planning.problem.constraints.motion import (
    MOMENTUM_BALANCE,
    ArmsAtRest,
    FinalPlace,
    FinalState,
    PhaseTimes,
    Rebound,
    ShortOfTurn,
    UprightLanding,
)
from llsrbm.planning.problem.constraints.reach import FeetApart, Reach
from llsrbm.planning.problem.constraints.shortfall import Shortfall
from llsrbm.planning.problem.constraints.stops import JointStops
from llsrbm.planning.problem.constraints.swing import Clearance, FootSpeed, PutDown
from llsrbm.planning.problem.constraints.truth import LegsReach, Rolling, TrueTurn, TurnsOver
from llsrbm.planning.problem.constraints.turn import FootTurn, FootYaw

__all__ = ["AGREED", "CONSTRAINTS", "Constraint"]

CONSTRAINTS: tuple[Constraint, ...] = (
    MOMENTUM_BALANCE,
    GivenContacts(),
    FeetAtRest(),
    FrictionPyramid(),
    PhaseTimes(),
    ApexHeight(),
    Reach(),
    Clearance(),
    Edge(),
    BodyClearance(),
    KneeHeight(),
    LegsApart(),
    FeetApart(),
    FootSpeed(),
    PutDown(),
    FootYaw(),
    FootTurn(),
    JointStops(),
    *DRIVES,
    UprightLanding(),
    Rebound(),
    ShortOfTurn(),
    FinalState(),
    ArmsAtRest(),
    FinalPlace(),
    Shortfall(),
    TrueTurn(),
    Rolling(),
    LegsReach(),
    TurnsOver(),
)

AGREED = tuple(c for c in CONSTRAINTS if isinstance(c, AgreedConstraint))
"""Those whose rows approximate what the check finds, and whose bounds are shifted accordingly."""

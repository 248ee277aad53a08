"""Quantities over time, described where `Plan` and `Rollout` declare their arrays.

    com: Annotated[Array, vector("m", "centre of mass", Between.BALLISTIC)]

`quantities(Plan)` collects these. Nothing else lists them: the native file writes what is declared,
a table has a column for each component, sampling mixes as `between` says, and `llsrbm formats`
prints them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from enum import Enum
from functools import cache
from typing import Any, get_type_hints

from llsrbm.arrays import Array

# Axes of arrays.
TIME = "time"
LEG, CONTACT, JOINT, BODY = "leg", "contact", "joint", "body"
REPLAN = "replan"
XYZ, WXYZ, TENSOR = "xyz", "wxyz", "tensor"
HIP = "hip"  # coordinates of a foot in its leg's mirrored hip frame
POSITION, VELOCITY = "qpos", "qvel"  # MuJoCo's coordinates of the whole robot
VARIABLE, ROW = "variable", "row"  # of the planner's problem
ERROR = "error"  # of the whole robot's state, its base's in the base's axes

# Their sizes; a letter stands for one that is the same wherever the letter occurs in a file.
SIZES: Mapping[str, tuple[int | str, ...]] = {
    TIME: ("T",),
    LEG: ("L",),
    CONTACT: ("C",),
    JOINT: ("J",),
    BODY: ("B",),
    REPLAN: ("R",),
    XYZ: (3,),
    WXYZ: (4,),
    TENSOR: (3, 3),
    HIP: ("D",),
    POSITION: ("Q",),
    VELOCITY: ("V",),
    ERROR: ("E",),
    VARIABLE: ("n",),
    ROW: ("m",),
}

# Names of what they hold; of a symmetric matrix the six entries that differ.
PARTS: Mapping[str, tuple[str, ...]] = {
    XYZ: ("x", "y", "z"),
    WXYZ: ("w", "x", "y", "z"),
    TENSOR: ("xx", "yy", "zz", "xy", "xz", "yz"),
}

_SLIDING = {
    "rad": "m",
    "rad/s": "m/s",
    "Nm": "N",
}  # unit of a joint that turns -> of one that slides


def entries(tensors: Array) -> Array:
    """(T, 6) of symmetric matrices (T, 3, 3), in the order of `PARTS`."""
    return tensors[:, [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


class Between(Enum):
    """Rule for a quantity between one instant and the next."""

    CONSTANT = "has no axis of time"
    HELD = "keeps its value over the interval that begins there"
    LINEAR = "straight"
    TURNING = "turns at a constant rate (slerp)"
    POSE = "straight, its quaternion turning at a constant rate"
    BALLISTIC = "cubic, with the slopes that the forces give it: exact where they are constant"
    IN_BASE = "each entry straight, seen in the base's axes"
    FROM_COM = "straight, seen from the CoM in the base's axes"
    STANDING = "still while a foot stands, else straight as seen from the CoM in the base's axes"
    CARRIED = "fixed to its foot"
    JOINTS = "cubic, with the joints' own velocities as slopes; makima where they are not known"
    JOINT_RATES = "the slope of the joints' positions"


class Kind(Enum):
    """Kind of numbers of a quantity."""

    REAL = "real"
    WHOLE = "whole"
    TEXT = "text"


@dataclass(frozen=True)
class Quantity:
    """Meaning, unit, frame and rules of one array.

    Attributes:
        axes: of the array, in order; their sizes are in `SIZES`.
        unit: SI; of an array along `JOINT`, that of joints that turn: see `unit_of`. "" for none.
        meaning: a phrase that says what it is, for people.
        between: what it is between two instants.
        frame: whose axes its components are along; "" where it has none.
        codes: what its whole numbers 0, 1, ... stand for; coded_by: the trajectory's attribute that
            says it where it is not always the same.
        rate: whether it vanishes at rest: it is zero before the motion and after it.
        listed: whether a table has columns for it; False for what others repeat in parts.
        column: its name in tables; "": its own.
    """

    axes: tuple[str, ...]
    unit: str
    meaning: str
    between: Between = Between.CONSTANT
    frame: str = ""
    kind: Kind = Kind.REAL
    codes: tuple[str, ...] = ()
    coded_by: str = ""
    rate: bool = False
    listed: bool = True
    column: str = ""

    @property
    def shape(self) -> tuple[int | str, ...]:
        """Sizes of the array, a letter for each that varies."""
        return tuple(size for axis in self.axes for size in SIZES[axis])

    def codes_of(self, trajectory: Any) -> tuple[str, ...]:
        """Meanings of the whole numbers in a plan or a rollout."""
        return tuple(getattr(trajectory, self.coded_by)) if self.coded_by else self.codes

    def unit_of(self, joint: str, sliding: frozenset[str]) -> str:
        """The unit of one joint's numbers: sliding joints have metres where others have radians."""
        return _SLIDING.get(self.unit, self.unit) if joint in sliding else self.unit


def vector(
    unit: str,
    meaning: str,
    between: Between = Between.LINEAR,
    *,
    of: str | None = None,
    rate: bool = False,
) -> Quantity:
    """x, y, z in the world frame over time; `of`: an axis of several, such as `LEG`."""
    axes = (TIME, XYZ) if of is None else (TIME, of, XYZ)
    return Quantity(axes, unit, meaning, between, "world", rate=rate)


def attitude(meaning: str, *, of: str | None = None) -> Quantity:
    """Unit quaternions w, x, y, z in the world frame over time."""
    axes = (TIME, WXYZ) if of is None else (TIME, of, WXYZ)
    return Quantity(axes, "", meaning, Between.TURNING, "world")


def inertia_tensor(meaning: str, between: Between) -> Quantity:
    """Matrices along the world's axes over time."""
    return Quantity((TIME, TENSOR), "kg m2", meaning, between, "world")


def names(axis: str, meaning: str) -> Quantity:
    """A name for each along an axis."""
    return Quantity((axis,), "", meaning, kind=Kind.TEXT, listed=False)


def of_joints(
    unit: str, meaning: str, between: Between, *, rate: bool = False, column: str = ""
) -> Quantity:
    """A number a joint over time."""
    return Quantity((TIME, JOINT), unit, meaning, between, rate=rate, column=column)


def coded(meaning: str, *codes: str, of: str | None = None, coded_by: str = "") -> Quantity:
    """Whole numbers that stand for something, over time: see `Quantity.codes`."""
    axes = (TIME,) if of is None else (TIME, of)
    return Quantity(
        axes, "", meaning, Between.HELD, kind=Kind.WHOLE, codes=codes, coded_by=coded_by
    )


def quantities(of: type) -> dict[str, Quantity]:
    """Name -> what it is, of every array that a class declares as a field, in its order."""
    return dict(_declared(of))


def derived(of: type) -> dict[str, Quantity]:
    """The same of the properties that follow from the fields."""
    return dict(_properties(of))


@cache
def _declared(of: type) -> dict[str, Quantity]:
    hints = get_type_hints(of, include_extras=True)
    return {f.name: q for f in fields(of) if (q := _annotated(hints[f.name])) is not None}


@cache
def _properties(of: type) -> dict[str, Quantity]:
    found = {}
    for name, member in vars(of).items():
        if isinstance(member, property) and member.fget is not None:
            hint = get_type_hints(member.fget, include_extras=True).get("return")
            if (quantity := _annotated(hint)) is not None:
                found[name] = quantity
    return found


def _annotated(hint: Any) -> Quantity | None:
    return next((m for m in getattr(hint, "__metadata__", ()) if isinstance(m, Quantity)), None)

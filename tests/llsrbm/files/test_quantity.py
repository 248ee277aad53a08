"""The one table of quantities: all that plans and rollouts hold, and the units of joints."""

from dataclasses import fields
from typing import get_type_hints

import numpy as np
import pytest

from llsrbm.files.quantity import JOINT, SIZES, TIME, Between, Kind, derived, quantities
from llsrbm.formats.table import columns
from llsrbm.motion.plan import OPTIONAL, Plan
from llsrbm.motion.rollout import Rollout
from tests.llsrbm.formats.jumps import ROBOTS, planned
from tests.llsrbm.synthetic_rollout import synthetic_rollout

UNITS = ("", "s", "m", "m/s", "rad", "rad/s", "kg", "kg m/s", "kg m2/s", "kg m2", "N", "Nm")
OTHER_UNITS = ("m, rad", "m/s, rad/s", "m/s and rad/s", "the detector's")  # of no single thing


@pytest.fixture(scope="module", params=ROBOTS)
def plan(request):
    return planned(request.param)


@pytest.fixture(scope="module")
def rollout():
    return synthetic_rollout()


def tables():
    return [(of, name, q) for of in (Plan, Rollout) for name, q in quantities(of).items()]


@pytest.mark.parametrize("of", [Plan, Rollout])
def test_every_array_is_declared(of):
    """A field that holds numbers over time or text is in the table; what is no array is not."""
    hints = get_type_hints(of)
    arrays = {
        field.name
        for field in fields(of)
        if "ndarray" in str(hints[field.name]) or hints[field.name] in (float, tuple[str, ...])
    }
    assert arrays == set(quantities(of))


@pytest.mark.parametrize(("of", "name", "quantity"), tables())
def test_what_is_said_makes_sense(of, name, quantity):
    assert quantity.unit in UNITS + OTHER_UNITS
    assert quantity.meaning
    assert "\n" not in quantity.meaning
    assert all(axis in SIZES for axis in quantity.axes)
    assert TIME not in quantity.axes[1:]
    assert (quantity.between is Between.CONSTANT) == (TIME not in quantity.axes)
    assert (quantity.kind is Kind.WHOLE) == bool(quantity.codes or quantity.coded_by)


def test_shapes_of_plans_are_those_of_their_axes(plan):
    sizes = {}
    for name, quantity in quantities(Plan).items():
        if name in OPTIONAL:
            continue
        shape = np.shape(getattr(plan, name))
        assert len(shape) == len(quantity.shape), name
        for got, size in zip(shape, quantity.shape, strict=True):
            wanted = size if isinstance(size, int) else sizes.setdefault(size, got)
            assert got == wanted, name
    assert sizes["T"] == len(plan.time)
    assert sizes["L"] == len(plan.leg_names)
    assert sizes["J"] == len(plan.joint_names)
    assert sizes["C"] % sizes["L"] == 0


def test_shapes_of_rollouts_are_those_of_their_axes(rollout):
    sizes = {}
    for name, quantity in (quantities(Rollout) | derived(Rollout)).items():
        shape = np.shape(getattr(rollout, name))
        for got, size in zip(shape, quantity.shape, strict=True):
            wanted = size if isinstance(size, int) else sizes.setdefault(size, got)
            assert got == wanted, name
    assert (sizes["Q"], sizes["V"]) == (7 + sizes["J"], 6 + sizes["J"])


def test_units_of_joints(plan):
    """Sliding joints have metres and newtons; none has "rad or m"."""
    sliding = plan.sliding_joints
    assert bool(sliding) == (plan.jump.robot == "slider")
    turning = {"rad": "m", "rad/s": "m/s", "Nm": "N"}
    for name, quantity in quantities(Plan).items():
        if JOINT in quantity.axes and quantity.kind is Kind.REAL:
            assert quantity.unit in turning, name
            for joint in plan.joint_names:
                unit = quantity.unit_of(joint, sliding)
                assert unit == (turning[quantity.unit] if joint in sliding else quantity.unit)


def test_columns_of_a_table_are_made_of_it(plan):
    named = [name for name, _ in columns(plan, 20.0)]
    assert named[0] == "time [s]"
    assert len(set(named)) == len(named)
    assert not any(" or " in name for name in named)
    listed = {
        quantity.column or name
        for name, quantity in (quantities(Plan) | derived(Plan)).items()
        if quantity.listed and TIME in quantity.axes
    }
    assert {name.partition(" [")[0].partition("/")[0] for name in named} == listed
    for joint in plan.joint_names:
        m, rad = ("m", "N"), ("rad", "Nm")
        position, torque = m if joint in plan.sliding_joints else rad
        assert f"joint_position/{joint} [{position}]" in named
        assert f"joint_velocity/{joint} [{position}/s]" in named
        assert f"joint_torque/{joint} [{torque}]" in named
        assert f"joint_torque_limit/{joint} [{torque}]" in named

"""Frames that are there twice: phases are those of the motion that is there once."""

from dataclasses import replace

import numpy as np
import pytest

import llsrbm
from llsrbm.repairing import repair as repair_module
from llsrbm.repairing.part import NoJump
from llsrbm.repairing.phases import contact_phases
from llsrbm.repairing.repeated import without_repeated
from tests.llsrbm.repairing.foreign import jump, of_states

FPS = 50.0


def _edges(motion):
    return [phase.start_s for phase in contact_phases(motion)[1:]]


@pytest.mark.parametrize("times", [2, 3])
def test_a_clip_that_was_written_at_a_higher_rate_has_its_own_phases(times):
    once = jump(FPS)
    qpos = np.repeat(once.qpos, times, axis=0)
    held = of_states(np.arange(len(qpos)) / (times * FPS), qpos)
    assert np.abs(np.subtract(_edges(held), _edges(once))).max() > 0.01
    np.testing.assert_allclose(_edges(without_repeated(held)), _edges(once), atol=1e-9)


@pytest.mark.parametrize("repair", [llsrbm.repair, llsrbm.repair_clip])
def test_repairs_see_it_so(repair, monkeypatch):
    def none(*_):
        raise NoJump("none is sought")

    monkeypatch.setattr(repair_module, "nearest", none)
    once = jump(FPS)
    qpos = np.repeat(once.qpos, 2, axis=0)
    held = replace(of_states(np.arange(len(qpos)) / (2 * FPS), qpos), fps=2 * FPS)
    found = repair(held).phases
    flight = next((phase.start_s, phase.end_s) for phase in found if not phase.feet)
    np.testing.assert_allclose(flight, _edges(once), atol=1e-9)


def test_a_motion_without_such_frames_stays_as_it_is():
    assert without_repeated(jump()) is jump()


def test_a_robot_at_rest_stays_there():
    qpos = np.repeat(jump().qpos[:1], 50, axis=0)
    still = of_states(np.arange(50) / FPS, qpos)
    assert without_repeated(still) is still

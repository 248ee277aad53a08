"""Plans of models for comparison: the model's own motion, brought to what the body can do."""

import numpy as np

import llsrbm
from llsrbm.motion.sampling import resample
from llsrbm.planning.whole_body import start as start_module
from llsrbm.planning.whole_body.refine import refined


def flown(plan):
    """The plan at the same shares of its flight."""
    return resample(plan, np.linspace(plan.lift_off, plan.touchdown, 21)[1:-1])


def away(draft):
    """m by which feet and base are away from the draft's in flight, at most."""
    plan = refined(draft)
    assert plan.refined
    one, other = flown(draft), flown(plan)
    feet = np.linalg.norm(one.foot_position - other.foot_position, axis=-1)
    base = np.linalg.norm(one.base_position - other.base_position, axis=-1)
    return feet.max(), base.max()


def test_feet_and_base_fly_as_the_model_has_them(monkeypatch):
    draft = llsrbm.plan(llsrbm.Jump(robot="anymal", model="srbm", twist=0.8), draft=True)
    feet, base = away(draft)
    assert feet < 0.02
    assert base < 0.01
    monkeypatch.setattr(start_module, "OWN", {"near": start_module.NEAR_DRAFT})
    assert away(draft)[0] > 1.3 * feet

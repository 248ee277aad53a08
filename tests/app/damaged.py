"""Files as nobody should send them: the page's own, damaged; the same for the same seed."""

import tempfile
from pathlib import Path

import numpy as np

from llsrbm.ocp.horizon import Iterate
from llsrbm.request.design import Design, dump_design
from llsrbm.request.jump import Jump
from llsrbm.request.scenario import Scenario
from llsrbm.request.tuning import Tuning
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.hostile import DAMAGE, Seeds, damaged_design, pick
from tests.llsrbm.synthetic_rollout import synthetic_rollout

JUMP = Jump(robot="anymal", twist=1.2, forward=0.1, height=0.1)
NAMES = (*["a.npz"] * 6, "a.json", "a.csv", "a.jump.json", "a", "\n/../a.npz")


class Damaged(Seeds):
    """Attributes: good, (name, content) of what is damaged."""

    def __init__(self):
        plan = synthetic_plan(JUMP)
        object.__setattr__(plan, "solution", Iterate(np.arange(9.0), np.arange(5.0)))
        self.arrays, self.good = [], []
        with tempfile.TemporaryDirectory() as folder:
            self.canary = Path(folder) / "canary"
            trajectories = {"plan.npz": plan, "rollout.npz": synthetic_rollout(plan)}
            for name, trajectory in trajectories.items():
                trajectory.save(path := Path(folder) / name)
                self.good.append((name, path.read_bytes()))
                with np.load(path) as archive:
                    self.arrays.append(dict(archive))
        self.files = [content for _, content in self.good]
        design = Design(JUMP, Tuning(limits={"friction": 0.4}), Scenario(seed=7), "title", "note")
        self.good.append(("mine.jump.json", dump_design(design).encode()))

    def damaged(self, seed):
        """(name, content)."""
        rng = np.random.default_rng(seed)
        kind = pick(rng, [*DAMAGE.values(), None])
        content = damaged_design(rng) if kind is None else kind(self, rng)
        return pick(rng, ("a.json", "a.jump.json") if kind is None else NAMES), content

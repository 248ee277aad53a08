"""A tab without threads: events go into `update`, effects are kept, jobs are answered by hand."""

from dataclasses import replace
from functools import cache

import numpy as np

from app.tab.acts import update
from app.tab.effects import After, Keep, LoadRobot, Notify, Reported, RobotLoaded, Submit
from app.tab.planning.robot import draw_robot
from app.tab.start.opening import first_state
from app.workers.reports import Planned, Prepared, Simulated
from llsrbm.ocp.horizon import Iterate
from llsrbm.robots import load_robot, read_robot_file
from llsrbm.robots.schema import robot_files
from tests.app.synthetic_plan import synthetic_plan
from tests.llsrbm.synthetic_rollout import synthetic_rollout

ROBOTS = {name: read_robot_file(path) for name, path in robot_files().items()}


@cache
def plan_of(jump, status="solved"):
    """With a solution, of which only its being there matters here."""
    return replace(synthetic_plan(jump, status), solution=Iterate(np.arange(5.0), np.arange(3.0)))


@cache
def rollout_of(plan, seed=None):
    return synthetic_rollout(plan, seed=seed)


class PureTab:
    """Attributes: state; effects: of the last event; submits: all so far; due: what will happen
    later, one event of a kind.
    """

    def __init__(self, robot="anymal"):
        # Plans stay drafts, but for tests that are about the whole body's (test_refining).
        self.state = replace(first_state(ROBOTS), whole_body=False)
        self.effects, self.submits, self.due = (), [], {}
        if robot:
            self.state, _ = draw_robot(self.state, RobotLoaded(load_robot(robot)))

    def take(self, event):
        return self.have(update(self.state, event))

    def have(self, step):
        self.state, self.effects = step
        self.submits += self.of(Submit)
        self.due |= {type(after.event): after for after in self.of(After)}
        return self.effects

    def of(self, kind):
        """Effects of one kind, of the last event."""
        return [effect for effect in self.effects if isinstance(effect, kind)]

    @property
    def one(self):
        """The only effect of the last event."""
        (effect,) = self.effects
        return effect

    @property
    def task(self):
        """What the pool got with the last event."""
        (submit,) = self.of(Submit)
        return submit.task

    @property
    def told(self):
        """(word, rest) of the status line."""
        return self.state.status.verdict, self.state.status.rest

    def move(self, **changes):
        """The controls of the jump."""
        return self.take(replace(self.state.design.jump, **changes))

    def report(self, report, *, submit=None):
        """A report of the last job, or of another one."""
        submit = submit or self.submits[-1]
        return self.take(Reported(submit, report))

    def finish_plan(self, submit=None, status="solved"):
        """The plan that was asked for last comes."""
        submit = submit or self.submits[-1]
        plan = replace(plan_of(submit.task.jump, status), tuning=submit.task.tuning)
        return self.report(Planned(submit.ticket, plan), submit=submit)

    def finish_simulation(self):
        task = self.submits[-1].task
        rollout = replace(rollout_of(plan_of(task.plan.jump)), plan=task.plan)
        return self.report(Simulated(0, replace(rollout, scenario=task.scenario)))

    def settle(self):
        """Plan until the request has rested and was planned from scratch."""
        while self.state.planning or not self.state.ready:
            self.finish_robot() if not self.state.ready else self.finish_plan()
            self.wait()

    def wait(self):
        """Until everything has happened that was to happen later."""
        while self.due:
            self.take(self.due.pop(next(iter(self.due))).event)
        return self.effects

    def finish_robot(self):
        """The robot that is awaited comes."""
        self.report(Prepared(0, self.state.design.jump.robot))
        (load,) = self.of(LoadRobot)
        return self.take(RobotLoaded(load_robot(load.name)))

    def notes(self):
        return [(note.title, note.body) for note in self.of(Notify)]

    def kept(self):
        return [keep.design for keep in self.of(Keep)]


def planned_tab(**changes):
    """A tab that shows the plan of its request, which has rested."""
    tab = PureTab()
    tab.move(**{"forward": 0.01, **changes})
    tab.settle()
    return tab

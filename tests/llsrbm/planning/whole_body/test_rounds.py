"""`Rounds`: what many requests in one process leave behind."""

import math

import pytest

import llsrbm
from llsrbm.certified_plan import CertifiedPlanner
from llsrbm.planning.problem.placement import make_task
from llsrbm.planning.whole_body import rounds
from llsrbm.planning.whole_body.refine import refiner_of
from llsrbm.robots import load_robot
from tests.llsrbm.formats.jumps import planned

# Jumps of Go2's with which its table leads nowhere, at once and after several rounds.
HARD = ({"twist": 160.0, "forward": 0.3}, {"twist": -154.0, "forward": 0.5, "lateral": 0.2})


@pytest.mark.nightly
def test_a_process_makes_no_solver_for_each_number_of_iterations_that_are_left():
    """Each holds 15 MB and more: one that had planned 100 of G1's jumps held 7.6 GB."""
    solver = refiner_of(planned("go2")).solver
    before = {*solver._made}
    for hard in HARD:
        motion = hard | {"twist": math.radians(hard["twist"])}
        task = make_task(llsrbm.Jump(robot="go2", **motion), load_robot("go2"))
        CertifiedPlanner(finer=False).from_table(task)
    known = {rounds.FROM_FAR, rounds.LOOK, rounds.BESIDE, rounds.NEARER, rounds.NEAR}
    known.add(rounds.FROM_FAR.acceptable)  # of what follows
    assert known & {*solver._made}
    assert {*solver._made} - before <= known

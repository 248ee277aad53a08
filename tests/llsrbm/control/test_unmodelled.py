"""Accelerations beside those that commands were made for, of bodies that move by known ones."""

import numpy as np
import pytest

from llsrbm.control.unmodelled import MEMORY, SETTLING, Unmodelled

N = 18
BOTH, LEFT, NONE = np.array([[True, True], [True, False], [False, False]])


class Moving:
    """A body that accelerates as is asked for, and by `beside` more; what is found is left out."""

    def __init__(self, tick, beside):
        self.tick, self.beside = tick, beside
        self.found, self.v = Unmodelled(tick, N), np.zeros(N)
        self.rng = np.random.default_rng(3)

    def run(self, duration, standing):
        """Let time pass, s."""
        for _ in range(round(duration / self.tick)):
            wanted = self.rng.normal(size=N)
            asked = wanted - self.found.acceleration
            # It would accelerate as was asked for, and is expected to as is wanted.
            self.v = self.v + (asked + self.beside) * self.tick
            self.found.measured(self.v, wanted, standing)
        return self.found.acceleration


@pytest.fixture(params=[0.0025, 0.001])
def moving(request):
    rng = np.random.default_rng(5)
    return Moving(request.param, 5 * rng.normal(size=N))


def test_a_constant_acceleration_is_found_within_three_memories(moving):
    moving.run(moving.tick, BOTH)  # from two velocities on
    found = moving.run(3 * MEMORY, BOTH)
    np.testing.assert_allclose(found, moving.beside, rtol=np.exp(-3))
    np.testing.assert_allclose(moving.run(10 * MEMORY, BOTH), moving.beside, rtol=1e-4)


def test_there_is_none_in_flight(moving):
    assert moving.run(3 * MEMORY, BOTH).any()
    assert not moving.run(moving.tick, NONE).any()
    assert not moving.run(10 * MEMORY, NONE).any()


def test_it_begins_anew_when_other_feet_stand_and_have_settled(moving):
    moving.run(3 * MEMORY, BOTH)
    assert not moving.run(moving.tick, LEFT).any()
    assert not moving.run(SETTLING - 2 * moving.tick, LEFT).any()
    found = moving.run(3 * MEMORY + 2 * moving.tick, LEFT)
    np.testing.assert_allclose(found, moving.beside, rtol=1.1 * np.exp(-3))


def test_what_is_expected_of_nothing_tells_nothing():
    found = Unmodelled(0.0025, N)
    for speed in range(5):
        found.measured(np.full(N, float(speed)), None, BOTH)
    assert not found.acceleration.any()

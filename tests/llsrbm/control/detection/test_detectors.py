import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from llsrbm.control import detection
from llsrbm.control.detection import (
    ARMED_BELOW,
    CentroidalState,
    ModelUncertainty,
    make_detector,
    model_uncertainty,
)
from llsrbm.errors import InputError
from llsrbm.robots import load_robot
from llsrbm.robots.control_schema import Uncertainty
from tests.llsrbm.control.detection.flights import (
    INERTIA,
    MASS,
    Contact,
    first,
    flight,
    landing,
    misjudged_flight,
    rotated,
)

EVERY = pytest.mark.parametrize("name", detection.DETECTORS)
UNCERTAIN = ModelUncertainty(trunk_mass=0.05)  # as from a robot file that states 10 %
TICKS = pytest.mark.parametrize("tick", [0.0025, 0.001])
# Touchdown 0.27 s after lift-off at 1.5 m/s; four feet, a foot, and a foot behind the CoM.
BEGIN = 0.2701
BELOW = np.array([0.0, 0.0, -0.45])
ONE_FOOT = np.array([0.35, 0.25, -0.45])


def unit(seed):
    vector = np.random.default_rng(seed).normal(size=3)
    return vector / np.linalg.norm(vector)


@EVERY
@TICKS
@settings(max_examples=8, deadline=None)
@given(
    velocity=st.tuples(*3 * [st.floats(-2, 2)]),
    momentum=st.tuples(*3 * [st.floats(-4, 4)]),
    stretch=st.floats(-0.4, 0.4),
)
def test_free_fall_is_no_contact(name, tick, velocity, momentum, stretch):
    # Unfolding legs slow a rotation down, which is all that the norm sees: not for it.
    stretch = stretch if name == "residual" else 0.0
    states = flight(tick, velocity=velocity, momentum=momentum, stretch=stretch)
    assert first(make_detector(name, tick, UNCERTAIN), states) is None


@TICKS
@pytest.mark.parametrize("noise", [0.01, 0.05])
def test_noise_alone_never_triggers(tick, noise):
    detector = make_detector("residual", tick, UNCERTAIN)
    largest = 0.0
    for seed in range(10):
        assert first(detector, flight(tick, noise=noise, seed=seed, stretch=-0.3)) is None
        largest = max(largest, detector.signal)
    assert largest > 2  # the noise is what the signal measures


@pytest.mark.parametrize("trunk_factor", [0.85, 1.15])
@TICKS
def test_a_wrong_trunk_never_triggers(trunk_factor, tick):
    states = misjudged_flight(trunk_factor, tick)
    assert first(make_detector("residual", tick, UNCERTAIN), states) is None
    # The CoM that the controller believes in leaves its parabola: it is seen, and is no contact.
    drift = np.array(
        [s.com_velocity - 9.81 * k * tick * np.array([0, 0, -1]) for k, s in enumerate(states)]
    )
    assert np.ptp(drift, axis=0).max() > 0.02  # m/s


def test_a_trunk_known_too_well_triggers():
    """The allowance is what keeps the flight above from being a contact."""
    states = misjudged_flight(1.15)
    detector = make_detector("residual", 0.0025, ModelUncertainty(trunk_mass=0.0))
    assert first(detector, states) is not None


def test_the_signal_is_the_trunks_error_in_standard_deviations():
    """Without noise, and where the swing is fast enough for nothing else to matter."""
    largest = []
    for factor in (1.05, 1.10):
        detector = make_detector("residual", 0.0025, UNCERTAIN)
        signals = []
        for state in misjudged_flight(factor, swing_speed=30.0):
            detector.update(state)
            signals.append(detector.signal)
        largest.append(max(signals))
    assert largest[0] == pytest.approx(1.0 * np.sqrt(2), rel=0.15)  # linear and angular, 1 each
    assert largest[1] == pytest.approx(2.0 * np.sqrt(2), rel=0.15)


@TICKS
@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_kick_in_any_direction_triggers_at_once(tick, seed):
    states = landing(0.25, tick, kick=0.06 * unit(seed))
    assert first(make_detector("residual", tick, UNCERTAIN), states) == round(0.25 / tick)


@pytest.mark.parametrize(
    ("force", "point", "rise", "median", "p90"),
    [
        pytest.param(2000, BELOW, 0.002, 5e-3, 6e-3, id="stiff"),
        pytest.param(300, ONE_FOOT, 0.010, 6e-3, 8e-3, id="one foot, soft"),
        pytest.param(150, BELOW, 0.005, 20e-3, 25e-3, id="half its weight"),
    ],
)
def test_latency_under_noise(force, point, rise, median, p90):
    tick, latencies = 0.0025, []
    detector = make_detector("residual", tick, UNCERTAIN)
    for seed in range(20):
        begin = BEGIN + tick * (seed % 10) / 10
        contact = Contact(begin, np.array([0.0, 0.0, force]), point, rise)
        k = first(detector, flight(tick, contact=contact, noise=0.01, seed=seed))
        latencies.append(k * tick - begin)
    assert min(latencies) > 0
    assert np.median(latencies) <= median
    assert np.quantile(latencies, 0.9) <= p90


def test_where_the_norm_rises_the_papers_detector_is_blind():
    """Feet ahead of the CoM: the pitch rate grows faster than the fall slows down."""
    contact = Contact(BEGIN, np.array([-100.0, 0.0, 400.0]), np.array([0.4, 0.0, -0.4]), 0.002)
    states = flight(velocity=(1.2, 0, 1.5), momentum=(0, 0, 0), contact=contact)
    norms = np.array([state.average_spatial_velocity_norm for state in states])
    after = np.arange(len(states)) * 0.0025 > BEGIN
    assert np.diff(norms[after])[1:].min() > 0
    assert first(make_detector("norm", 0.0025, UNCERTAIN), states) is None
    found = first(make_detector("residual", 0.0025, UNCERTAIN), states)
    assert 0 < found * 0.0025 - BEGIN <= 0.005


def test_the_papers_signal_is_the_least_fall_of_the_norm_in_its_window():
    contact = Contact(BEGIN, np.array([0.0, 0.0, 1500.0]), BELOW, 0.002)
    states = flight(contact=contact)[:111]
    detector = make_detector("norm", 0.0025, UNCERTAIN)
    for state in states:
        detector.update(state)
    norms = [
        np.linalg.norm(np.r_[np.linalg.inv(s.inertia) @ s.angular_momentum, s.com_velocity])
        for s in states[-3:]
    ]
    assert detector.signal == pytest.approx(-max(np.diff(norms)) / 0.0025)


@EVERY
@settings(max_examples=8, deadline=None)
@given(angle=st.floats(-np.pi, np.pi), seed=st.integers(0, 1000))
def test_the_heading_of_the_world_does_not_matter(name, angle, seed):
    contact = Contact(BEGIN, np.array([100.0, -50.0, 400.0]), ONE_FOOT, 0.005)
    states = flight(contact=contact, noise=0.01, seed=seed, duration=0.28)
    signals = []
    for turn in (0.0, angle):
        detector = make_detector(name, 0.0025, UNCERTAIN)
        reports = [(detector.update(rotated(s, turn)), detector.signal) for s in states]
        signals.append(np.array(reports))
    np.testing.assert_allclose(signals[1], signals[0], rtol=1e-7, atol=1e-9)


@EVERY
def test_deaf_until_it_falls(name):
    """Feet that leave the ground late push while the robot still rises."""
    contact = Contact(0.02, np.array([100.0, 0.0, 200.0]), ONE_FOOT, 0.002)
    states = flight(contact=contact)
    rising = [s for s in states if s.com_velocity[2] > 0.9 * ARMED_BELOW]
    detector = make_detector(name, 0.0025, UNCERTAIN)
    assert first(detector, rising) is None
    assert detector.signal == 0


@EVERY
def test_reset_forgets(name):
    contact = Contact(BEGIN, np.array([0.0, 0.0, 1500.0]), BELOW, 0.002)
    states = flight(contact=contact, noise=0.01)
    used, new = make_detector(name, 0.0025, UNCERTAIN), make_detector(name, 0.0025, UNCERTAIN)
    assert first(used, states) is not None
    assert first(used, flight(noise=0.05, seed=1)[:60]) is None
    used.reset()
    for state in states:
        assert used.update(state) == new.update(state)
        assert used.signal == new.signal


def test_average_spatial_velocity():
    state = CentroidalState(MASS, np.array([3.0, 0, 0]), INERTIA @ [0, 4.0, 0], INERTIA)
    np.testing.assert_allclose(state.average_angular_velocity, [0, 4, 0])
    assert state.average_spatial_velocity_norm == pytest.approx(5)


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(InputError) as caught:
        make_detector("force", 0.0025, UNCERTAIN)
    assert str(caught.value) == 'no detector "force"; valid: residual, norm'


def test_what_is_stated_is_two_standard_deviations():
    file = load_robot("anymal").file
    stated = file.model_copy(update={"uncertainty": Uncertainty(trunk_mass=0.16)})
    assert model_uncertainty(stated).trunk_mass == pytest.approx(0.08)

"""The observer finds the state of the arm, and the torque that the model lacks, from markers."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.observer import Observer
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect
from hsr_pin.errors import InputError
from hsr_pin.robot.specification import ArmSpecification

ARM = ArmSpecification()
MODEL = ArmDynamics(ARM)
DT, NOISE = 0.01, 5e-4
TORQUE = 0.4 + 0.3 * np.sin(5 * np.arange(150) * DT)


def watched(*effects, markers=slice(1, None), noise=NOISE, hidden=()):
    """Estimates and true states after every step; the observer believes the arm straight where it is bent."""
    random, plant = np.random.default_rng(0), ArmSimulator(ARM, effects)
    observer = Observer(MODEL, plant.markers[markers], DT, noise=max(noise, 1e-5))
    plant.reset(0.5)
    estimate, estimates, states = observer.begin(angle=0.3), [], []
    for k, torque in enumerate(TORQUE):
        seen = plant.observe()[markers]
        seen = seen + random.normal(0, noise, seen.shape)
        if k in hidden:
            seen[:] = np.nan
        estimate = observer.correct(estimate, seen)
        estimates.append(estimate)
        states.append(plant.state)
        estimate = observer.predict(estimate, torque)
        plant.step(torque, dt=DT)
    return estimates, states


def angle_errors(estimates, states):
    return np.array([np.abs(e.q - s.angles).max() for e, s in zip(estimates, states, strict=True)])


@pytest.mark.parametrize("markers", [slice(1, None), slice(2, None)], ids=["middle and tip", "tip"])
def test_the_estimate_converges_to_the_state_from_a_wrong_start(markers):
    estimates, states = watched(markers=markers)
    errors = angle_errors(estimates, states)
    rates = [np.abs(e.v - s.rates).max() for e, s in zip(estimates, states, strict=True)]
    assert np.abs(states[0].angles).max() > 0.08
    assert errors[30:].max() < 0.01
    assert np.sqrt(np.mean(np.square(rates[30:]))) < 0.1


def test_without_noise_the_estimate_becomes_the_state():
    assert angle_errors(*watched(noise=0.0))[50:].max() < 1e-3


def test_an_unknown_torque_is_found():
    estimates, states = watched(parse_effect("torque_bias:bias=0.15"))
    found = [e.disturbance for e in estimates[30:]]
    assert np.mean(found) == pytest.approx(0.15, abs=0.01)
    assert np.std(found) < 0.03
    assert angle_errors(estimates, states)[30:].max() < 0.01


def test_markers_that_are_not_seen_are_bridged_by_the_model():
    estimates, states = watched(hidden=range(60, 75))
    assert angle_errors(estimates, states)[60:75].max() < 0.01
    assert np.trace(estimates[74].covariance) > 1.3 * np.trace(estimates[59].covariance)


def test_the_covariance_stays_symmetric_positive_and_tells_the_truth():
    estimates, states = watched()
    P = estimates[-1].covariance
    np.testing.assert_allclose(P, P.T, atol=1e-6 * np.abs(P).max())
    assert np.linalg.eigvalsh(P).min() > 0
    J = MODEL.tip_jacobian(states[-1].angles)[[0, 2]]
    spread = np.sqrt(np.mean([np.trace(J @ e.covariance[:4, :4] @ J.T) for e in estimates[30:]]))
    off = np.array([MODEL.tip(e.q) - MODEL.tip(s.angles) for e, s in zip(estimates, states, strict=True)])[30:]
    actual = np.sqrt(np.mean(np.sum(off**2, axis=1)))
    assert 0.5 * spread < actual < 1.5 * spread
    assert actual < NOISE  # better than a marker by itself


def test_an_estimate_is_passed_in_and_handed_back():
    observer = Observer(MODEL, ArmSimulator(ARM).markers, DT)
    start = observer.begin(0.5)
    first = observer.predict(start, 0.5)
    assert np.array_equal(first.covariance, observer.predict(start, 0.5).covariance)
    np.testing.assert_allclose(first.q, start.q, atol=1e-8)
    with pytest.raises(ValueError, match="read-only"):
        start.q[0] = 1.0


def test_an_estimate_may_be_beyond_what_the_arm_can_do():
    observer = Observer(MODEL, ArmSimulator(ARM).markers, DT)
    start = replace(observer.begin(), q=np.full(4, 0.9))
    assert start.q.sum() > ARM.bending_limit
    assert np.isfinite(observer.predict(start, 0.0).v).all()


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda o: pickle.loads(pickle.dumps(o))])
def test_a_copy_observes_alike(duplicate):
    observer = Observer(MODEL, ArmSimulator(ARM).markers, DT, noise=2e-3, joint_torque=0.1, drift=0.3)
    start, seen = observer.begin(0.5), ArmSimulator(ARM).observe()
    one, other = (o.predict(o.correct(start, seen), 0.6) for o in (observer, duplicate(observer)))
    assert np.array_equal(one.q, other.q)
    assert np.array_equal(one.covariance, other.covariance)


def test_bad_input_is_refused():
    markers = ArmSimulator(ARM).markers
    with pytest.raises(InputError, match=r"positions: expected shape \(3, 3\)"):
        observer = Observer(MODEL, markers, DT)
        observer.correct(observer.begin(), np.zeros((2, 3)))
    with pytest.raises(InputError, match="observer"):
        Observer(MODEL, markers, DT, noise=0.0)
    with pytest.raises(InputError, match="observer"):
        Observer(MODEL, (), DT)


def test_the_observer_knows_what_the_model_knows():
    arm = replace(ARM, tip_mass=0.05)
    by_arm, by_effect = (
        Observer(model, ArmSimulator(ARM).markers, DT)
        for model in (ArmDynamics(arm), ArmDynamics(ARM, [parse_effect("tip_mass:mass=0.05")]))
    )
    one, other = (observer.predict(observer.begin(0.5), 0.7) for observer in (by_arm, by_effect))
    np.testing.assert_allclose(one.q, other.q, rtol=0, atol=1e-12)
    np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-9, atol=1e-12)

"""Frequency and damping of decays are recovered at every amplitude."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hsr_pin.diagnosis.indicators.decay import decay

from .recorded import STEP, arcs, swing


def oscillator(force, angle=0.8, duration=5.0):
    """Return (T,) [rad] of an oscillator of 2 Hz with the additional force ``force(angle, rate)`` [1/s^2]."""
    time = STEP * np.arange(round(duration / STEP))
    spring = (4 * np.pi) ** 2
    found = solve_ivp(lambda _, y: [y[1], -spring * y[0] - force(*y)], (0, time[-1]), [angle, 0.0], t_eval=time, max_step=2e-3)
    return found.y[0]


def trend(force):
    return decay(arcs(*(oscillator(force, angle) for angle in (0.5, 0.7, 0.9)), noise=2e-5))


def test_frequency_and_damping_are_read_off():
    found = decay(arcs(*(swing(angle, 2.0, 0.04) for angle in (0.5, 0.7, 0.9)), noise=2e-5))
    large = [each for each in found.swings if each.amplitude > 0.05]
    assert np.median([each.frequency for each in large]) == pytest.approx(2.0, rel=0.005)
    assert np.median([each.damping for each in large]) == pytest.approx(0.04, rel=0.03)
    assert found.kinds == () and "as for a spring and a viscous damper" in found.sentence


def test_a_place_of_rest_that_drifts_plays_no_part():
    drift = 0.05 * STEP * np.arange(400)
    found = decay(arcs(*(swing(angle, 2.0, 0.04) + drift for angle in (0.5, 0.7, 0.9)), noise=2e-5))
    assert found.kinds == ()
    assert np.median([each.damping for each in found.swings]) == pytest.approx(0.04, rel=0.1)


@pytest.mark.parametrize(
    ("force", "kind"),
    [
        (lambda angle, rate: 1.2 * np.tanh(rate / 0.01) + 0.2 * rate, "friction"),
        (lambda angle, rate: 0.8 * abs(rate) * rate, "damping"),
        (lambda angle, rate: 0.5 * rate + 100 * angle**3, "elastic"),
        (lambda angle, rate: 0.5 * rate - 60 * angle**3, "elastic"),
    ],
    ids=["dry friction", "quadratic damping", "hardening", "softening"],
)
def test_what_changes_with_amplitude_is_pointed_to(force, kind):
    assert kind in trend(force).kinds


def test_nothing_that_swings_is_no_decay():
    assert decay(arcs(0.5 * np.exp(-np.arange(300) / 40))) is None


def with_payload(ratio, mount="hanging", slow=1.2):
    """Return free decays at 2 Hz with a damping ratio of 0.05, and slower ones of a payload with another damping ratio."""
    light = [swing(angle, 2.0, 0.05) for angle in (0.5, 0.7)]
    heavy = [swing(angle, slow, ratio, duration=6.0) for angle in (0.5, 0.7)]
    return decay(arcs(*light, *heavy, noise=2e-5, payloads=(0.0, 0.0, 0.05, 0.05), mount=mount))


def test_a_damping_ratio_that_a_payload_does_not_lower_is_no_viscous_dampers():
    found = with_payload(0.05)
    assert (found.loaded.light, found.loaded.heavy) == (0.0, 0.05)
    assert found.loaded.frequencies == pytest.approx((2.0, 1.2), rel=0.01)
    assert found.loaded.ratios == pytest.approx((0.05, 0.05), rel=0.05)
    assert found.loaded.damper == pytest.approx(0.03, rel=0.05)
    assert "this points to relaxation, or friction" in found.sentence and "as for a spring" not in found.sentence
    assert found.to_json()["loaded"]["damper"] == found.loaded.damper


@pytest.mark.parametrize(
    ("ratio", "mount", "slow"),
    [(0.03, "hanging", 1.2), (0.05, "upright", 1.2), (0.06, "hanging", 1.8)],
    ids=["as a damper's", "gravity takes stiffness", "hardly slower"],
)
def test_a_damping_ratio_that_falls_with_the_frequency_or_may_for_gravity_tells_nothing(ratio, mount, slow):
    found = with_payload(ratio, mount, slow)
    assert found.loaded is None and "relaxation" not in found.sentence

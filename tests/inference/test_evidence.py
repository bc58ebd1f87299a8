"""The evidence rewards a smaller misfit and penalises additional causes and parameters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.inference import Cause, Data, Model, log_evidence
from hsr_pin.inference.evidence import reachable
from hsr_pin.inference.model import information
from tests.inference.fabricated import CALIBRATION, CURVE, DATA, FRICTION, LAG, model


def evidence(causes, misfit, **facts):
    return log_evidence(model(causes, misfit, **facts), DATA, CALIBRATION)


def test_a_model_that_leaves_less_has_more_evidence():
    assert evidence([FRICTION], 0.1) > evidence([FRICTION], 1.0)


def test_what_is_smaller_than_the_floor_hardly_counts():
    assert evidence([FRICTION], 0.0) - evidence([FRICTION], 0.002) < 1.0


def test_a_cause_that_explains_nothing_lowers_the_evidence():
    assert evidence([FRICTION], 1.0) < evidence([], 1.0) - 1.0


def test_a_flexible_law_costs_more_than_a_law_that_is_as_good():
    assert evidence([CURVE], 0.1) == pytest.approx(evidence([FRICTION], 0.1) - CALIBRATION.flexible)


def test_a_law_of_many_variants_shares_its_probability_among_them():
    many = Cause("friction", "friction", variants=4)
    assert evidence([many], 0.1) == pytest.approx(evidence([FRICTION], 0.1) - np.log(4))


def test_an_implausible_side_value_costs_what_a_cauchy_distribution_says():
    plain, far = evidence([], 0.1), evidence([], 0.1, departures=[3.0])
    assert plain - far == pytest.approx(np.log(10))


def test_a_parameter_that_the_data_tell_nothing_of_costs_nothing():
    assert evidence([], 0.5, information=0.0) > evidence([], 0.5, information=1e4)


def test_no_model_can_have_more_evidence_than_is_reachable():
    smaller = model([FRICTION], 0.8)
    for left in (0.0, 0.1, 0.7):
        larger = model([FRICTION, LAG], left)
        assert log_evidence(larger, DATA, CALIBRATION) <= reachable(smaller, DATA, CALIBRATION)


def test_differences_of_evidence_do_not_depend_on_the_unit_of_length():
    def difference(unit):
        data = replace(DATA, noise=DATA.noise * unit**2)
        one, other = (
            replace(each, misfits=each.misfits * unit**2, information=each.information * unit**2)
            for each in (model([FRICTION], 0.2), model([], 0.9))
        )
        return log_evidence(one, data, CALIBRATION) - log_evidence(other, data, CALIBRATION)

    assert difference(1e-3) == pytest.approx(difference(1.0))


def test_information_does_not_depend_on_the_unit_of_a_parameter():
    rng = np.random.default_rng(0)
    slopes, widths, unit = rng.normal(size=(50, 3)), np.array([0.3, 1.0, 2.0]), np.array([1.0, 1e3, 1e-2])
    assert information([slopes], widths) == pytest.approx(information([slopes / unit], widths * unit))


def test_a_trial_that_is_cut_in_two_carries_the_same_information():
    slopes, widths = np.random.default_rng(1).normal(size=(60, 2)), np.ones(2)
    assert information([slopes], widths) == pytest.approx(information([slopes[:25], slopes[25:]], widths))


def test_a_channel_that_nothing_explains_does_not_hide_what_a_cause_explains_in_another():
    """Two joints with a variance each: friction explains the gap of the second one."""
    both = Data(((0,), (1,)), np.ones(2), np.full(2, 2000), np.zeros(2))
    known = np.zeros((2, 0, 0))
    nothing = Model((), np.array([1e4, 10.0]), known, np.zeros(0))
    friction = Model((FRICTION,), np.array([1e4, 0.1]), known, np.zeros(0))
    gain = log_evidence(friction, both, CALIBRATION) - log_evidence(nothing, both, CALIBRATION)
    mixed = [replace(each, misfits=each.misfits.mean(keepdims=True), information=known[:1]) for each in (friction, nothing)]
    assert gain > 10 > 1 > log_evidence(mixed[0], DATA, CALIBRATION) - log_evidence(mixed[1], DATA, CALIBRATION)


def test_a_known_inaccuracy_of_every_model_limits_what_a_smaller_misfit_proves():
    rough = replace(DATA, discrepancy=np.ones(1))
    gains = [
        log_evidence(model([FRICTION], 0.01), data, CALIBRATION) - log_evidence(model([FRICTION], 0.5), data, CALIBRATION)
        for data in (DATA, rough)
    ]
    assert gains[0] > 5 > gains[1] > 0


def test_errors_of_declared_numbers_cost_what_a_normal_distribution_says():
    plain = model([FRICTION], 0.1)
    wider = np.pad(plain.information, ((0, 0), (0, 2), (0, 2)))
    off = replace(plain, information=wider, errors=np.array([3.0, -1.0]))
    assert log_evidence(plain, DATA, CALIBRATION) - log_evidence(off, DATA, CALIBRATION) == pytest.approx(5.0)

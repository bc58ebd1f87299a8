"""The report with the largest expected gain is chosen, from a table that users can change."""

from __future__ import annotations

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.inference import Cause, Loss, Posterior, decide
from tests.inference.fabricated import CURVE, FRICTION, LAG, MASS, model


def found(*weighted):
    """Return a posterior from causes, their remaining misfit (10 for the nominal model), and their probability."""
    models = tuple(model(causes, misfit) for causes, misfit, _ in weighted)
    probabilities = np.array([weight for *_, weight in weighted], dtype=float)
    shares = np.array([1 - misfit / 10 for _, misfit, _ in weighted])
    return Posterior(models, np.log(np.maximum(probabilities, 1e-12)), probabilities / probabilities.sum(), shares)


def test_one_set_that_is_all_but_certain_is_reported():
    report = decide(found(([], 10, 0.02), ([FRICTION], 0, 0.98)))
    assert report.sets == (("friction",),) and report.names == ("friction",) and report.kinds == ("friction",)


def test_two_sets_that_share_the_probability_are_alternatives():
    report = decide(found(([], 10, 0.01), ([FRICTION], 0, 0.5), ([LAG], 0, 0.49)))
    assert report.sets == (("friction",), ("lag",)) and report.names == ()


def test_what_all_alternatives_share_is_named():
    report = decide(found(([], 10, 0.0), ([FRICTION, LAG], 0, 0.5), ([FRICTION, MASS], 0, 0.5)))
    assert report.names == ("friction",)


def test_nothing_is_named_where_the_cause_may_be_unknown():
    report = decide(found(([], 10, 0.4), ([FRICTION], 3, 0.6)))
    assert not report.sets and not report.kinds


def test_a_name_that_all_share_is_reported_alone_where_what_is_beside_it_is_open():
    others = [Cause(f"small {k}", "elastic") for k in range(12)]
    report = decide(found(([], 10, 0.0), *[([FRICTION, other], 0.0, 1 / 12) for other in others], ([FRICTION], 1.0, 0.0)))
    assert report.names == ("friction",) and not report.sets


def test_a_flexible_law_is_reported_as_its_kind():
    report = decide(found(([], 10, 0.02), ([CURVE], 0, 0.98)))
    assert report.names == () and report.kinds == ("elastic",) and not report.sets


def test_dearer_wrong_names_make_the_report_more_careful():
    posterior = found(([], 10, 0.1), ([FRICTION], 0, 0.9))
    assert decide(posterior).sets
    assert not decide(posterior, Loss(wrong_name=-50, none_right=-50)).sets


def test_the_expected_gain_of_a_certain_report_is_that_of_the_table():
    report = decide(found(([], 10, 0.0), ([FRICTION], 0, 1.0)))
    assert report.gain == Loss().exact and report.probability == 1.0


def test_a_loss_is_read_from_text_and_what_it_does_not_know_is_refused():
    assert Loss.of("wrong_name=-8, part=0") == Loss(wrong_name=-8.0, part=0.0)
    for text in ("wrong=-8", "wrong_name", "wrong_name=much", "wrong_name=inf"):
        with pytest.raises(InputError, match="loss"):
            Loss.of(text)


def test_the_stated_probability_is_that_of_the_whole_report():
    report = decide(found(([], 10, 0.01), ([FRICTION], 0, 0.5), ([LAG], 0, 0.49)))
    assert abs(report.probability - 0.99) < 1e-9

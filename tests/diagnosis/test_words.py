"""What to do next follows from the verdict."""

import pytest

from hsr_pin.diagnosis.diagnose import Diagnosis
from hsr_pin.diagnosis.search import Search
from hsr_pin.diagnosis.verdict import judge
from hsr_pin.diagnosis.words import advice

from .fabricated import THRESHOLDS, candidate

BASE = candidate(gap=4e-3)


@pytest.mark.parametrize(
    ("best", "told"),
    [
        (candidate("bending_stop"), "Simulate with Keq times"),
        (candidate("bending_stop", errors={"bending_stop": 5}), "Record more trials in which bending stop would act"),
        (candidate("bending_stop", errors={"bending_stop": 1}), "Record more trials in which bending stop would act"),
        (candidate("bending_stop", gap=3e-3), "none of the catalogue's laws"),
        (BASE, "none of the catalogue's laws"),
    ],
)
def test_the_advice_fits_the_verdict(best, told):
    found = Search((BASE,) if best is BASE else (BASE, best), (BASE, best))
    verdict = judge((6e-3) ** 2, found, THRESHOLDS, 0)
    (line,) = advice(Diagnosis(None, verdict, (), found, THRESHOLDS, ()))
    assert told in line

"""A small diagnosis that all tests share, and modified versions of it for rare verdicts."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.diagnosis.next_experiment import Proposal
from hsr_pin.inference.verdict import Verdict


@pytest.fixture(scope="session")
def diagnosis(heavy_tip):
    """Diagnosis of an arm with a heavy tip, with two candidate effects."""
    return diagnose(heavy_tip, effects=["tip_mass", "actuator_lag"], max_effects=1, jobs=1)


@pytest.fixture(scope="session")
def ambiguous(diagnosis):
    """The diagnosis with a fabricated ambiguous verdict."""
    said = "these recordings cannot tell apart: <a>, or b & c."
    verdict = Verdict("ambiguous", (), (("tip_mass",), ("actuator_lag",)), said, left=diagnosis.verdict.left)
    return replace(diagnosis, verdict=verdict, next_experiment=(Proposal("payload", 40.0), Proposal("steps", np.inf)))


@pytest.fixture(scope="session")
def insufficient(heavy_tip):
    """Diagnosis of a single trial."""
    return diagnose(replace(heavy_tip, trials=heavy_tip.trials[:1]), jobs=1)

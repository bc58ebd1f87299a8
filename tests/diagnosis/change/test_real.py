"""Known changes between recordings of real arms are found: `scripts/real_changes.py` on the shared recordings."""

import pytest

from hsr_pin.diagnosis.change.diagnose import diagnose_change

SCRIPT = "real_changes"
TOLD = {
    "trunk": {"tip_mass"},
    "trunk-same": set(),
    "beam": {"tip_mass"},
    "pneumatic-same": set(),
    "pneumatic-late": {"dead_time"},
    "pneumatic-markers": {"marker_offset"},
}


@pytest.fixture(scope="module")
def cases(script):
    return script.CASES


def told(cases, recordings, name):
    _, new, old, delay = cases[name]
    return diagnose_change(new(recordings), old(recordings), delay=delay, jobs=2).verdict


@pytest.mark.long
@pytest.mark.parametrize("name", TOLD)
def test_what_has_changed_is_named_and_nothing_else(cases, shared, name):
    verdict = told(cases, shared / "recordings", name)
    assert verdict.status == ("identified" if TOLD[name] else "unchanged")
    assert set(verdict.effects) == TOLD[name]


@pytest.mark.long
def test_a_frame_that_is_turned_is_told_from_all_but_a_base_that_is(cases, shared):
    verdict = told(cases, shared / "recordings", "pneumatic-frame")
    assert verdict.status == "ambiguous"
    assert set(verdict.alternatives) == {("frame_turn",), ("gravity_tilt",)}

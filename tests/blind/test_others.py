"""Plants by other authors record cases that are planned evenly, are readable, and have answers with their content."""

from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hsr_pin.blind import others
from hsr_pin.blind.cases import Case
from hsr_pin.blind.kinds import KINDS
from hsr_pin.blind.plants.others import NAMES, plant
from hsr_pin.blind.tiers import plan
from hsr_pin.errors import SimulationFailure
from hsr_pin.recordings.read import read_dataset

each_plant = pytest.mark.parametrize("name", NAMES)


@each_plant
def test_every_law_of_a_plant_is_of_kinds_that_there_are(name):
    laws = plant(name).CATALOGUE | plant(name).OUTSIDE
    assert len(plant(name).CATALOGUE) >= 14 and len(plant(name).OUTSIDE) >= 4
    assert all(kinds and set(kinds) <= set(KINDS) for kinds in laws.values())


def test_each_plant_has_as_many_cases_and_every_sort_of_case():
    cases = plan(5, {"others": 60})
    assert Counter(case.plant for case in cases) == dict.fromkeys(NAMES, 20)
    assert {case.kind for case in cases} == {"single", "pair", "none", "outside"}
    assert cases == plan(5, {"others": 60}) != plan(6, {"others": 60})
    for case in cases:
        own = plant(case.plant)
        assert set(case.effects) <= set(own.OUTSIDE if case.kind == "outside" else own.CATALOGUE)


CASE = Case("case_001", "single", ("tip_mass",), ("large",), "valve_arm", "", "as seen", "tau", 7, "others")


def test_a_law_that_cannot_be_as_strong_is_smaller_at_later_attempts(monkeypatch, tmp_path):
    asked = []

    def record(folder, seed, laws, *, smooth):
        asked.append(laws)
        if laws and laws[0][1] != "barely":
            raise ValueError("not reached")
        return {"laws": []}

    stub = SimpleNamespace(CATALOGUE={"tip_mass": ("mass_gravity",)}, OUTSIDE={}, record=record)
    monkeypatch.setattr(others, "plant", lambda name: stub)
    for attempt in range(3):
        with pytest.raises(SimulationFailure, match="case_001: not reached"):
            others.build_other(CASE, tmp_path / "case", attempt)
    answer = others.build_other(CASE, tmp_path / "case", 3)
    assert [laws[0][1] for laws in asked] == ["large", "large", "medium", "barely"]
    assert (answer.size, answer.names, answer.kinds) == ("barely", (("tip_mass",),), (("mass_gravity",),))
    assert others.build_other(CASE, tmp_path / "case", others.DRAWS - 1).kind == "none"


@pytest.mark.long
@each_plant
def test_a_recording_is_one_that_the_reader_takes_and_the_same_seed_gives_the_same(name, tmp_path):
    case = replace(CASE, plant=name, sizes=("medium",))
    answer = others.build_other(case, tmp_path / "one", 0)
    again = others.build_other(case, tmp_path / "two", 0)
    assert answer == again
    one, two = read_dataset(tmp_path / "one"), read_dataset(tmp_path / "two")
    assert len(one.trials) >= 5
    for a, b in zip(one.trials, two.trials, strict=True):
        np.testing.assert_array_equal(a.trajectory.positions, b.trajectory.positions)

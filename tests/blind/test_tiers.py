"""Tiers are planned in their shares, and recordings contain what their answers state."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

from hsr_pin.blind.answers import Answer, seal, unseal
from hsr_pin.blind.background import NOTICEABLE, Background
from hsr_pin.blind.cases import PROGRAMS
from hsr_pin.blind.make import make
from hsr_pin.blind.pairs import GROWTH
from hsr_pin.blind.plants.artefacts import MIN_NOISE
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws import CATALOGUE, FORMS, OUTSIDE, PARAMETERS
from hsr_pin.blind.plants.laws.mounting import GravityTilt, TipMass
from hsr_pin.blind.plants.nuisance import Nuisance, noise_floor
from hsr_pin.blind.tiers import DIFFERENT_PROGRAMS, TIERS, by_shares, plan, plan_changes, shuffled
from hsr_pin.blind.workshop import LARGEST_GAP, Workshop, build, quieter
from hsr_pin.errors import InputError
from hsr_pin.recordings.read import read_dataset

COARSE = ChainPlant(elements=4, step=1e-3)
QUICK = Workshop({"chain": COARSE, "rod": COARSE}, COARSE, COARSE, ("steps", "releases"))
PROGRAM = ("releases",)


@pytest.fixture
def few(monkeypatch):
    """Two small effects that are fast to simulate; the drawing of real ones is tested with the artefacts."""
    small = Background((TipMass(2e-4), GravityTilt(1e-3)), (0.1, 0.2), 0.3)
    monkeypatch.setattr("hsr_pin.blind.workshop.background", lambda *_: small)


def of(cases, kind):
    return next(replace(case, name="case_001") for case in cases if case.kind == kind)


def test_three_hundred_cases_are_as_many_of_each_as_a_check_needs():
    cases = plan(1, by_shares(300))
    assert len(cases) == 300
    tiers, kinds = Counter(case.tier for case in cases), Counter(case.kind for case in cases)
    assert tiers["forms"] == 60 and kinds["none"] >= 40 and kinds["outside"] >= 40
    assert Counter((case.tier, case.kind) for case in cases)["messy", "single"] >= 99
    assert {case.effects[0] for case in cases if case.tier == "forms"} == set(FORMS)
    assert {case.effects[0] for case in cases if (case.tier, case.kind) == ("messy", "single")} == set(CATALOGUE)
    assert {case.effects[0] for case in cases if case.kind == "outside"} == set(OUTSIDE)
    assert all("barely" not in case.sizes for case in cases if case.tier != "clean")


def test_a_hundred_and_twenty_pairs_contain_every_change_and_different_programs():
    cases = plan_changes(1, 120)
    kinds = Counter(case.kind for case in cases)
    assert kinds == {"appears": 42, "grows": 24, "parameter": 24, "nothing": 30}
    assert {case.effects[0] for case in cases if case.kind == "parameter"} == set(PARAMETERS)
    assert sum(case.later != case.program for case in cases) == DIFFERENT_PROGRAMS * 120
    assert {case.later for case in cases} <= set(PROGRAMS)


def test_the_order_reveals_nothing_and_follows_from_the_seed():
    cases = plan(1, {"clean": 30, "messy": 30})
    first, again, other = shuffled(1, cases), shuffled(1, cases), shuffled(2, cases)
    assert first == again != other
    assert [case.name for case in first] == [f"case_{k:03d}" for k in range(1, 61)]
    assert 8 <= Counter(case.tier for case in first[:30])["messy"] <= 22


def test_an_unknown_tier_and_no_cases_are_refused():
    with pytest.raises(InputError, match="clean or messy or forms"):
        plan(1, {"tidy": 3})
    with pytest.raises(InputError, match="zero or more"):
        plan(1, {"messy": -1})
    for ask in (by_shares, lambda count: plan_changes(1, count)):
        with pytest.raises(InputError, match="one or more"):
            ask(0)
    assert sum(TIERS.values()) == pytest.approx(1.0)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["single", "none", "outside"])
def test_a_messy_case_holds_its_main_effect_and_small_ones(tmp_path, kind):
    case = of(plan(2, {"messy": 20}, QUICK.programs), kind)
    answer = build(case, tmp_path / "case_001", QUICK)
    assert (answer.tier, answer.kind, answer.effects) == ("messy", kind, case.effects)
    small = {law["name"]: law["noise_floors"] for law in answer.facts["small"]}
    assert 4 <= len(small) <= 8 and not set(small) & set(case.effects)
    assert answer.background == tuple(name for name, alone in small.items() if alone >= NOTICEABLE)
    assert answer.names == () if kind == "none" else answer.names[0][0] == case.effects[0]
    if case.effects:
        assert answer.facts["gaps_mm"][0] <= 1.15 * LARGEST_GAP
    assert len(read_dataset(tmp_path / "case_001").trials) > 3


def test_the_answer_of_another_form_has_its_name_and_kind(tmp_path):
    case = replace(
        plan(2, {"forms": 1}, QUICK.programs)[0], name="case_001", effects=("actuator_lag:unequal",), sizes=("medium",)
    )
    answer = build(case, tmp_path / "case_001", QUICK)
    assert answer.effects == ("actuator_lag",) and answer.names == (("actuator_lag", "unequal_lag"),)
    assert answer.kinds == (("actuation_time",),)
    assert answer.facts["laws"][0]["variant"] == "unequal" and answer.facts["gaps_in_noise_floors"][0] == pytest.approx(
        6, rel=0.1
    )


@pytest.mark.parametrize(
    "kind", ["nothing", *(pytest.param(each, marks=pytest.mark.long) for each in ("appears", "grows", "parameter"))]
)
def test_a_pair_holds_two_recordings_and_the_step_between_them(tmp_path, few, kind):
    case = of(plan_changes(3, 20, PROGRAM), kind)
    answer = build(case, tmp_path / "case_001", QUICK)
    old, new = (read_dataset(tmp_path / "case_001" / name) for name in ("old", "new"))
    assert (old.name, new.name) == ("old", "new")
    change = answer.facts["change"]
    if kind == "nothing":
        assert change == {} and answer.effects == ()
        return
    assert change["name"] == answer.effects[0]
    if kind == "appears":
        assert change["from"] == 0 != change["to"]
    elif kind == "grows":
        assert change["to"] == pytest.approx(GROWTH * change["from"])
    else:
        assert change["from"] > 0.6 and change["to"] != change["from"]


def test_where_nothing_changes_the_arm_is_the_same_and_its_noise_is_not(tmp_path, few):
    case = replace(of(plan_changes(3, 20, ("steps",)), "nothing"), seed=11)
    build(case, tmp_path / "case_001", QUICK)
    old, new = (read_dataset(tmp_path / "case_001" / name) for name in ("old", "new"))
    floor = 1e-3
    for a, b in zip(old.trials, new.trials, strict=True):
        apart = a.trajectory.positions - b.trajectory.positions
        assert np.nanmedian(np.abs(apart)) < 6 * floor and np.nanstd(apart) > 1e-4


def test_a_small_gap_makes_the_recording_quieter_and_a_clear_one_does_not():
    loud = Nuisance(noise=1e-3)
    assert quieter(loud, 6 * 1e3 * noise_floor(1e-3)) is loud
    assert 2.0 / (1e3 * noise_floor(quieter(loud, 2.0).noise)) == pytest.approx(6.0)
    assert quieter(loud, 1e-3).noise == MIN_NOISE


def test_all_tiers_are_sealed_in_one_check_and_open_again(tmp_path, few):
    cases = shuffled(4, plan(4, {"clean": 1, "messy": 1, "forms": 1}, ("steps",)))
    file = make(tmp_path / "check", 4, cases, workshop=QUICK)
    answers = unseal(tmp_path / "check", file)
    assert sorted(answer.tier for answer in answers) == ["clean", "forms", "messy"]
    text = "".join(path.read_text() for path in (tmp_path / "check").rglob("*") if path.is_file()).lower()
    assert not [name for name in (*CATALOGUE, *OUTSIDE, "messy", "forms", "clean", "variant") if name in text]


def test_answers_of_before_there_were_tiers_are_read(tmp_path):
    (tmp_path / "check").mkdir()
    seal(tmp_path / "check", tmp_path / "a.json", 1, [Answer("case_001", "single", ("tip_mass",), "large", {"seed": 3})])
    restored = unseal(tmp_path / "check", tmp_path / "a.json")[0]
    old = {"name": "case_001", "kind": "single", "effects": ["tip_mass"], "size": "large", "seed": 3}
    assert Answer.of(old) == restored
    assert (restored.tier, restored.names, restored.kinds) == ("clean", (("tip_mass",),), (("mass_gravity",),))

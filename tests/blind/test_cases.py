"""The plan of a check is balanced and follows from its seed, and the recordings reveal nothing until the seal is opened."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from hsr_pin.blind.answers import SEAL, unseal
from hsr_pin.blind.cases import INPUTS, MOUNTS, PROGRAMS, ROD_PROGRAMS, ROD_UNSUPPORTED, SHARES, plan_clean
from hsr_pin.blind.make import default_answers, make
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws import CATALOGUE, OUTSIDE
from hsr_pin.blind.plants.scaling import SIZES
from hsr_pin.blind.workshop import Workshop, size_of
from hsr_pin.errors import InputError, SimulationFailure

SEED = 5
COARSE = ChainPlant(elements=4, step=1e-3)
QUICK = Workshop({"chain": COARSE, "rod": COARSE}, COARSE, COARSE, ("steps",))
PLAN = plan_clean(SEED, 3, QUICK.programs)


@pytest.fixture
def mujoco():
    pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Three cases on chains with a few links."""
    pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")
    folder = tmp_path_factory.mktemp("made") / "check"
    return folder, make(folder, SEED, PLAN, workshop=QUICK)


def test_two_hundred_cases_hold_every_effect_twice_at_each_size():
    cases = plan_clean(7, 200)
    singles = Counter((case.effects[0], case.sizes[0]) for case in cases if case.kind == "single")
    assert singles == {(effect, size): 2 for effect in CATALOGUE for size in SIZES}
    assert {case.effects[0] for case in cases if case.kind == "outside"} == set(OUTSIDE)
    pairs = [frozenset(case.effects) for case in cases if case.kind == "pair"]
    assert len(set(pairs)) == len(pairs) == 30
    assert all(len(pair) == 2 and pair <= set(CATALOGUE) for pair in pairs)


@pytest.mark.parametrize("count", [1, 2, 7, 60, 133, 200])
def test_any_number_of_cases_is_balanced(count):
    cases = plan_clean(3, count)
    assert [case.name for case in cases] == [f"case_{k:03d}" for k in range(1, count + 1)]
    kinds = Counter(case.kind for case in cases)
    assert all(abs(kinds[kind] - share * count) < 1 for kind, share in SHARES.items())
    for field, choices in (("mount", MOUNTS), ("given", INPUTS)):
        used = Counter(getattr(case, field) for case in cases)
        assert max(used[choice] for choice in choices) - min(used[choice] for choice in choices) <= 1
    effects = Counter(case.effects[0] for case in cases if case.kind == "single")
    assert max(effects.values(), default=0) - min(effects[effect] for effect in CATALOGUE) <= 1


def test_the_rod_records_an_eighth_and_only_what_it_can():
    rods = [case for case in plan_clean(7, 200) if case.plant == "rod"]
    assert 20 <= len(rods) <= 26
    assert {case.program for case in rods} <= set(ROD_PROGRAMS) < set(PROGRAMS)
    assert not any(set(case.effects) & set(ROD_UNSUPPORTED) for case in rods)


def test_the_same_seed_gives_the_same_plan_and_another_seed_another():
    assert plan_clean(4, 50) == plan_clean(4, 50) != plan_clean(5, 50)


def test_the_order_of_cases_reveals_nothing():
    kinds = [case.kind for case in plan_clean(7, 200)]
    half = Counter(kinds[:100])["single"]
    assert 45 <= half <= 69  # of 114
    assert len({tuple(case.kind for case in plan_clean(seed, 12)) for seed in range(10)}) > 5


def test_no_cases_are_refused():
    with pytest.raises(InputError, match="one or more"):
        plan_clean(1, 0)


def test_recordings_do_not_reveal_their_content(made):
    folder, answers = made
    assert answers == default_answers(folder)
    assert folder not in answers.parents
    assert sorted(path.name for path in folder.iterdir()) == [SEAL, "case_001", "case_002", "case_003"]
    assert [path.name for path in folder.parent.iterdir() if path not in (folder, answers)] == []
    text = "".join(path.read_text() for path in folder.rglob("*") if path.is_file()).lower()
    for name in [*CATALOGUE, *OUTSIDE, "seed", "single", "pair", "none", "outside", "barely", "nuisance", "chain", "rod"]:
        assert name not in text.replace("[robot]", "")


def test_the_seal_opens_with_the_answers_of_the_plan(made):
    folder, file = made
    answers, cases = unseal(folder, file), PLAN
    assert [(a.name, a.kind, a.effects) for a in answers] == [(c.name, c.kind, c.effects) for c in cases]
    for answer, case in zip(answers, cases, strict=True):
        assert len(answer.facts["laws"]) == len(case.effects)
        for law, size, floors, reached in zip(
            answer.facts["laws"], case.sizes, answer.facts["gaps_in_noise_floors"], answer.facts["reached"], strict=False
        ):
            assert law["name"] in case.effects
            assert floors == pytest.approx(SIZES[size], rel=0.1) or not reached


@pytest.mark.parametrize("tamper", [lambda t: t.replace('"none"', '"pair"'), lambda t: t + " ", lambda t: t[:-5]])
def test_tampered_answers_are_refused(made, tmp_path, tamper):
    folder, file = made
    other = tmp_path / "answers.json"
    other.write_text(tamper(file.read_text().replace('"kind": "single"', '"kind": "none"')))
    with pytest.raises(InputError, match="hash"):
        unseal(folder, other)


def test_missing_answers_are_refused(made, tmp_path):
    with pytest.raises(InputError, match="answers"):
        unseal(made[0], tmp_path / "nowhere.json")


def test_an_interrupted_check_goes_on_and_ends_the_same(made, tmp_path):
    folder, calls = tmp_path / "check", []

    def give_up():
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make(folder, SEED, PLAN, workshop=QUICK, advance=give_up)
    assert sorted(path.name for path in folder.iterdir()) == ["case_001", "case_002"]
    first = (folder / "case_001" / "trial_01.csv").stat().st_mtime_ns
    with pytest.raises(InputError, match="begun"):
        make(folder, SEED + 1, plan_clean(SEED + 1, 3, QUICK.programs), workshop=QUICK)
    answers = make(folder, SEED, PLAN, workshop=QUICK)
    assert (folder / "case_001" / "trial_01.csv").stat().st_mtime_ns == first
    assert json.loads(answers.read_text()) == json.loads(made[1].read_text())
    assert (folder / "case_003" / "trial_01.csv").read_text() == (made[0] / "case_003" / "trial_01.csv").read_text()
    with pytest.raises(InputError, match="finished"):
        make(folder, SEED, PLAN, workshop=QUICK)


def test_answers_inside_of_the_folder_and_a_folder_in_use_are_refused(tmp_path):
    with pytest.raises(InputError, match="outside"):
        make(tmp_path / "check", 1, PLAN, tmp_path / "check" / "answers.json")
    (tmp_path / "note.txt").touch()
    with pytest.raises(InputError, match="empty"):
        make(tmp_path, 1, PLAN, Path(f"{tmp_path}-answers.json"))


def test_a_plant_that_always_diverges_is_an_error_and_leaves_no_case(tmp_path, mujoco):
    class Diverging(ChainPlant):
        def simulate(self, *args, **kwargs):
            raise SimulationFailure("diverged", None)

    broken = replace(QUICK, plants={"chain": Diverging(), "rod": Diverging()})
    with pytest.raises(SimulationFailure):
        make(tmp_path / "check", SEED, PLAN[:1], workshop=broken)
    assert list((tmp_path / "check").iterdir()) == []


def test_a_gap_between_two_sizes_belongs_to_the_nearer():
    assert [size_of(floors) for floors in (0.5, 1.3, 1.5, 3.0, 3.6, 9.0, 10.0, 99.0)] == [
        "below", "below", "barely", "barely", "medium", "medium", "large", "large",
    ]  # fmt: skip

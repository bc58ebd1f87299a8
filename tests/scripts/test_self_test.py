"""Every effect that hsr-sim simulates is found again by a diagnosis of the same model."""

from pathlib import Path

import pytest

from hsr_pin import diagnose
from hsr_pin.effects import EFFECTS

SCRIPT = "self_test"


def test_every_effect_of_the_catalogue_has_its_line(script):
    assert [case.partition(":")[0] for case in script.CASES] == list(EFFECTS)


def test_what_is_found_and_what_is_not_is_told(script, tmp_path):
    found = diagnose(script.recorded("dry_friction:level=0.05", tmp_path), effects=["dry_friction", "tip_mass"], jobs=1)
    assert script.told(found, "dry_friction:level=0.05") == "named; every value within its interval"
    assert script.told(found, "dry_friction:level=0.1").startswith("named; dry_friction.level 0.0")
    assert script.told(found, "tip_mass:mass=0.05").startswith("NOT FOUND: dry_friction is missing")


@pytest.mark.long
@pytest.mark.parametrize("effect", EFFECTS)
def test_every_effect_is_named_or_among_honest_alternatives(script, effect, tmp_path: Path):
    (case,) = [each for each in script.CASES if each.partition(":")[0] == effect]
    found = diagnose(script.recorded(case, tmp_path), jobs=1)
    assert not script.told(found, case).startswith("NOT FOUND")

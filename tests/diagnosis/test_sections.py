"""An arm of sections under opposite torques is diagnosed like any other, with the command of each section."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.change.diagnose import diagnose_change
from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.diagnosis.document import to_json
from hsr_pin.diagnosis.report import report
from hsr_pin.effects import parse_effect
from hsr_pin.errors import IdentificationError
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Dataset, Marker, Section

from ..filmed import filmed

TWO = (Section(0.14, 0.10, 1.6, 0.09), Section(0.10, 0.05, 1.4, 0.06))
ARM = ArmSpecification.in_sections(TWO, links=10, placement="mid", bending_limit=20.0)
MARKERS = (Marker("mid", 0.14), Marker("tip", 0.24))
COMMANDS = ([0.7, 0.2, -0.6, 0.1], [-0.2, 0.6, 0.5, -0.4], [0.1, -0.6, 0.2, 0.6], [-0.6, -0.3, 0.1, 0.6])


def recorded(*effects, name="two", seed=2):
    time = np.arange(121) * 0.01
    command = (time[:, None] >= 0.1 - 1e-9) * np.ones(4)
    runs = [Scenario(ARM, time, command * each, Settled(0.0), effects, MARKERS) for each in COMMANDS]
    motions = [result.raise_on_failure().trajectory for result in simulate_batch(runs)]
    numbers = {name: getattr(ARM, name) for name in ("length", "mass", "diameter", "mount", "bending")}
    return Dataset(name, trials=filmed(motions, 2e-4, seed, (ARM.keq / 1.1, ARM.damping)), sections=TWO, **numbers)


def test_its_law_is_named_under_the_torque_of_each_section_and_is_not_under_their_mean():
    dataset = recorded(parse_effect("bend_at_rest:towards_x=0.25,towards_y=-0.1"))
    asked = {"effects": ("bend_at_rest", "unequal_stiffness", "stiffening"), "links": 10, "jobs": 1, "max_effects": 1}
    found = diagnose(dataset, **asked)
    assert found.verdict.effects == ("bend_at_rest",)
    assert found.search.best.fit.named["keq_scale"] == pytest.approx(1.1, rel=0.01)
    left = found.search.best.fit.rms
    assert "bend at rest" in report(found)
    assert "torque" in to_json(found)["where"]["operating_range"]
    share = np.kron(np.array([[0.14], [0.10]]) / 0.24, np.eye(2))
    trials = [replace(t, trajectory=replace(t.trajectory, torque=t.trajectory.torque @ share)) for t in dataset.trials]
    alone = diagnose(replace(dataset, sections=(), trials=tuple(trials)), **asked)
    assert alone.search.best.fit.rms > 3 * left


@pytest.mark.long
def test_what_has_changed_in_it_is_told_with_its_size():
    old, new = recorded(name="old", seed=3), recorded(parse_effect("bend_at_rest:towards_x=0.1,towards_y=-0.05"), name="new")
    asked = {"effects": ("bend_at_rest", "unequal_stiffness", "tip_mass"), "links": 10, "jobs": 1, "max_effects": 0}
    verdict = diagnose_change(new, old, **asked).verdict
    assert (verdict.status, verdict.effects) == ("identified", ("bend_at_rest",))
    for size, true in zip(verdict.changes, (0.1, -0.05), strict=True):
        assert size.step[0] <= true <= size.step[1]


def test_arms_of_other_sections_are_no_recordings_of_one_arm():
    old = recorded()
    other = replace(old, name="other", sections=(replace(TWO[0], keq=1.7), TWO[1]))
    with pytest.raises(IdentificationError, match="sections of other: expected"):
        diagnose_change(other, old)

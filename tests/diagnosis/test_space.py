"""Missing laws of arms in space, simulated by another engine, are named, with their location."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.blind.plants.laws import actuation, elastic, mounting
from hsr_pin.blind.plants.nuisance import Nuisance
from hsr_pin.blind.plants.space import laws
from hsr_pin.blind.plants.space.chain import BallPlant
from hsr_pin.blind.plants.space.program import program
from hsr_pin.blind.plants.space.writing import MARKERS
from hsr_pin.diagnosis.diagnose import diagnose
from hsr_pin.diagnosis.document import to_json
from hsr_pin.diagnosis.report import report
from hsr_pin.diagnosis.where import SIDES
from hsr_pin.effects.catalogue import EFFECTS
from hsr_pin.effects.catalogue import laws as catalogue_of
from hsr_pin.identification.identify import identify
from hsr_pin.inference.residuals import rms
from hsr_pin.recordings.read import read_dataset

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

#: K is 8 % more than declared, C 10 % less.
TRUE = Nuisance(k=1.08, c=0.9, noise=3e-4)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Return a function that makes a dataset of a program with some laws."""

    def make(*acting, kinds="steps+releases"):
        folder = tmp_path_factory.mktemp("arm")
        plant = BallPlant(elements=16, step=4e-4)
        return read_dataset(plant.run(program(kinds), acting, 1, folder, TRUE, MARKERS))

    return make


@pytest.fixture(scope="module")
def flat(recorded):
    """Return an arm with a flat cross section: 15 % stiffer towards 0.7 rad."""
    return recorded(laws.UnequalStiffness(0.15, side=0.7), kinds="steps")


def test_another_engine_moves_the_arm_as_the_model_does(recorded):
    found = identify(recorded(), links=12)
    assert found.fit.named == pytest.approx({"keq_scale": 1.08, "damping_scale": 0.9}, rel=0.01)
    assert rms(found.fit.residuals) < 1.02 * found.experiment.noise_rms


def test_a_flat_section_is_told_with_its_direction(flat):
    found = diagnose(
        flat, effects=("unequal_stiffness", "bend_at_rest", "stiffening", "gravity_tilt"), links=6, jobs=1, max_effects=1
    )
    assert (found.verdict.status, found.verdict.effects) == ("identified", ("unequal_stiffness",))
    values = found.search.best.fit.named
    e = values["unequal_stiffness.along_x"] + 1j * values["unequal_stiffness.diagonal"]
    assert abs(e) == pytest.approx(0.15, abs=0.01) and np.angle(e) / 2 == pytest.approx(0.7, abs=0.03)
    sides = next(chart for chart in found.where.operating_range if chart.quantity == "direction of bending")
    assert [part.label for part in sides.bins] == list(SIDES)
    assert sum(part.share for part in sides.bins) == pytest.approx(1.0)
    assert found.indicators is not None and any("indicators use trials that stay" in n for n in found.experiment.notes)
    document = to_json(found)
    assert document["where"]["operating_range"]["direction_of_bending"]["unit"] == "mm"
    text = report(found)
    assert "unequal stiffness" in text and "path in the plane" not in text


def test_in_space_laws_of_one_direction_give_way_to_those_of_any():
    in_space = {law.name for law in catalogue_of(space=True)}
    assert {"bend_at_rest", "base_tilt", "torque_offset", "markers_beside", "unequal_stiffness"} < in_space
    assert not in_space & {"preset_bend", "gravity_tilt", "torque_bias", "marker_offset"}
    assert {*EFFECTS} < {law.name for law in catalogue_of(space=False)}


@pytest.mark.long
@pytest.mark.parametrize(
    ("law", "names", "values"),
    [
        (laws.BendAtRest(0.15, side=2.0), {"bend_at_rest", "torque_offset"}, {}),
        (laws.TurnedActuation(0.2), {"turned_actuation"}, {"turned_actuation.angle": 0.2}),
        (laws.WeakChamber(0.3, side=1.0), {"weak_chamber"}, {"weak_chamber.loss": 0.3, "weak_chamber.direction": 1.0}),
        (laws.BaseTilt(0.1, side=-2.0), {"base_tilt"}, {"base_tilt.towards_x": -0.0416, "base_tilt.towards_y": -0.0909}),
        (laws.MarkersBeside(0.006, side=1.0), {"markers_beside"}, {}),
        (laws.DryFriction(0.06, "prandtl"), {"dry_friction"}, {}),
        (mounting.TipMass(0.02), {"tip_mass"}, {"tip_mass.mass": 0.02}),
        (actuation.ActuatorLag(0.08), {"actuator_lag", "unequal_lag", "lag_cascade"}, {}),
        (elastic.StiffnessGradient(-0.6), {"stiffness_gradient", "soft_spot"}, {"stiffness_gradient.slope": -0.6}),
    ],
    ids=lambda each: getattr(each, "name", ""),
)
def test_of_the_whole_catalogue_the_law_is_named(recorded, law, names, values):
    found = diagnose(recorded(law), links=8, jobs=1)
    assert found.verdict.status in ("identified", "ambiguous")
    sets = [set(each) for each in found.verdict.alternatives] or [set(found.verdict.effects)]
    assert {law.name} in sets and all(each <= names for each in sets)
    best = found.search.leader((law.name,))
    for name, value in values.items():
        assert best.fit.named[name] == pytest.approx(value, abs=0.03 * max(abs(value), 0.3))


@pytest.mark.long
def test_an_arm_that_lacks_nothing_is_said_to(recorded):
    found = diagnose(replace(recorded(), description=""), links=8, jobs=1)
    assert found.verdict.status == "parameters"

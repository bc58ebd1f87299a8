"""Changes of arms in space are found in recordings of another engine, with a discrepancy that no model here has."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hsr_pin.blind.plants.laws import actuation, mounting
from hsr_pin.blind.plants.nuisance import Nuisance
from hsr_pin.blind.plants.space import laws
from hsr_pin.blind.plants.space.chain import BallPlant
from hsr_pin.blind.plants.space.program import program
from hsr_pin.blind.plants.space.writing import MARKERS
from hsr_pin.diagnosis.change.diagnose import diagnose_change
from hsr_pin.diagnosis.change.discrepancy import features
from hsr_pin.diagnosis.change.document import history_to_json
from hsr_pin.diagnosis.change.fitting import initial_estimates
from hsr_pin.diagnosis.change.frame import framed
from hsr_pin.diagnosis.change.history import history
from hsr_pin.diagnosis.change.hypotheses import change_hypotheses
from hsr_pin.diagnosis.change.pair import pair
from hsr_pin.diagnosis.change.report import report
from hsr_pin.effects import effect_named
from hsr_pin.effects.effect import neutral
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import Part
from hsr_pin.inference.fit import fit
from hsr_pin.recordings.read import read_dataset

pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")

#: K is 8 % more than declared, C 10 % less, the markers sit a little off.
TRUE = Nuisance(k=1.08, c=0.9, noise=4e-4, placement=5e-5)
#: In every recording, and in no model: bending to one side drives the arm to the next.
LACKS = laws.CrossCoupling(0.03)
#: What keeps the tests short.
QUICK = {"effects": ["tip_mass", "base_tilt"], "max_effects": 0, "links": 6, "jobs": 1}
#: The turn of the cameras, in the axes of the base of an arm that hangs: towards x, towards y, and about it.
TURN = np.array([0.05, -0.04, 0.03])


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Return a function that makes a recording of a session with some laws."""
    made = {}

    def make(session, *acting, kinds="steps", true=TRUE):
        key = (session, acting, kinds, true)
        if key not in made:
            folder = tmp_path_factory.mktemp("arm") / f"session_{session}"
            plant = BallPlant(elements=16, step=2e-4)
            made[key] = read_dataset(plant.run(program(kinds), (LACKS, *acting), 1, folder, true, MARKERS, session=session))
        return made[key]

    return make


@pytest.fixture(scope="module")
def old(recorded):
    return recorded(0)


@pytest.fixture(scope="module")
def sessions(recorded, old):
    """Three sessions: nothing has changed in the second, and the third has a payload."""
    return history([old, recorded(1), recorded(2, mounting.TipMass(0.02))], **QUICK)


def turned(dataset, turn):
    """Return a recording of a hanging arm seen by cameras whose frame is rotated by a rotation vector in the axes of its base."""
    x, y, twist = turn
    rotation = Rotation.from_rotvec(
        [-y, -x, -twist]
    )  # about (-y, x, twist) of the base, whose axes are x, -y and -z of the world

    def seen(track):
        return replace(track, positions=track.positions @ rotation.as_matrix().T)

    return replace(dataset, trials=tuple(replace(trial, trajectory=seen(trial.trajectory)) for trial in dataset.trials))


def within(size, true):
    return size.step[0] <= true <= size.step[1]


@pytest.mark.long
def test_nothing_has_changed_where_nothing_has(sessions):
    verdict = sessions.diagnoses[0].verdict
    assert (verdict.status, verdict.effects, verdict.changes) == ("unchanged", (), ())
    assert 0 < verdict.limits["keq_scale"] < 0.1


@pytest.mark.long
def test_the_predicted_scatter_is_that_of_noise_along_three_axes(sessions):
    frame = sessions.diagnoses[0].found.frame
    count = np.mean([bins.counts[bins.counts > 0].mean() for bins in frame.pair.bins])
    assert frame.off() == pytest.approx(frame.scatter, rel=0.3)
    assert frame.off() > 0.9 * TRUE.noise * np.sqrt(3 / count)


@pytest.mark.long
def test_a_mass_that_came_is_named_alone_with_its_size(sessions):
    verdict = sessions.diagnoses[1].verdict
    assert (verdict.status, verdict.effects) == ("identified", ("tip_mass",))
    (size,) = verdict.changes
    assert within(size, 0.02)
    assert size.step[1] - size.step[0] < 0.01


@pytest.mark.long
def test_over_the_sessions_it_is_certain_from_the_one_in_which_it_came(sessions):
    mass = next(each for each in sessions.quantities if each.name == "tip_mass.mass")
    assert mass.first == 2


@pytest.mark.long
def test_the_report_shows_three_axes_and_the_document_is_json(sessions):
    text = report(sessions)
    for axis in "xyz":
        assert f"{axis}: deviation from the prediction of the first recording" in text
    document = json.loads(json.dumps(history_to_json(sessions), allow_nan=False))
    assert document["verdict"]["effects"] == ["tip_mass"]
    assert [each["status"] for each in document["verdicts"]] == ["unchanged", "identified"]


@pytest.fixture(scope="module")
def tilted(recorded, old):
    """Whitened residuals of a recording whose base was rotated by 0.06 rad in a direction between the axes."""
    both = pair(prepare(old), prepare(recorded(3, laws.BaseTilt(0.06, side=-0.6))))
    base = fit(both.old, Hypothesis(links=6))
    return framed(both, base.hypothesis, base.values)[0]


@pytest.mark.long
def test_what_goes_to_any_side_is_guessed_with_its_side(tilted):
    (asked,) = change_hypotheses(tilted.hypothesis, tilted.values, [Part("base_tilt", neutral(effect_named("base_tilt")))])[2:]
    estimate = initial_estimates(tilted, asked)
    tilt = 0.06 * np.exp(-0.6j)
    assert estimate.starts[0] == pytest.approx([tilt.real, tilt.imag], abs=0.01)
    whole = float(tilted.seen @ tilted.seen)
    assert whole - estimate.square > 0.9 * (whole - len(tilted.seen))  # all but noise


@pytest.mark.long
def test_an_effect_of_any_side_that_is_there_is_looked_at_from_where_it_is(tilted):
    part = Part("torque_offset", neutral(effect_named("torque_offset")))
    model = tilted.hypothesis.with_part(part)
    there = np.append(tilted.values, [0.99, -0.1])
    probes = next(each for each in change_hypotheses(model, there, [part]) if each.names == ("torque_offset",)).probes
    assert probes.shape[1:] == (2, 2)
    for block in probes:
        steps = block - there[-2:]
        assert steps[~np.eye(2, dtype=bool)] == pytest.approx(0.0)
        assert steps[0, 0] < 0 < steps[1, 1]  # the first is near its upper bound


def test_features_tell_motion_to_either_side(old):
    both = pair(prepare(old), prepare(old))
    found = features(both, Hypothesis(links=6), Hypothesis(links=6).start)
    commands = np.concatenate([run.torque for run in both.experiment.runs])
    assert len({each.shape[1] for each in found}) == 1
    columns = np.concatenate(found)[:, :-3]
    assert columns.shape[1] == 2 * 6
    assert np.ptp(commands.imag) > 0 and (np.ptp(columns, axis=0) > 1.0).all()


def test_an_arm_in_a_plane_is_another_and_so_is_one_whose_markers_stand_elsewhere(old):
    flat = replace(old, bending="plane", torsion=np.inf, trials=tuple(map(_in_plane, old.trials)))
    for new in (flat, _moved(old)):
        with pytest.raises(IdentificationError, match=r"(bending|markers) of session_0: expected"):
            diagnose_change(new, old, **QUICK)


def _in_plane(trial):
    torque = trial.trajectory.torque
    return replace(trial, trajectory=replace(trial.trajectory, torque=None if torque is None else torque[:, 0]))


def _moved(dataset):
    def elsewhere(trial):
        markers = tuple(replace(m, angle=m.angle + 1.0) if m.radius else m for m in trial.trajectory.markers)
        return replace(trial, trajectory=replace(trial.trajectory, markers=markers))

    return replace(dataset, trials=tuple(map(elsewhere, dataset.trials)))


def test_laws_that_do_not_hold_there_are_refused(old):
    lying = replace(old, mount="horizontal")
    for dataset, name in ((old, "frame_turn"), (lying, "base_rotation")):
        with pytest.raises(IdentificationError, match=f"effects: expected .*{name}"):
            diagnose_change(dataset, dataset, **{**QUICK, "effects": [name]})


@pytest.fixture(scope="module")
def same(recorded, old):
    """Comparison of two unchanged sessions with the whole catalogue."""
    return diagnose_change(recorded(4), old, max_effects=1, links=8, jobs=1)


def told(new, old, same):
    return diagnose_change(new, old, reference=same.reference, links=8, jobs=1).verdict


@pytest.mark.long
def test_of_the_whole_catalogue_nothing_is_told_where_nothing_has_changed(same):
    assert same.verdict.status == "unchanged"


@pytest.fixture(scope="module")
def heavier(recorded, old, same):
    """Comparison of two sessions with the whole catalogue, of which the second has a payload."""
    return told(recorded(5, mounting.TipMass(0.02)), old, same)


@pytest.mark.long
@pytest.mark.xfail(strict=True, reason="a heavier arm leaves as much of these five steps, and what is not ruled out is said")
def test_of_the_whole_catalogue_a_mass_that_came_is_told_alone_with_its_size(heavier):
    _told_alone(heavier, "tip_mass", {"tip_mass.mass": 0.02})


@pytest.mark.long
def test_of_the_whole_catalogue_a_mass_that_came_is_told_first_with_its_size(heavier):
    assert heavier.alternatives == (("tip_mass",), ("mass_scale",))
    mass = next(size for size in heavier.changes if size.parameter == "tip_mass.mass")
    assert within(mass, 0.02), mass.step


@pytest.mark.long
def test_of_the_whole_catalogue_a_lag_that_came_is_told_alone_or_beside_the_law_that_holds_it(recorded, old, same):
    verdict = told(recorded(5, actuation.ActuatorLag(0.05)), old, same)
    names = set(verdict.alternatives) or {verdict.effects}
    assert ("actuator_lag",) in names and names <= {("actuator_lag",), ("unequal_lag",)}
    lag = next(size for size in verdict.changes if size.parameter == "actuator_lag.time_constant")
    assert lag.after == pytest.approx(0.05, abs=0.001)


@pytest.mark.long
def test_of_the_whole_catalogue_a_stiffness_is_told_alone_with_its_size(recorded, old, same):
    softer = recorded(6, true=replace(TRUE, k=0.93 * TRUE.k))
    _told_alone(told(softer, old, same), "keq_scale", {"keq_scale": 0.93})


@pytest.mark.long
def test_a_turn_of_the_cameras_is_told_from_all_but_a_base_that_is_turned_with_its_three_numbers(recorded, old, same):
    verdict = told(turned(recorded(7), TURN), old, same)
    assert set(verdict.alternatives) == {("base_rotation",), ("frame_rotation",)}
    seen = {size.parameter: size for size in verdict.changes}
    for name, angle in zip(("towards_x", "towards_y", "twist"), TURN, strict=True):
        assert within(seen[f"frame_rotation.{name}"], angle)


@pytest.mark.long
def test_what_is_turned_about_the_line_on_which_the_arm_hangs_is_the_cameras_or_the_base(recorded, old, same):
    verdict = told(turned(recorded(7), np.array([0.0, 0.0, 0.06])), old, same)
    assert set(verdict.alternatives) == {("base_rotation",), ("frame_rotation",)}


def _told_alone(verdict, name, true):
    assert (verdict.status, verdict.effects) == ("identified", (name,))
    assert {size.parameter for size in verdict.changes} == set(true)
    for size in verdict.changes:
        assert within(size, true[size.parameter]), (size.parameter, size.step)

"""The JSON of a fit or of a diagnosis gives back the model that was found; anything else is one clear line."""

import copy
import json

import pytest

from hsr_pin.errors import EffectError, InputError, SpecificationError
from hsr_pin.export.document import read_result
from hsr_pin.identification.document import to_json
from hsr_pin.identification.identify import identify
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Section

ARM = {
    "length": 0.3, "mass": 0.2, "diameter": 0.05, "mount": "upright", "links": 6, "placement": "mid",
    "levels": [{"keq": 1.11, "damping": 0.05, "tip_mass": 0.01}, {"keq": 2.33, "damping": 0.1, "tip_mass": 0.0}],
    "markers": [{"name": "tip", "arc_length": 0.3}],
}  # fmt: skip
BEST = {
    "effects": ["actuator_lag", "hysteresis"],
    "options": {"hysteresis.form": "maxwell_slip"},
    "parameters": {
        "keq_scale": {"value": 1.1, "unit": "1", "ci95": [1.0, 1.2]},
        "damping_scale": {"value": 0.8, "unit": "1", "ci95": [0.7, 0.9]},
        "actuator_lag.time_constant": {"value": 0.05, "unit": "s", "ci95": [0.04, 0.06]},
        "hysteresis.amplitude": {"value": 0.2, "unit": "rad", "ci95": [0.1, 0.3]},
        "hysteresis.yield_angle": {"value": 0.4, "unit": "rad", "ci95": [0.3, 0.5]},
    },
}
PLAIN = {"effects": [], "options": {}, "parameters": {"keq_scale@1.11": {"value": 1.2}, "keq_scale@2.33": {"value": 0.9}}}


def diagnosis(status="identified", effects=("actuator_lag", "hysteresis"), **more):
    verdict = {"status": status, "effects": list(effects), "alternatives": [], "sentence": "Said so."}
    return {"schema": 1, "dataset": "made", "verdict": verdict, "candidates": [BEST, PLAIN], "arm": ARM, **more}


@pytest.fixture
def written(tmp_path):
    def write(document):
        path = tmp_path / "result.json"
        path.write_text(document if isinstance(document, str) else json.dumps(document), encoding="utf-8")
        return path

    return write


def test_a_diagnosis_gives_its_best_model(written):
    model = read_result(written(diagnosis(news="of a later version")), keq=1.11)
    arm = model.arm
    assert (arm.keq, arm.damping) == pytest.approx((1.1 * 1.11, 0.8 * 0.05))
    assert (arm.length, arm.mass, arm.tip_mass, arm.mount, arm.links, arm.placement) == (0.3, 0.2, 0.01, "upright", 6, "mid")
    lag, loop = model.effects
    assert lag.time_constant == 0.05
    assert (loop.amplitude, loop.yield_angle, loop.form) == (0.2, 0.4, "maxwell_slip")
    assert [(marker.name, marker.arc_length) for marker in model.markers] == [("tip", 0.3)]
    assert model.origin[0] == "a diagnosis of made: Said so."


@pytest.mark.parametrize("status", ["parameters", "no_gap"])
def test_a_verdict_without_effects_takes_the_model_without_effects(written, status):
    model = read_result(written(diagnosis(status, ())), keq=2.33)
    assert model.effects == ()
    assert model.arm.keq == pytest.approx(0.9 * 2.33)


@pytest.mark.parametrize("status", ["ambiguous", "unexplained"])
def test_an_open_verdict_gives_the_best_and_says_so(written, status):
    model = read_result(written(diagnosis(status, ())), keq=1.11)
    assert [effect.name for effect in model.effects] == ["actuator_lag", "hysteresis"]
    assert "does not determine" in model.origin[1]


def test_an_amplitude_that_goes_with_the_level_is_that_of_the_level(written):
    found = {**BEST, "resized": ["hysteresis"]}
    loops = [read_result(written(diagnosis(candidates=[found])), keq=keq).effects[1] for keq in (1.11, 2.33)]
    assert [loop.amplitude for loop in loops] == pytest.approx([0.2, 0.2 * 1.11 / 2.33])
    assert [loop.yield_angle for loop in loops] == [0.4, 0.4]


def test_of_sizes_at_each_level_that_of_the_level_is_taken(written):
    sizes = {"gravity_tilt.angle@1.11": {"value": -0.06}, "gravity_tilt.angle@2.33": {"value": 0.02}}
    found = {"effects": ["gravity_tilt"], "options": {"gravity_tilt.frame": "base"}, "parameters": sizes}
    document = diagnosis(effects=["gravity_tilt"], candidates=[found])
    for keq, angle in ((1.11, -0.06), (2.33, 0.02)):
        (tilt,) = read_result(written(document), keq=keq).effects
        assert (tilt.angle, tilt.frame) == (angle, "base")


def test_a_level_of_more_digits_than_its_name_has_is_found(written):
    sizes = {"gravity_tilt.angle@1.23457": {"value": -0.06}, "gravity_tilt.angle@2.33": {"value": 0.02}}
    found = {"effects": ["gravity_tilt"], "options": {}, "parameters": sizes}
    levels = [{**level, "keq": keq} for level, keq in zip(ARM["levels"], (1.2345678, 2.33), strict=True)]
    document = diagnosis(effects=["gravity_tilt"], candidates=[found], arm={**ARM, "levels": levels})
    (tilt,) = read_result(written(document), keq=1.2345678).effects
    assert tilt.angle == -0.06


def test_effects_act_in_the_order_that_the_arm_tells(written):
    arm = {**ARM, "effects": [{"name": "hysteresis"}, {"name": "actuator_lag"}]}
    assert [effect.name for effect in read_result(written(diagnosis(arm=arm)), keq=1.11).effects] == [
        "hysteresis",
        "actuator_lag",
    ]
    other = {**ARM, "effects": [{"name": "tip_mass"}]}
    assert [effect.name for effect in read_result(written(diagnosis(arm=other)), keq=1.11).effects] == BEST["effects"]


def test_an_open_number_of_the_arm_may_stand_among_the_effects(written):
    found = {"effects": ["torque_gain"], "options": {}, "parameters": {"torque_gain": {"value": 1.3}}}
    model = read_result(written(diagnosis(effects=["torque_gain"], candidates=[found])), keq=1.11)
    assert model.effects == ()
    assert model.torque_gain == 1.3


def test_of_a_stiffness_that_changed_over_the_session_the_last_is_taken_and_told(written):
    numbers = {"keq_scale": {"value": 0.9}, "keq_drift": {"value": -0.2}, "keq_drift.settling": {"value": 0.5}}
    found = {"effects": ["keq_drift"], "options": {}, "parameters": numbers}
    model = read_result(written(diagnosis("partly_identified", (), candidates=[found])), keq=1.11)
    assert model.effects == ()
    assert model.arm.keq == pytest.approx(1.11 * 0.9 * 0.8)
    assert "last trial" in " ".join(model.origin)


def test_changes_are_made_last(written):
    model = read_result(written(diagnosis()), keq=1.11, changes={"links": 9, "tip_mass": 0.05, "mount": "hanging"})
    assert (model.arm.links, model.arm.tip_mass, model.arm.mount) == (9, 0.05, "hanging")


@pytest.fixture(scope="module")
def found(heavy_tip):
    return identify(heavy_tip, free=["keq", "damping", "tip_mass"], links=4)


def test_a_fit_gives_back_the_fitted_arm(found, written):
    model = read_result(written(to_json(found)))
    named = found.fit.named
    declared = found.experiment.dataset.trials[0]
    assert model.arm.keq == pytest.approx(named["keq_scale"] * declared.keq)
    assert model.arm.damping == pytest.approx(named["damping_scale"] * declared.damping)
    assert (model.arm.links, model.arm.placement) == (4, "mid")
    (mass,) = model.effects
    assert mass.mass == pytest.approx(named["tip_mass.mass"])
    assert mass.mass == pytest.approx(0.03, rel=0.1)
    assert [marker.name for marker in model.markers] == [marker.name for marker in found.experiment.dataset.markers]


def test_a_size_that_was_free_at_each_level_is_that_of_the_level_that_is_asked_for(found, written):
    document = to_json(found)
    (level,) = document["arm"]["levels"]
    stiffer = {**level, "keq": 2 * level["keq"]}
    sizes = {f"tip_mass.mass@{level['keq']:g}": {"value": 0.02}, f"tip_mass.mass@{stiffer['keq']:g}": {"value": 0.05}}
    document["arm"]["levels"].append(stiffer)
    document["parameters"] = sizes | {"tip_mass.mass@each": {"value": 1.0}}  # a name that no level has
    path = written(document)
    assert [read_result(path, keq=at["keq"]).effects[0].mass for at in (level, stiffer)] == [0.02, 0.05]


def test_a_document_without_the_arm_takes_it_from_the_recordings(found, written, tmp_path):
    document = to_json(found)
    whole = read_result(written(document))
    del document["arm"]
    path = written(document)
    with pytest.raises(
        InputError, match=r"result\.json: arm: expected a section with .*got none; give the recordings with --dataset"
    ):
        read_result(path)
    write_dataset(found.experiment.dataset, tmp_path / "recordings")
    again = read_result(path, dataset=tmp_path / "recordings")
    assert again.arm == whole.arm
    assert again.effects == whole.effects


@pytest.mark.parametrize(
    ("document", "said"),
    [
        ("{", r"result\.json:1:2: invalid JSON: expected the JSON of hsr-fit --json or hsr-diagnose --json"),
        ("[]", "not a result: .*got list"),
        ("{}", "not a result"),
        ({"schema": 3, "parameters": {}}, "schema: expected 1 or 2, got 3"),
        (diagnosis(candidates=[]), r"result\.json: candidates: expected a list of at least 1, got \[\]"),
        (diagnosis(arm={**ARM, "length": None}), r"arm\.length: expected a number from 0\.0001 to 1000, got None"),
        (
            diagnosis(candidates=[{**BEST, "parameters": {"keq_scale": {"value": None}}}]),
            r"candidates\[0\]\.parameters\.keq_scale: expected a number from 0\.1 to 10, got None",
        ),
        (diagnosis(arm={**ARM, "levels": []}), r"arm\.levels: expected a list of at least 1, got \[\]"),
    ],
)
def test_what_is_no_result_is_one_line(written, document, said):
    with pytest.raises(InputError, match=said):
        read_result(written(document), keq=1.11)


#: Damages: the way to a value of a diagnosis, the value put there, and what is said of it.
HUGE = 10**400
DAMAGES = [
    (("arm", "markers"), [], r"arm\.markers: expected a list of at least 1, got \[\]"),
    (("arm", "markers", 0), "tip", r"arm\.markers\[0\]: expected a table, got 'tip'"),
    (("arm", "markers", 0, "arc_length"), -0.1, r"arm\.markers\[0\]\.arc_length: expected a number from 0 to 1000, got -0\.1"),
    (("arm", "markers", 0, "arc_length"), 0.4, r"arc_length of marker tip: expected from 0 to the arm's length, 0\.3 m"),
    (("arm", "markers", 0, "radius"), 1e6, r"arm\.markers\[0\]\.radius: expected a number from 0 to 1000, got 1000000\.0"),
    (("arm", "markers", 0, "name"), "a\x1bb", r"arm\.markers\[0\]\.name: expected a printable string of one line"),
    (("arm", "markers", 0, "name"), "\ud800", r"arm\.markers\[0\]\.name: expected a printable string of one line"),
    (("arm", "markers"), [ARM["markers"][0]] * 2, r"markers: expected a unique name for each marker, got 'tip' twice"),
    (("arm", "levels"), "1.11", r"arm\.levels: expected a list of at least 1, got '1\.11'"),
    (("arm", "levels", 0), 1.11, r"arm\.levels\[0\]: expected a table, got 1\.11"),
    (("arm", "levels", 0), {"damping": 0.05}, r"arm\.levels\[0\]\.keq: expected a value, got none"),
    (("arm", "levels", 0, "keq"), HUGE, r"arm\.levels\[0\]\.keq: expected a number from 1e-09 to 1e\+09, got 1000"),
    (("arm", "mass"), "0.2", r"arm\.mass: expected a number from 1e-12 to 1e\+06, got '0\.2'"),
    (("arm", "mass"), True, r"arm\.mass: expected a number .*got True"),
    (("arm", "mass"), float("inf"), r"arm\.mass: expected a number .*got inf"),
    (("arm", "mount"), ["hanging"], r"arm\.mount: expected hanging or upright or horizontal"),
    (("arm", "links"), 2.5, r"links: expected a whole number from 1 to 1000, got 2\.5"),
    (("arm", "inputs"), {}, r"arm\.inputs: expected a list, got {}"),
    (("arm", "effects"), [{}], r"arm\.effects\[0\]\.name: expected a value, got none"),
    (("arm",), [], r"arm: expected a table, got \[\]"),
    (("verdict",), [], r"verdict: expected a table, got \[\]"),
    (("verdict", "effects"), None, r"verdict\.effects: expected a list, got None"),
    (("candidates",), {"a": 1}, r"candidates: expected a list of at least 1"),
    (("candidates", 0, "effects"), "lag", r"candidates\[0\]\.effects: expected a list, got 'lag'"),
    (("candidates", 0, "effects"), [["lag"]], r"candidates\[0\]\.effects\[0\]: expected a string"),
    (("candidates", 0, "options"), {"hysteresis.shape": "x"}, r"an option of hysteresis: expected form, got 'shape'"),
    (("candidates", 0, "options"), {"actuator_lag.x": "x"}, r"an option of actuator_lag: expected order"),
    (("candidates", 0, "options"), {"hysteresis.form": "loose"}, r"hysteresis\.form: expected .* got 'loose'"),
    (("candidates", 0, "parameters", "torque_gain"), 1e300, r"torque_gain: expected a number from 0\.1 to 10, got 1e\+300"),
    (("candidates", 0, "parameters", "keq_scale@1.11"), float("nan"), r"keq_scale@1\.11: expected a number .*got nan"),
    (("candidates", 0, "parameters", "keq_scale"), {"values": 1}, r"parameters\.keq_scale: expected a number .*got None"),
    (("candidates", 0, "parameters", "hysteresis.amplitude"), -HUGE, r"hysteresis\.amplitude: expected a number, got -1000"),
    (("candidates", 0, "parameters", "hysteresis.amplitude"), 1e9, r"result\.json: hysteresis\.amplitude: expected 0 to "),
    (("dataset",), 3, r"dataset: expected a string, got 3"),
]  # fmt: skip


@pytest.mark.parametrize(("way", "value", "said"), DAMAGES)
def test_a_damaged_result_is_one_line_that_says_where(written, way, value, said):
    document = copy.deepcopy(diagnosis())
    *parts, last = way
    place = document
    for part in parts:
        place = place[part]
    place[last] = value
    with pytest.raises(InputError, match=said) as caught:
        read_result(written(document), keq=1.11)
    assert str(caught.value).isprintable() and "result.json: " in str(caught.value)


@pytest.mark.parametrize(("name", "value"), [("torque_gain", 1e300), ("keq_scale", "1"), ("tip_mass.mass", float("nan"))])
def test_a_damaged_fit_is_one_line_that_says_where(found, written, name, value):
    document = to_json(found)
    document["parameters"][name] = value
    with pytest.raises(InputError, match=rf"result\.json: parameters\.{name}: expected a number"):
        read_result(written(document))


def test_several_stiffnesses_ask_which(written):
    path = written(diagnosis())
    with pytest.raises(InputError, match=r"--keq: expected one of the declared stiffnesses, 1\.11 or 2\.33 Nm/rad, got none"):
        read_result(path)
    with pytest.raises(InputError, match=r"--keq: expected a declared stiffness, 1\.11 or 2\.33 Nm/rad, got 1\.5"):
        read_result(path, keq=1.5)


def test_a_level_that_was_not_fitted_is_refused(written):
    plain = {**PLAIN, "parameters": {"keq_scale@1.11": {"value": 1.2}}}
    with pytest.raises(InputError, match=r"keq_scale: expected a value at Keq 2\.33 Nm/rad, got keq_scale@1\.11"):
        read_result(written(diagnosis("parameters", (), candidates=[plain])), keq=2.33)


def test_effects_that_are_not_known_are_refused(written):
    odd = {"effects": ["magic"], "options": {}, "parameters": {}}
    with pytest.raises(EffectError, match=r"effect: expected .*got 'magic'"):
        read_result(written(diagnosis("ambiguous", (), candidates=[odd])), keq=1.11)


def test_the_arm_of_a_result_is_an_arm(written):
    assert isinstance(read_result(written(diagnosis()), keq=2.33).arm, ArmSpecification)


def test_an_arm_in_space_keeps_its_torsion_and_its_markers_beside(written):
    beside = [{"name": "side", "arc_length": 0.2, "radius": 0.03, "angle": 1.0}, {"name": "tip", "arc_length": 0.3}]
    arm = {**ARM, "bending": "space", "markers": beside}
    lag = {**BEST, "effects": ["actuator_lag"], "options": {}}
    document = {**diagnosis(effects=["actuator_lag"], arm=arm | {"torsion": 0.7}), "candidates": [lag]}
    model = read_result(written(document), keq=1.11)
    assert (model.arm.bending, model.arm.torsion) == ("space", 0.7)
    assert [(m.name, m.radius, m.angle) for m in model.markers] == [("side", 0.03, 1.0), ("tip", 0.0, 0.0)]
    assert read_result(written({**document, "arm": arm | {"torsion": None}}), keq=1.11).arm.torsion == float("inf")
    with pytest.raises(InputError, match=r"arm.bending: expected plane or space, got 'sideways'"):
        read_result(written({**document, "arm": arm | {"bending": "sideways"}}), keq=1.11)
    with pytest.raises(InputError, match=r"arm.torsion: expected a number"):
        read_result(written({**document, "arm": arm | {"torsion": "much"}}), keq=1.11)


SECTIONS = [{"length": 0.2, "mass": 0.15, "keq": 1.5, "damping": 0.09}, {"length": 0.1, "mass": 0.05, "keq": 4.3, "damping": 0.1}]
INPUTS = [{"name": "P1", "unit": "bar", "torque": [0.3, 0, 0, 0]}, {"name": "pull", "unit": "N", "torque": [0, 0.01, 0, 0.02]}]


def in_sections(**more):
    lag = {**BEST, "effects": ["actuator_lag"], "options": {}}
    arm = {**ARM, "bending": "space", "sections": SECTIONS, "inputs": INPUTS, **more}
    return {**diagnosis(effects=["actuator_lag"], arm=arm), "candidates": [lag]}


def test_an_arm_of_sections_is_read_with_them_and_tells_what_its_inputs_give(written):
    model = read_result(written(in_sections()), keq=2.33, changes={"links": 12})
    assert model.arm.sections == tuple(Section(**row) for row in SECTIONS)
    assert (model.arm.keq, model.arm.links, model.inputs) == (pytest.approx(1.1 * 2.33), 12, 2)
    assert model.origin[-2:] == (
        "P1: each bar corresponds to a command of (0.3, 0, 0, 0) N m",
        "pull: each N corresponds to a command of (0, 0.01, 0, 0.02) N m",
    )


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (
            {"sections": [{**SECTIONS[0], "keq": "stiff"}]},
            r"arm\.sections\[0\]\.keq: expected a number from 1e-09 to 1e\+09, got 'stiff'",
        ),
        (
            {"sections": [{**SECTIONS[0], "mass": -1}], "inputs": []},
            r"arm\.sections\[0\]\.mass: expected a number from 1e-12 to 1e\+06, got -1",
        ),
        ({"sections": "two"}, r"arm\.sections: expected a list, got 'two'"),
        (
            {"inputs": [{**INPUTS[0], "torque": [0.3, 0]}]},
            r"arm\.inputs\[0\]\.torque: expected 4 numbers, two for each section, got 2",
        ),
        ({"inputs": [{**INPUTS[0], "torque": [0.3, 0, None, 0]}]}, r"arm\.inputs\[0\]\.torque\[2\]: expected a number, got None"),
        ({"bending": "plane"}, "sections: expected none where the arm bends in a plane"),
    ],
)
def test_sections_that_are_none_are_refused(written, more, said):
    with pytest.raises((InputError, SpecificationError), match=said):
        read_result(written(in_sections(**more)), keq=1.11)

"""Missing causes are named for a user-defined function: a mass on a spring."""

import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.explain import Cause, Model, Trial, amplitude, explain, explain_change, factor, shape
from hsr_pin.explain.recordings import CauseVariant, ExtendedModel, Recordings
from hsr_pin.inference.fit import fit

STEP = 0.02
TIME = np.arange(0, 4, STEP)


def simulate(values, trial):
    """Return the position [m] of a mass of 1 kg on a spring of 40 N/m under a force, by semi-implicit steps of 5 ms."""
    k, c = 40 * values["stiffness"], 0.8 * values["damping"]
    delay, bias, level = values["delay.time"], values["bias.force"], values["friction.level"]
    cubic = values["hardening.cubic"]
    fine = np.arange(0, TIME[-1] + 0.0025, 0.005)
    force = np.interp(fine - delay, TIME, trial.inputs) + bias
    x, v, seen = 0.0, values.get("start", 0.0), np.empty(len(fine))
    for n, f in enumerate(force):
        seen[n] = x
        pull = f - k * x * (1 + cubic * x * x) - level * np.tanh(v / 0.01)
        v = (v + 0.005 * pull) / (1 + 0.005 * c)
        x += 0.005 * v
    return {"x": np.interp(TIME, fine, seen)}


CAUSES = (
    Cause("friction", "friction", (amplitude("level", 0.1, "N", lower=0),), "dry friction"),
    Cause("hardening", "elastic", (amplitude("cubic", 3.0),), "a spring that hardens"),
    Cause("delay", "actuation_time", (amplitude("time", 0.02, "s", lower=0, upper=0.3),), "the force comes late"),
    Cause("bias", "actuation_map", (amplitude("force", 0.2, "N"),), "a constant force"),
)
MODEL = Model(simulate, (factor("stiffness"), factor("damping", 1.0)), CAUSES, name="mass on a spring", units={"x": "m"})


def trials(seed=0, unit=1.0, start=0.0, **true):
    generator = np.random.default_rng(seed)
    found = []
    for number, size in enumerate((1.0, 2.0, -3.0, 4.0)):
        force = size * np.where(TIME < 0.4, 0, np.where(TIME < 2.5, 1, 0.3)) + 0.5 * np.sin((1 + number) * TIME)
        bare = Trial(f"trial {number}", TIME, {"x": 0 * TIME}, force)
        own = {"start": start * generator.normal()} if start else {}
        x = simulate(MODEL.neutral | {"stiffness": 1.1, "damping": 0.7} | true | own, bare)["x"]
        x = x + 2e-4 * generator.normal(size=len(TIME))
        found.append(Trial(bare.name, TIME, {"x": unit * x}, force, own={"start": start} if start else {}))
    return found


@pytest.mark.parametrize(
    "true", [{"friction.level": 0.2}, {"delay.time": 0.05}, {"bias.force": 0.3, "hardening.cubic": 6.0}], ids=repr
)
def test_what_is_missing_is_named_with_its_size(true):
    found = explain(MODEL, trials(**true))
    assert (found.verdict.status, set(found.verdict.effects)) == ("identified", {name.partition(".")[0] for name in true})
    for name, value in true.items():
        assert found.values[name] == pytest.approx(value, rel=0.05)
    assert found.ladder[-2].rms < 0.3 * found.ladder[1].rms
    assert "is missing from the model" in repr(found) or "are missing from the model" in repr(found)
    json.dumps(found.to_json(), allow_nan=False)


def test_fitted_parameters_that_explain_it_leave_no_cause():
    found = explain(MODEL, trials())
    assert (found.verdict.status, found.verdict.effects) == ("parameters", ())


def test_what_is_not_offered_gets_no_wrong_name():
    found = explain(MODEL, trials(**{"hardening.cubic": 8.0}), causes=["bias"])
    assert found.verdict.status == "unexplained" and not found.verdict.effects


def test_the_verdict_is_the_same_in_other_units():
    true = {"friction.level": 0.2}
    metres, millimetres = explain(MODEL, trials(**true)), explain(_in_millimetres(), trials(unit=1e3, **true))  # a local function
    assert metres.verdict.effects == millimetres.verdict.effects == ("friction",)
    assert metres.verdict.confidence == pytest.approx(millimetres.verdict.confidence, abs=0.01)


def _in_millimetres():
    return replace(MODEL, predict=lambda values, trial: {"x": 1e3 * simulate(values, trial)["x"]})


def test_trials_that_are_set_aside_decide_where_the_ladder_is_told():
    found = explain(MODEL, trials(**{"friction.level": 0.2}), test=["trial 3"])
    assert [run.name for run in found.recordings.runs] == ["trial 0", "trial 1", "trial 2"]
    assert found.verdict.effects == ("friction",) and found.ladder[-2].rms < 3


def test_of_the_experiments_that_are_offered_the_one_that_tells_alternatives_apart_is_first():
    same = Cause("twin", "actuation_map", (amplitude("force", 0.2, "N"),), "does what the bias does, but where nothing is pushed")

    def predict(values, trial):
        pushed = 0.0 if trial.name == "unpushed" else values["twin.force"]
        return simulate(values | {"bias.force": values["bias.force"] + pushed}, trial)

    model = replace(MODEL, predict=predict, causes=(*CAUSES, same))
    offered = [Trial(name, TIME, {"x": 0 * TIME}, 0 * TIME + size) for name, size in (("pushed", 2.0), ("unpushed", 0.0))]
    found = explain(model, trials(**{"bias.force": 0.3}), experiments=offered)
    assert {names for names in found.verdict.alternatives} >= {("bias",), ("twin",)}
    assert found.next_experiment[0][0] == "unpushed"


KNOWN = MODEL.neutral | {"stiffness": 1.1, "damping": 0.7, "friction.level": 0.2}


@pytest.mark.parametrize(
    ("change", "name", "value"),
    [({"bias.force": 0.1}, "bias.force", 0.1), ({"stiffness": 1.155}, "stiffness_changed.stiffness", 1.05)],
    ids=["bias", "stiffness"],
)
def test_what_has_changed_is_named_with_its_size(change, name, value):
    old = {"friction.level": 0.2}
    found = explain_change(MODEL, trials(1, **old | change), trials(0, **old), known=KNOWN)
    assert found.verdict.effects == (name.partition(".")[0],)
    assert found.search.best.fit.named[name] == pytest.approx(value, rel=0.02)


def test_nothing_has_changed_where_nothing_has():
    found = explain_change(MODEL, trials(1, **{"friction.level": 0.2}), trials(0, **{"friction.level": 0.2}), known=KNOWN)
    assert (found.verdict.status, found.headline) == ("unchanged", "Nothing has changed")


def test_numbers_of_a_trial_are_taken_out():
    """Different initial speeds that are declared as trial parameters are not reported as a cause."""
    found = explain(MODEL, trials(start=0.05))
    assert found.verdict.status == "parameters"
    assert fit(Recordings(MODEL, trials(start=0.05)), ExtendedModel(MODEL)).values == pytest.approx([1.1, 0.7], rel=0.02)


def test_nothing_is_simulated_twice():
    asked = []

    def counted(values, trial):
        asked.append((trial.name, tuple(values.items())))
        return simulate(values, trial)

    explain(replace(MODEL, predict=counted), trials(**{"bias.force": 0.3}), causes=["bias", "friction"])
    assert len(asked) > 50 and len(set(asked)) == len(asked)


def test_derivatives_that_are_given_are_used():
    asked = []

    def slopes(values, trial):
        asked.append(trial.name)
        aside = [simulate(values | {"stiffness": values["stiffness"] + h}, trial)["x"] for h in (1e-4, -1e-4)]
        return {"x": {"stiffness": (aside[0] - aside[1]) / 2e-4}}

    recordings = Recordings(replace(MODEL, slopes=slopes), trials())
    given = recordings.predict_with_slopes(ExtendedModel(recordings.model), np.array([1.0, 1.0]))
    plain = Recordings(MODEL, trials()).predict_with_slopes(ExtendedModel(MODEL), np.array([1.0, 1.0]))
    assert len(asked) == 4
    assert given[0].slopes[..., 0] == pytest.approx(plain[0].slopes[..., 0], rel=0.05, abs=5.0)


def test_processes_give_the_same_answer():
    true = {"friction.level": 0.2}
    alone = explain(MODEL, trials(**true), causes=["friction", "bias"])
    with ProcessPoolExecutor(2) as executor:
        beside = explain(MODEL, trials(**true), causes=["friction", "bias"], executor=executor)
    assert alone.values == beside.values and alone.verdict.confidence == beside.verdict.confidence


def test_a_group_of_parameters_may_be_open_alone():
    both = Cause("pull", "actuation_map", (amplitude("one", 0.2), amplitude("two", 0.2)), apart=(("one",), ("two",)))
    every, *single = CauseVariant.variants(both)
    assert [each.opens for each in single] == [("one",), ("two",)] and all(every.contains(each) for each in single)
    assert [fact.name for fact in single[0].parameters] == ["pull.one"]


def test_the_report_is_whole_and_needs_nothing_else(tmp_path):
    found = explain(MODEL, trials(**{"friction.level": 0.2}), causes=["friction", "bias"])
    found.to_html(tmp_path / "report.html")
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    for part in ("mass on a spring", "friction.level", "Error of each model", "Where", found.verdict.sentence):
        assert part in text
    assert "http" not in text.replace("http://www.w3.org", "")


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda: explain(MODEL, trials()[:1]), "two or more"),
        (lambda: explain(MODEL, [*trials(), trials()[0]]), "a different name"),
        (lambda: explain(MODEL, trials(), causes=["frition"]), "one of friction, hardening, delay, bias"),
        (lambda: explain(MODEL, trials(), test=["trial 9"]), "names among"),
        (lambda: explain(replace(MODEL, predict=lambda values, trial: {"y": TIME}), trials()), "channel x"),
        (lambda: explain(replace(MODEL, predict=lambda values, trial: {"x": TIME[:3]}), trials()), "200 values"),
        (lambda: explain(replace(MODEL, predict=lambda values, trial: {}), trials(), jobs=2), "use jobs=1"),
        (lambda: Trial("one", [0, 0, 1], {"x": [1, 2, 3]}), "increasing"),
        (lambda: Trial("one", [0, 1], {"x": [1, 2, 3]}), "2 values"),
        (lambda: Model(simulate, (factor("a"), factor("a"))), "a twice"),
        (lambda: explain_change(MODEL, trials(), []), "two or more with the same name"),
    ],
)
def test_bad_input_is_one_line_that_says_what_was_expected(build, words):
    with pytest.raises(InputError) as caught:
        build()
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_shapes_start_within_their_bounds():
    assert shape("time", 0.1, 0.02, 1.0).scale == pytest.approx(0.098)
    with pytest.raises(ValueError):
        shape("time", 2.0, 0.0, 1.0)


def test_a_change_of_the_inputs_alone_shows_though_the_same_was_measured():
    """If only the recorded command differs, the motion should differ too, but does not."""
    old = trials(0, **{"friction.level": 0.2})
    new = [replace(each, inputs=1.1 * each.inputs) for each in old]
    found = explain_change(MODEL, new, old, known=KNOWN)
    assert found.verdict.status != "unchanged" and found.ladder[0].rms > 5


@pytest.mark.parametrize("cause", ["delay.time", "bias.force"])
def test_a_cause_is_found_above_its_detection_limit_and_not_far_below(cause):
    found = explain(MODEL, trials(**{"friction.level": 0.2}))
    (limit,) = [each for each in found.search.detection if each.parameter == cause]
    assert limit.size == found.to_json()["detection_limits"][[e.parameter for e in found.search.detection].index(cause)]["size"]
    name = cause.partition(".")[0]
    above, below = (explain(MODEL, trials(**{"friction.level": 0.2, cause: size * limit.size})) for size in (2.0, 0.3))
    assert set(above.verdict.effects) == {"friction", name}
    assert name not in below.verdict.effects


def test_causes_in_the_best_model_have_no_detection_limit():
    found = explain(MODEL, trials(**{"friction.level": 0.2}))
    assert {each.cause for each in found.search.detection} == {"hardening", "delay", "bias"}

"""What is open in a model, and that its chain and its steps are fine enough."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS, parse_effect
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.choice import choose
from hsr_pin.identification.evaluation import predict_all
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import LINKS, Hypothesis
from hsr_pin.identification.part import Part, part_variants
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import rms
from hsr_pin.inference.uncertainty import uncertainty


def apart(experiment, one, other):
    """RMS distance [m] between what two models predict."""
    pairs = zip(*(predict_all(experiment, model, model.start) for model in (one, other)), strict=True)
    return rms([a.positions - b.positions for a, b in pairs])


LAWS = [None, "quadratic_damping:coefficient=0.008", "dry_friction:level=0.06", "backlash:gap=0.2"]
TOO_STRONG = pytest.param(
    "quadratic_damping:coefficient=0.03",
    marks=pytest.mark.xfail(reason="0.14 mm: treated implicitly by its bound, it is damped too much", strict=True),
)


@pytest.mark.parametrize("effect", [*LAWS, TOO_STRONG])
def test_steps_are_converged_with_stiff_and_sticking_laws_too(heavy_tip, effect):
    experiment = prepare(heavy_tip)
    model = Hypothesis().with_effects(*([parse_effect(effect)] if effect else []))
    assert apart(experiment, model, replace(model, tolerance=model.tolerance / 64)) < 5e-5


def test_the_tip_of_the_chain_that_is_fitted_is_within_a_twentieth_of_a_percent_of_the_length(heavy_tip):
    experiment = prepare(heavy_tip)
    model = Hypothesis(tolerance=2e-5)
    assert apart(experiment, model, replace(model, links=5 * LINKS)) < 5e-4 * heavy_tip.length
    assert apart(experiment, replace(model, links=4), replace(model, links=5 * LINKS)) > 5e-4 * heavy_tip.length


def test_a_part_that_is_added_and_taken_away_leaves_what_was_there():
    plain = Hypothesis().with_effects(EFFECTS["dead_time"]())
    for part in (
        Part("torque_gain"),
        Part("hysteresis", EFFECTS["hysteresis"]()),
        Part("torque_bias", EFFECTS["torque_bias"](), True),
        Part("torque_map", EFFECTS["torque_map"](), True, "threshold"),
        Part("torque_map", EFFECTS["torque_map"](parity="even"), False, "quadratic"),
        Part("gravity_tilt", EFFECTS["gravity_tilt"](frame="cameras"), levels=(1.11, 2.33)),
    ):
        more = plain.with_part(part)
        assert more.parts[-1 if part.effect else 0].variant == part.variant
        fewer, kept = more.without_part(part.name)
        assert (fewer.effects, fewer.free, fewer.resized) == (plain.effects, plain.free, ())
        assert kept == [0, 1, 2]
    first, kept = plain.with_part(Part("torque_gain")).without_part("dead_time")
    assert (first.effects, first.free, kept) == ((), ("keq_scale", "damping_scale", "torque_gain"), [0, 1, 3])


def test_of_amplitudes_that_are_told_apart_each_is_a_reading_of_its_own():
    kind = EFFECTS["torque_map"]
    one = {(part.effect.parity, part.opens, part.resized) for part in part_variants(kind)}
    assert one == {(parity, opens, False) for parity in ("odd", "even") for opens in ("quadratic", "threshold")}
    more = {(part.effect.parity, part.opens, part.resized) for part in part_variants(kind, levels=2)}
    assert more - one == {(parity, "threshold", True) for parity in ("odd", "even")}
    assert {part.effect.parity for part in part_variants(kind, space=True)} == {"odd"}
    (opened,) = {
        Hypothesis(free=()).with_part(part).free for part in part_variants(kind, space=True) if part.opens == "threshold"
    }
    assert opened == ("torque_map.threshold",)


def test_a_law_of_a_single_number_may_have_one_for_each_level():
    def own(name):
        return [part for part in part_variants(EFFECTS[name], levels=2, each=(1.11, 2.33)) if part.levels]

    (bias,) = own("torque_bias")
    assert Hypothesis(free=()).with_part(bias).free == ("torque_bias.bias@1.11", "torque_bias.bias@2.33")
    assert {(part.effect.frame, part.levels) for part in own("gravity_tilt")} == {
        (frame, (1.11, 2.33)) for frame in ("world", "base", "cameras")
    }
    odd = part_variants(EFFECTS["torque_bias"], levels=2, each=(1.2345678, 2.33))[-1]
    assert Hypothesis().with_part(odd).parts[-1].variant == odd.variant  # names have six digits
    assert own("bending_stop") == own("unequal_lag") == own("torque_map") == []  # of several numbers
    assert own("stiffness_gradient") == own("quadratic_damping") == own("dry_friction") == []  # what the arm is made of
    assert not [part for part in part_variants(EFFECTS["torque_bias"], levels=2) if part.levels]


def test_a_size_for_each_level_has_as_its_special_cases_one_for_all_of_the_same_reading_only():
    tilts = part_variants(EFFECTS["gravity_tilt"], levels=2, each=(1.11, 2.33))
    for part in tilts:
        inside = [other for other in tilts if part.contains(other)]
        assert [(other.effect.frame, other.levels) for other in inside] == ([(part.effect.frame, ())] if part.levels else [])
    *one_size, each = part_variants(EFFECTS["torque_bias"], levels=2, each=(1.11, 2.33))
    assert [part.resized for part in one_size] == [False, True]
    assert all(each.contains(part) for part in one_size)


def test_a_resized_amplitude_changes_with_the_level_against_its_law_and_stays_within_its_bounds():
    bias = Hypothesis(free=()).with_part(Part("torque_bias", EFFECTS["torque_bias"](), True))  # Nm by its law: goes with Keq
    level = Hypothesis(free=()).with_part(Part("dry_friction", EFFECTS["dry_friction"](), True))  # rad by its law: Nm stay
    assert bias.effects_at(np.array([0.2]), 2.0)[0].bias == pytest.approx(0.4)
    assert level.effects_at(np.array([0.2]), 2.0)[0].level == pytest.approx(0.1)
    assert bias.effects_at(np.array([0.9]), 4.0)[0].bias == EFFECTS["torque_bias"].parameters()[0].upper
    assert bias.effects_at(np.array([[0.1], [0.2]]), 2.0)[0].bias == pytest.approx([0.2, 0.4])
    unmoved = Hypothesis(free=()).with_part(Part("torque_bias", EFFECTS["torque_bias"]()))
    assert unmoved.effects_at(np.array([0.2]), 2.0)[0].bias == pytest.approx(0.2)


def test_a_bias_that_goes_with_the_stiffness_is_found_as_such_and_one_that_stays_as_that(record):
    """The two readings of one law are fitted to the recordings of either."""
    readings = [Hypothesis().with_part(Part("torque_bias", EFFECTS["torque_bias"](0.02), resized)) for resized in (False, True)]
    commands = [(keq, share * keq) for keq in (1.11, 2.33) for share in (0.3, 0.8)]
    for resized, sizes in ((False, {1.11: 0.08, 2.33: 0.08}), (True, {1.11: 0.08, 2.33: 0.08 * 2.33 / 1.11})):
        parts = [record([c], effects=[EFFECTS["torque_bias"](sizes[c[0]])], seed=k) for k, c in enumerate(commands)]
        trials = tuple(replace(part.trials[0], name=f"trial_{k}") for k, part in enumerate(parts))
        experiment = prepare(replace(parts[0], trials=trials))
        right, wrong = (fit(experiment, readings[which]) for which in (resized, not resized))
        assert right.rms == pytest.approx(experiment.noise_rms, rel=0.1)
        assert wrong.rms > 2 * right.rms
        assert right.named["torque_bias.bias"] == pytest.approx(0.08, rel=0.03)


def test_sizes_that_are_free_at_each_level_are_recovered_and_a_level_without_its_own_has_that_of_the_first(record):
    biases = {1.11: 0.08, 2.33: -0.03}
    commands = [(keq, share * keq) for keq in biases for share in (0.3, 0.8)]
    parts = [record([c], effects=[EFFECTS["torque_bias"](biases[c[0]])], seed=k) for k, c in enumerate(commands)]
    trials = tuple(replace(part.trials[0], name=f"trial_{k}") for k, part in enumerate(parts))
    experiment = prepare(replace(parts[0], trials=trials))
    model = choose(["keq", "damping", "torque_bias@each"], (), experiment.runs)
    assert model.free == ("keq_scale", "damping_scale", "torque_bias.bias@1.11", "torque_bias.bias@2.33")
    answer = fit(experiment, model)
    assert answer.rms == pytest.approx(experiment.noise_rms, rel=0.1)
    assert {level: answer.named[f"torque_bias.bias@{level}"] for level in biases} == pytest.approx(biases, rel=0.05)
    sizes = [model.effects_at(answer.values, keq=keq)[0].bias for keq in (1.11, 2.33, 5.0, None)]
    assert sizes == [answer.named[f"torque_bias.bias@{level}"] for level in (1.11, 2.33, 1.11, 1.11)]
    assert [part.name for part in model.parts] == ["torque_bias"]


def test_what_is_split_by_level_is_opened_once_and_what_cannot_be_is_refused(record):
    runs = prepare(record([(1.11, 0.5), (2.33, 1.0)])).runs
    given = EFFECTS["hysteresis"](0.1, 0.2)
    model = choose(["keq@each", "hysteresis.amplitude@each"], [given], runs)
    levels = ("1.11", "2.33")
    split = [f"{name}@{level}" for name in ("keq_scale", "hysteresis.amplitude") for level in levels]
    assert model.free == ("hysteresis.yield_angle", *split)
    assert model.start.tolist() == [0.2, 1.0, 1.0, 0.1, 0.1]
    for name in ("drift@each", "torque_bias@2.33", "torque_bias.bias@"):
        with pytest.raises(IdentificationError, match=r"each|keq_drift"):
            choose([name], (), runs)


def test_a_stiffness_that_is_lost_over_the_session_is_recovered_with_the_time_it_took(record):
    lost, settling, torques = 0.3, 0.4, (0.5, 1.0, 0.5, 0.9, 0.6, 0.8)
    came = -np.expm1(-np.linspace(0, 1, 6) / settling) / -np.expm1(-1 / settling)
    parts = [record([(1.11, torque)], keq=1.1 * (1 - lost * g), damping=0.8) for torque, g in zip(torques, came, strict=True)]
    trials = tuple(replace(part.trials[0], name=f"trial_{k}") for k, part in enumerate(parts))
    experiment = prepare(replace(parts[0], trials=trials))
    model = Hypothesis().with_part(Part("keq_drift"))
    assert model.free == ("keq_scale", "damping_scale", "keq_drift", "keq_drift.settling")
    answer = fit(experiment, model)
    assert answer.rms == pytest.approx(experiment.noise_rms, rel=0.1)
    wanted = {"keq_scale": 1.1, "damping_scale": 0.8, "keq_drift": -lost, "keq_drift.settling": settling}
    assert answer.named == pytest.approx(wanted, rel=0.05)
    assert model.without_part("keq_drift")[0].free == Hypothesis().free


def test_a_gain_of_the_torque_is_recovered_beside_stiffness_and_damping(record):
    dataset = record([(1.11, 0.5), (1.11, 1.0), (2.33, 1.5)], keq=1.1, damping=0.8)
    weak = [replace(t, trajectory=replace(t.trajectory, torque=t.trajectory.torque / 0.7)) for t in dataset.trials]
    answer = fit(prepare(replace(dataset, trials=tuple(weak))), Hypothesis().with_part(Part("torque_gain")))
    assert answer.named == pytest.approx({"keq_scale": 1.1, "damping_scale": 0.8, "torque_gain": 0.7}, rel=0.02)
    assert uncertainty(answer).weak == ()


def test_a_gain_is_told_to_be_inseparable_from_stiffness_and_damping_where_nothing_weighs_anything(record):
    """Without weight and inertia, torque, stiffness and damping times one factor make the same motion."""
    dataset = record([(1.11, 0.5), (1.11, 1.0), (2.33, 1.5)], mount="horizontal", mass=1e-4)
    sure = uncertainty(fit(prepare(dataset), Hypothesis().with_part(Part("torque_gain"))))
    (words,) = sure.weak
    assert {"keq_scale", "damping_scale", "torque_gain"} <= set(words.split()) and words.endswith(
        "together without visible effect"
    )


@pytest.mark.parametrize("name", ["keq", "torque_gain@soft", "keq_drift@1.11", "hysteresis.amplitude"])
def test_a_name_that_nothing_has_is_refused(name):
    with pytest.raises(IdentificationError, match="parameter"):
        _ = Hypothesis((EFFECTS["dead_time"](),), (name,)).parameters

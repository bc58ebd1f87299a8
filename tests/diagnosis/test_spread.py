"""The shape along the arm of what is missing tells a force at the tip, whatever it does in time."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.diagnosis.residual_torque import ResidualTorque
from hsr_pin.diagnosis.spread import Spread, spread
from hsr_pin.diagnosis.traces import RULED_OUT, if_foretold, ruled_out, with_traces
from hsr_pin.diagnosis.verdict import Left, Verdict
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.identification.hypothesis import Part, readings

from .fabricated import THRESHOLDS, heldout

TIME = np.arange(300) * 0.01
#: A force and a torque that nothing commanded, and an arm that bends most at its tip.
WHIM = np.sin(7 * TIME) + 0.5 * np.cos(19 * TIME)
LEVERS = np.tile(np.linspace(0.24, 0.02, 8), (300, 1))
BENDS = np.sin(2 * TIME)[:, None] * np.linspace(0.1, 0.2, 8)
RATES = 2 * np.cos(2 * TIME)[:, None] * np.linspace(0.1, 0.2, 8)


def residual(torque, noise=0.002, modes=4, seed=0):
    dirt = np.random.default_rng(seed).normal(size=LEVERS.shape) * noise
    return ResidualTorque(torque + dirt, np.full(8, noise), BENDS.sum(axis=1), 0 * TIME, BENDS, RATES, LEVERS, modes)


@pytest.mark.parametrize(
    ("torque", "kind"),
    [
        (0.4 * WHIM[:, None] * LEVERS, "contact"),
        (0.03 * WHIM[:, None] + 0 * LEVERS, ""),  # muscles, or play, or hysteresis
        (0.5 * BENDS, ""),  # what the arm's own springs may lack has candidates of its own
        (0.03 * WHIM[:, None] * np.cos(np.linspace(0, 9, 8)), ""),  # none of them
    ],
    ids=["force at the tip", "torque of the muscles", "goes with the bending", "something else"],
)
def test_the_kind_is_told_by_the_shape_alone(torque, kind):
    found = spread([residual(torque), residual(torque, seed=1)])
    assert found.kind == kind
    assert bool(found.sentence) == bool(kind)


def test_noise_has_no_shape_and_one_mode_cannot_tell():
    assert spread([residual(0 * LEVERS)]) is None
    assert spread([residual(0.2 * WHIM[:, None] * LEVERS, modes=1)]) is None


def test_an_unexplained_gap_gets_its_kind_and_no_other_verdict_is_touched():
    tip = Spread({"tip": 0.05, "even": 0.2, "bending": 0.3})
    open_ = Verdict("unexplained", (), (), "A gap is left.", confidence={"stiffening": 0.3})
    told = with_traces(open_, [None, tip])
    assert (told.status, told.kinds, told.effects) == ("partly_identified", ("contact",), ())
    assert told.confidence["contact"] >= 0.75 and told.confidence["stiffening"] == 0.3
    assert "a force at the tip" in told.sentence and told.sentence.endswith("A gap is left.")
    named = Verdict("identified", ("stiffening",), (), "So.")
    assert with_traces(named, [tip]) is named
    assert with_traces(open_, [Spread({"tip": 0.2, "even": 0.21, "bending": 0.3})]) is open_  # too near to tell apart
    assert with_traces(open_, [Spread({"tip": 0.4, "even": 0.9, "bending": 0.9})]) is open_  # leaves too much
    assert with_traces(open_, [None]) is open_


ERROR = 0.8 * BENDS - 0.05 * RATES  # of the fitted stiffness and damping
FORCE, TORQUE = 0.4 * WHIM[:, None] * LEVERS, 0.03 * WHIM[:, None] + 0 * LEVERS


@pytest.mark.parametrize(
    ("torque", "uneven"),
    [(FORCE, True), (FORCE - ERROR, True), (TORQUE, False), (TORQUE - ERROR, False), (0.5 * WHIM[:, None] * BENDS, False)],
    ids=["force at the tip", "and wrong stiffness", "torque of the muscles", "and wrong stiffness", "goes with the bending"],
)
def test_what_no_even_law_can_be_is_told_whatever_stiffness_and_damping_took_of_it(torque, uneven):
    assert spread([residual(torque), residual(torque, seed=1)]).uneven is uneven


@pytest.mark.parametrize(
    ("tip", "even", "uneven"),
    [(0.02, 0.08, True), (0.02, 0.06, False), (0.05, 0.12, False), (0.05, 0.16, True), (0.2, 0.32, True), (0.25, 0.32, False)],
)
def test_a_force_that_leaves_a_third_of_what_an_even_torque_does_needs_to_take_away_less_more(tip, even, uneven):
    """A hose that pulls at the tip: an even torque leaves 8 % of it, the force next to nothing."""
    assert Spread({}, {"tip": tip, "even": even, "bending": 0.5}).uneven is uneven


def test_wrong_stiffness_and_damping_alone_have_no_shape_beside_themselves():
    found = spread([residual(ERROR)])
    assert found is not None and found.beside == {} and not found.uneven


PARTS = [part for kind in (EFFECTS | FLEXIBLE).values() for part in readings(kind)] + [Part("torque_gain"), Part("mass_scale")]
UNEVEN = Spread({"tip": 0.5, "even": 0.6, "bending": 0.7}, {"tip": 0.2, "even": 0.5, "bending": 0.6})


@pytest.mark.parametrize(
    ("effects", "alternatives"),
    [
        (("bending_stop",), ()),
        ((), (("bending_stop",), ("torque_map", "torque_gain"))),
        (("stiffening",), (("stiffening", "torque_map"), ("stiffening", "torque_curve"))),
    ],
)
def test_laws_that_act_alike_everywhere_are_no_names_for_what_does_not(effects, alternatives):
    before = Verdict("ambiguous", effects, alternatives, "So.", ("elastic",), {"bending_stop": 0.9, "elastic": 0.8, "creep": 0.1})
    after = ruled_out(before, UNEVEN, PARTS, THRESHOLDS)
    assert (after.status, after.effects, after.alternatives, after.kinds) == ("unexplained", (), (), ())
    assert max(after.confidence.values()) <= RULED_OUT
    assert "an even torque leaves 50 % of its square, a force at the tip 20 %" in after.sentence


def test_a_contact_beside_laws_that_are_ruled_out_is_not_certain_for_want_of_others():
    before = Verdict(
        "ambiguous", (), (("bending_stop",), ("restraint",)), "So.", confidence={"bending_stop": 0.9, "contact": 0.5}
    )
    after = ruled_out(before, UNEVEN, PARTS, THRESHOLDS)
    assert (after.status, after.alternatives, after.confidence) == ("unexplained", (), {"bending_stop": RULED_OUT})
    assert after.sentence.startswith("None is certain: bending_stop comes near at the markers, but")
    assert after.sentence.endswith("a force at the tip 20 %); restraint may be.")
    alone = Verdict("partly_identified", ("restraint",), (), "So.")
    beside = Verdict("ambiguous", (), (("bending_stop",), ("gravity_tilt",)), "So.")
    for verdict in (alone, beside):
        assert ruled_out(verdict, UNEVEN, PARTS, THRESHOLDS) is verdict


def test_a_verdict_without_names_stays_whatever_trials_set_aside_say():
    best, alone = (heldout(gap) for gap in (2e-3, 1e-3))
    none, some = Verdict("no_gap", (), (), "So."), Verdict("ambiguous", (), (("tip_mass",), ("added_mass",)), "So.")
    assert if_foretold(none, alone, best, ("tip_mass",)) is none
    assert if_foretold(some, best, alone, ("tip_mass",)) is some
    assert if_foretold(some, alone, best, ("tip_mass",)).alternatives == ()


def test_where_stiffness_and_damping_leave_nothing_the_shapes_alone_tell():
    named = Verdict("ambiguous", (), (("stiffening",), ("torque_map",)), "So.")
    force, other = ({"tip": 0.14, "even": even, "bending": 0.27} for even in (0.32, 0.15))
    after = ruled_out(named, Spread(force), PARTS, THRESHOLDS)
    assert after.status == "unexplained" and "leaves 32 % of its square, a force at the tip 14 %" in after.sentence
    assert ruled_out(named, Spread(other), PARTS, THRESHOLDS) is named


@pytest.mark.parametrize("sets", [(("stiffness_gradient", "hysteresis"),), (("soft_spot",), ("torque_decay", "torque_curve"))])
def test_nor_are_laws_along_the_arm_where_a_force_at_the_tip_leaves_little_by_itself(sets):
    force = Spread({"tip": 0.05, "even": 0.29, "bending": 0.3}, {"tip": 0.03, "even": 0.32, "bending": 0.33})
    before = Verdict("ambiguous", (), sets, "So.", ("elastic",), {"elastic": 0.8, "friction": 0.2})
    after = ruled_out(before, force, PARTS, THRESHOLDS)
    assert (after.status, after.alternatives, after.kinds, after.confidence["elastic"]) == ("unexplained", (), (), RULED_OUT)
    assert "but acts along the arm, and what is missing at its tip (an even torque leaves 32 %" in after.sentence
    assert ruled_out(before, UNEVEN, PARTS, THRESHOLDS) is before  # of a stiffness along the arm too, beside another stiffness


def test_a_contact_of_several_is_named_only_where_a_force_at_the_tip_is_seen():
    unseen = Spread({"tip": 0.61, "even": 0.66, "bending": 0.64}, {"tip": 0.55, "even": 0.65, "bending": 0.65})
    open_ = Verdict("ambiguous", (), (("restraint",), ("gravity_tilt",)), "So.", confidence={"restraint": 0.8})
    after = ruled_out(open_, unseen, PARTS, THRESHOLDS)
    assert (after.status, after.alternatives, after.confidence) == ("unexplained", (), {"restraint": RULED_OUT})
    assert after.sentence.startswith(
        "None is certain: restraint or gravity_tilt comes near at the markers, but where restraint acts"
    )
    certain, later = replace(open_, kinds=("contact",)), replace(open_, alternatives=open_.alternatives[::-1])
    for same in (certain, later, replace(open_, status="partly_identified"), replace(open_, left=Left(1e-5, 0.01, 0.24))):
        assert ruled_out(same, unseen, PARTS, THRESHOLDS) is same
    for seen in (None, UNEVEN, Spread(unseen.left)):  # nothing is left beside stiffness and damping, by which to tell
        assert ruled_out(open_, seen, PARTS, THRESHOLDS) is open_


@pytest.mark.parametrize(
    "sets",
    [
        (("gravity_tilt",), ("torque_bias",)),
        (("stiffness_gradient", "stiffening"),),
        (("dead_time",),),
        (("dry_friction",), ("hysteresis", "stiffening")),
        (("viscoelastic",),),
    ],
)
def test_laws_that_have_a_place_weight_lateness_or_memory_are_left_alone(sets):
    named, near = Verdict("ambiguous", (), sets, "So."), replace(UNEVEN, beside={"tip": 0.31, "even": 0.44, "bending": 0.5})
    assert ruled_out(named, near, PARTS, THRESHOLDS) is named


def test_what_remembers_is_ruled_out_where_a_force_at_the_tip_is_far_nearer():
    named, far = Verdict("ambiguous", (), (("hysteresis",),), "So."), {"tip": 0.05, "even": 0.29, "bending": 0.3}
    assert ruled_out(named, replace(UNEVEN, beside=far), PARTS, THRESHOLDS).status == "unexplained"


def test_nothing_is_ruled_out_without_a_clear_shape_or_where_the_gap_is_closed():
    named = Verdict("partly_identified", ("bending_stop",), (), "So.")
    near = {"tip": 0.48, "even": 0.6, "bending": 0.7}  # though by a tenth
    little = {"tip": 0.02, "even": 0.065, "bending": 0.3}  # though a third of it
    for found in (None, Spread(UNEVEN.left), Spread(UNEVEN.left, near), Spread(UNEVEN.left, little)):
        assert ruled_out(named, found, PARTS, THRESHOLDS) is named
    assert ruled_out(named, UNEVEN, PARTS, THRESHOLDS) is not named
    closed = Verdict("identified", ("bending_stop",), (), "So.")
    assert ruled_out(closed, UNEVEN, PARTS, THRESHOLDS) is closed
    for share, same in ((0.9, True), (1.1, False)):
        told = replace(named, left=Left(share * THRESHOLDS.closed, 0.01, 0.24))
        assert (ruled_out(told, UNEVEN, PARTS, THRESHOLDS) is told) is same
    nothing = Verdict("unexplained", (), (), "So.")
    assert ruled_out(nothing, UNEVEN, PARTS, THRESHOLDS) is nothing

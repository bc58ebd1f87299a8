"""The shape along the arm of what is missing tells a force at the tip, whatever it does in time."""

import numpy as np
import pytest

from hsr_pin.diagnosis.residual_torque import ResidualTorque
from hsr_pin.diagnosis.spread import Spread, spread
from hsr_pin.diagnosis.verdict import Verdict, with_traces

TIME = np.arange(300) * 0.01
#: A force and a torque that nothing commanded, and an arm that bends most at its tip.
WHIM = np.sin(7 * TIME) + 0.5 * np.cos(19 * TIME)
LEVERS = np.tile(np.linspace(0.24, 0.02, 8), (300, 1))
BENDS = np.sin(2 * TIME)[:, None] * np.linspace(0.1, 0.2, 8)


def residual(torque, noise=0.002, modes=4, seed=0):
    dirt = np.random.default_rng(seed).normal(size=LEVERS.shape) * noise
    return ResidualTorque(torque + dirt, np.full(8, noise), BENDS.sum(axis=1), 0 * TIME, BENDS, LEVERS, modes)


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

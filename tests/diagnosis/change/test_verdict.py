"""The verdict on a change: the change that explains the current recording, alternatives, or no change."""

from types import SimpleNamespace

import numpy as np
import pytest

from hsr_pin.diagnosis.change.chance import Chance
from hsr_pin.diagnosis.change.fitting import Fitted
from hsr_pin.diagnosis.change.hypotheses import ChangeHypothesis
from hsr_pin.diagnosis.change.size import Size
from hsr_pin.diagnosis.change.verdict import ChangeEvidence, judge, needed
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import neutral
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import Part
from hsr_pin.inference import Data

ROWS = 800
OLD = 400
rng = np.random.default_rng(0)
NOISE = rng.normal(size=OLD + ROWS)


class Judged(ChangeEvidence):
    """Evidence for changes of given sizes and gains."""

    @property
    def sizes(self):
        return {
            f.change.names: tuple(
                Size(name, f"{name}.size", "1", 0.0, 1.0, (0.0, 0.0), (0.9, 1.1), (0.9, 1.1)) for name in f.change.names
            )
            for f, _ in self.fits
        }

    def difference(self, fitted):
        from hsr_pin.diagnosis.change.verdict import Difference

        return Difference(2e-3, 1e-3, 1e-3, 0.95)


def change(*names):
    model = Hypothesis()
    for name in names:
        model = model.with_part(Part(name, neutral(EFFECTS[name])))
    own = tuple(f"{name}.{next(f.name for f in EFFECTS[name].parameters() if f.amplitude)}" for name in names)
    return ChangeHypothesis(names, model, model.start, own)


def found(gap, *changes, chance=0.0, moved=5e-3):
    """Return evidence with a squared difference ``gap`` beyond noise; ``changes`` are names and the squares that they explain."""
    missing = np.zeros(OLD + ROWS)
    missing[OLD:] = np.sqrt(gap / ROWS) * np.where(np.arange(ROWS) % 2, 1.0, -1.0)
    seen = NOISE + missing
    frame = SimpleNamespace(
        seen=seen,
        run=np.repeat([0, 1], [OLD, ROWS]),
        pair=SimpleNamespace(reportable=1e-3, old=SimpleNamespace(runs=[0])),
        off=lambda moved=(): 1e-3 * (1 + gap / 400),
        scatter=1e-3,
    )
    fits = []
    for names, taken in changes:
        who = change(*names)
        residual = NOISE + missing * np.sqrt(1 - taken / gap)
        slopes = np.full((OLD + ROWS, len(who.open)), 1e-3)
        fits.append((Fitted(who, who.start + 0.05, residual, slopes, (np.full((4, 1, 2), moved),)), frame))
    fits.sort(key=lambda each: each[0].square)
    return Judged(frame, tuple(fits), Chance(np.array([[chance]])), {})


def test_a_change_that_explains_what_is_missing_is_identified():
    said = judge(found(400.0, (("tip_mass",), 400.0), (("dry_friction",), 100.0)))
    assert (said.status, said.effects, said.kinds) == ("identified", ("tip_mass",), ("mass_gravity",))
    assert said.confidence["tip_mass"] > 0.95


def test_two_changes_that_explain_as_much_are_alternatives():
    said = judge(found(400.0, (("tip_mass",), 400.0), (("added_mass",), 400.0)))
    assert (said.status, set(said.alternatives)) == ("ambiguous", {("tip_mass",), ("added_mass",)})


def test_what_the_first_recording_shows_by_chance_is_no_change():
    assert judge(found(60.0, (("tip_mass",), 60.0))).effects == ("tip_mass",)
    assert judge(found(60.0, (("tip_mass",), 60.0), chance=60.0)).status == "unchanged"


def test_a_change_that_hardly_moves_the_markers_is_not_reported():
    assert judge(found(400.0, (("tip_mass",), 400.0), moved=1e-4)).effects == ()


def test_a_second_change_is_reported_where_the_first_leaves_something():
    both = (("tip_mass", "dry_friction"), 400.0)
    assert set(judge(found(400.0, both, (("tip_mass",), 300.0))).effects) == {"tip_mass", "dry_friction"}
    assert judge(found(400.0, both, (("tip_mass",), 397.0))).effects == ("tip_mass",)


def test_what_no_candidate_explains_is_unexplained():
    assert judge(found(2000.0, (("tip_mass",), 20.0))).status == "unexplained"


@pytest.mark.parametrize("count", [200, 2000])
def test_the_gain_that_is_needed_grows_with_the_rows_and_with_scatter(count):
    assert needed(Data.of_one_group(1.0, 2 * count)) == pytest.approx(2 * needed(Data.of_one_group(1.0, count)))
    assert needed(Data.of_one_group(1.0, count), 0.1) > needed(Data.of_one_group(1.0, count))

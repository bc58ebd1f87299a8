"""How often it was told rightly what has changed between two recordings.

The size of a change, from what to what, as ``verdict.changes`` has it: a list of ``name``, ``parameter``, ``from``, ``to`` and
``intervals`` (95 %: of ``from``, of ``to``, perhaps of the ``step``). Small effects that are in both recordings shift both ends
alike, so what is judged is the step between them: of plain parameters the ratio, of effects the difference. Its interval follows
from those of the ends (the recordings are independent, so half widths add in squares), unless one is stated for the step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, log
from typing import Any

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.kinds import PLAIN
from hsr_pin.blind.outcome import Outcome, outcome_of, readable
from hsr_pin.blind.rate import Rate
from hsr_pin.blind.scoring import document_of, outcome_from
from hsr_pin.errors import InputError

#: Name -> the parameter of the catalogue that is the same quantity as the strength of the plants' law. Others are told by the
#: laws in ways of their own, and are not judged.
SAME: dict[str, str] = {
    "actuator_lag": "time_constant",
    "added_mass": "mass",
    "damping_scale": "damping_scale",
    "dead_time": "delay",
    "dry_friction": "level",
    "gravity_tilt": "angle",
    "keq_scale": "keq_scale",
    "marker_offset": "offset",
    "mass_scale": "mass_scale",
    "tip_mass": "mass",
    "torque_bias": "bias",
    "torque_gain": "torque_gain",
}


@dataclass(frozen=True)
class ChangeScore:
    """What came of a check of pairs.

    Attributes:
        outcomes: of all pairs that were diagnosed. sizes: whether the size of the change was right, None if it is not judged.
        missing: names of those that were not diagnosed.
    """

    outcomes: tuple[Outcome, ...]
    sizes: tuple[bool | None, ...]
    missing: tuple[str, ...]

    @property
    def rates(self) -> dict[str, Rate]:
        """By what they say."""
        changed = [o for o in self.outcomes if o.answer.kind != "nothing"]
        same = [o for o in self.outcomes if o.answer.kind == "nothing"]
        judged = [right for right in self.sizes if right is not None]
        return {
            "change named alone or among the alternatives": _right(changed),
            **{f"the same, {kind}": _right([o for o in changed if o.answer.kind == kind]) for kind in _KINDS},
            "unchanged, nothing has changed": _right(same),
            "unchanged, something has": Rate(sum(o.status == "unchanged" for o in changed), len(changed)),
            "wrong names, all pairs": Rate(sum(o.wrong_name for o in self.outcomes), len(self.outcomes)),
            "size within its 95 % interval": Rate(sum(judged), len(judged)),
        }

    def document(self) -> dict[str, Any]:
        """For programs."""
        return {
            "pairs": len(self.outcomes),
            "missing": list(self.missing),
            "rates": {name: {"hits": rate.hits, "of": rate.of, "ci95": list(rate.interval)} for name, rate in self.rates.items()},
            "outcomes": [
                {**document_of(outcome), "size_right": size} for outcome, size in zip(self.outcomes, self.sizes, strict=True)
            ],
        }


_KINDS = ("appears", "grows", "parameter")


def score_changes(answers: Sequence[Answer], verdicts: Mapping[str, dict[str, Any]]) -> ChangeScore:
    """Hold verdicts on pairs against answers.

    Raises:
        InputError: a verdict is none.
    """
    told = [answer for answer in answers if answer.name in verdicts]
    return ChangeScore(
        tuple(outcome_of(answer, verdicts[answer.name], None) for answer in told),
        tuple(size_right(answer, verdicts[answer.name]) for answer in told),
        tuple(answer.name for answer in answers if answer.name not in verdicts),
    )


def scored_changes(document: dict[str, Any]) -> ChangeScore:
    """The score that :meth:`ChangeScore.document` was written from.

    Raises:
        InputError: it is none.
    """
    try:
        outcomes, sizes = zip(*((outcome_from(each), each["size_right"]) for each in document["outcomes"]), strict=True)
        return ChangeScore(outcomes, sizes, tuple(document["missing"]))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError("score", expected="what hsr-blind score --json wrote", received=repr(error)) from error


def size_right(answer: Answer, verdict: Mapping[str, Any]) -> bool | None:
    """Whether the step lies in its interval; None if the change was not named, or cannot be judged."""
    with readable(answer):
        return _size_right(answer, verdict)


def _size_right(answer: Answer, verdict: Mapping[str, Any]) -> bool | None:
    truth = answer.facts.get("change") or {}
    name = truth.get("name", "")
    said = [
        each
        for each in verdict.get("verdict", {}).get("changes") or ()
        if each.get("name") == name and str(each.get("parameter")).rpartition(".")[2] == SAME.get(name)
    ]
    if not said:
        return None
    low, high = _step_interval(said[0], ratio=name in PLAIN)
    true = log(truth["to"] / truth["from"]) if name in PLAIN else truth["to"] - truth["from"]
    return low <= true <= high


def _step_interval(said: Mapping[str, Any], ratio: bool) -> tuple[float, float]:
    """95 % interval of the step; of a ratio, of its logarithm."""
    before, after = float(said["from"]), float(said["to"])
    intervals = said.get("intervals") or {}
    if "step" in intervals:
        low, high = (float(value) for value in intervals["step"])
        return (log(low), log(high)) if ratio else (low, high)
    ends = []
    for place, value in (("from", before), ("to", after)):
        low, high = (float(end) for end in intervals.get(place) or (value, value))  # what was not fitted has no width
        ends.append((log(low / value), log(high / value)) if ratio else (low - value, high - value))
    step = log(after / before) if ratio else after - before
    (a, b), (c, d) = ends
    return step - hypot(b, c), step + hypot(a, d)


def _right(among: Sequence[Outcome]) -> Rate:
    return Rate(sum(o.exact for o in among), len(among))

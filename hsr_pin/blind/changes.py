"""Score of diagnosed changes between two recordings: their names and their sizes.

``verdict.changes`` contains the size of each change: a list of ``name``, ``parameter``, ``from``, ``to`` and ``intervals`` (95 %
intervals of ``from``, of ``to`` and optionally of the ``step``). Small effects in both recordings shift both ends equally.
Therefore the step between the ends is judged: for plain parameters the ratio, for effects the difference. If no interval of the
step is stated, it follows from those of the ends: the recordings are independent, so half widths add in squares.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import hypot, log
from typing import Any

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.kinds import PLAIN_PARAMETERS
from hsr_pin.blind.outcome import Outcome, outcome_of, readable
from hsr_pin.blind.rate import Rate
from hsr_pin.blind.scoring import document_of, outcome_from
from hsr_pin.errors import InputError

#: Name -> parameter of the catalogue that is the same quantity as the strength of the plants' law. Other names have no such
#: parameter, and their sizes are not judged.
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
    """Score of a check with pairs of recordings.

    Attributes:
        outcomes: outcomes of all diagnosed pairs.
        sizes: for each outcome whether the size of the change was right; None if it is not judged.
        missing: names of the pairs without a diagnosis.
    """

    outcomes: tuple[Outcome, ...]
    sizes: tuple[bool | None, ...]
    missing: tuple[str, ...]

    @property
    def rates(self) -> dict[str, Rate]:
        """Rates of right answers, by their description."""
        changed = [o for o in self.outcomes if o.answer.kind != "nothing"]
        same = [o for o in self.outcomes if o.answer.kind == "nothing"]
        return {
            "change named alone or among the alternatives": Rate.among(o.exact for o in changed),
            **{f"the same, {kind}": Rate.among(o.exact for o in changed if o.answer.kind == kind) for kind in _KINDS},
            "unchanged, nothing has changed": Rate.among(o.exact for o in same),
            "unchanged, something has": Rate.among(o.status == "unchanged" for o in changed),
            "wrong names, all pairs": Rate.among(o.wrong_name for o in self.outcomes),
            "size within its 95 % interval": Rate.among(right for right in self.sizes if right is not None),
        }

    def document(self) -> dict[str, Any]:
        """Return the score as a JSON document."""
        return {
            "pairs": len(self.outcomes),
            "missing": list(self.missing),
            "rates": {name: rate.document() for name, rate in self.rates.items()},
            "outcomes": [
                {**document_of(outcome), "size_right": size} for outcome, size in zip(self.outcomes, self.sizes, strict=True)
            ],
        }


_KINDS = ("appears", "grows", "parameter")


def score_changes(answers: Sequence[Answer], verdicts: Mapping[str, dict[str, Any]]) -> ChangeScore:
    """Compare verdicts on pairs of recordings with the answers.

    Raises:
        InputError: a verdict has the wrong format.
    """
    diagnosed = [answer for answer in answers if answer.name in verdicts]
    return ChangeScore(
        tuple(outcome_of(answer, verdicts[answer.name], None) for answer in diagnosed),
        tuple(size_right(answer, verdicts[answer.name]) for answer in diagnosed),
        tuple(answer.name for answer in answers if answer.name not in verdicts),
    )


def scored_changes(document: dict[str, Any]) -> ChangeScore:
    """Return the score from a document that :meth:`ChangeScore.document` returned.

    Raises:
        InputError: the document has the wrong format.
    """
    try:
        outcomes, sizes = zip(*((outcome_from(each), each["size_right"]) for each in document["outcomes"]), strict=True)
        return ChangeScore(outcomes, sizes, tuple(document["missing"]))
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise InputError("score", expected="a document written by hsr-blind score --json", received=repr(error)) from error


def size_right(answer: Answer, verdict: Mapping[str, Any]) -> bool | None:
    """Return whether the true step lies in its interval; None if the change was not named, or cannot be judged."""
    with readable(answer):
        return _size_right(answer, verdict)


def _size_right(answer: Answer, verdict: Mapping[str, Any]) -> bool | None:
    truth = answer.facts.get("change") or {}
    name = truth.get("name", "")
    reported = [
        each
        for each in verdict.get("verdict", {}).get("changes") or ()
        if each.get("name") == name and str(each.get("parameter")).rpartition(".")[2] == SAME.get(name)
    ]
    if not reported:
        return None
    low, high = _step_interval(reported[0], ratio=name in PLAIN_PARAMETERS)
    true = log(truth["to"] / truth["from"]) if name in PLAIN_PARAMETERS else truth["to"] - truth["from"]
    return low <= true <= high


def _step_interval(reported: Mapping[str, Any], ratio: bool) -> tuple[float, float]:
    """Return the 95 % interval of the step; for a ratio, of its logarithm."""
    before, after = float(reported["from"]), float(reported["to"])
    intervals = reported.get("intervals") or {}
    if "step" in intervals:
        low, high = (float(value) for value in intervals["step"])
        return (log(low), log(high)) if ratio else (low, high)
    ends = []
    for place, value in (("from", before), ("to", after)):
        low, high = (float(end) for end in intervals.get(place) or (value, value))  # an unfitted value has no width
        ends.append((log(low / value), log(high / value)) if ratio else (low - value, high - value))
    step = log(after / before) if ratio else after - before
    (a, b), (c, d) = ends
    return step - hypot(b, c), step + hypot(a, d)

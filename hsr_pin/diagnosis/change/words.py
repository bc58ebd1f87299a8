"""Sentences and numbers on a change."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from hsr_pin.diagnosis.change.size import Size
from hsr_pin.diagnosis.words import EXPERIMENTS
from hsr_pin.identification.part import ARM
from hsr_pin.inference.estimates import number

if TYPE_CHECKING:
    from hsr_pin.diagnosis.change.diagnose import ChangeDiagnosis

#: Status of a verdict -> its headline.
HEADLINES = {
    "identified": "What has changed is known",
    "partly_identified": "Part of what has changed is known",
    "ambiguous": "More than one change would explain the difference",
    "unexplained": "Something unknown has changed",
    "unchanged": "Nothing has changed",
    "insufficient": "Not enough data",
}

#: Readable names of the arm's parameters.
READABLE = {"keq_scale": "stiffness", "damping_scale": "damping", "mass_scale": "mass", "torque_gain": "torque gain"}
#: A size below this share of its former value counts as disappeared.
_DISAPPEARED = 0.1


def changes_in_words(changes: Sequence[Size]) -> str:
    """Return all changes as text: ``actuator_lag.time_constant 0.090 to 0.140 s (by 0.045 to 0.055); stiffness down 6 %``."""
    return "; ".join(_in_words(each) for each in changes if each.before is not None)


def _in_words(size: Size) -> str:
    assert size.before is not None and size.step is not None
    if size.parameter in ARM:
        low, high = sorted(100 * (end - 1) for end in size.step)
        ratio = 100 * (size.after / size.before - 1)
        way, sign = ("up", 1) if ratio >= 0 else ("down", -1)
        ends = sorted((sign * low, sign * high))
        between = f"{rounded(ends[0], ends)} to {rounded(ends[1], ends)} %"
        return f"{READABLE[size.parameter]} {way} {rounded(abs(ratio), ends)} % ({between})"
    unit = "" if size.unit == "1" else f" {size.unit}"
    span = size.becomes
    before, after = rounded(size.before, span), rounded(size.after, span)
    if abs(size.before) < 1e-12:
        return f"{size.parameter} {after}{unit} has appeared ({rounded(span[0], span)} to {rounded(span[1], span)})"
    if abs(size.after) < _DISAPPEARED * abs(size.before):
        return f"{size.parameter} {before}{unit} has disappeared"
    low, high = size.step
    return f"{size.parameter} {before} to {after}{unit} (by {rounded(low, size.step)} to {rounded(high, size.step)})"


def rounded(value: float, interval: Sequence[float]) -> str:
    """Return a number rounded to two digits of half the width of an interval."""
    half = (max(interval) - min(interval)) / 2
    if not 1e-9 < half < 1e9:
        return f"{value:.3g}"
    places = min(9, max(0, 1 - math.floor(math.log10(half))))
    return f"{value:.{places}f}"


def advice(diagnosis: ChangeDiagnosis) -> list[str]:
    """Return what to do next, one sentence for each item."""
    status, proposals = diagnosis.verdict.status, diagnosis.next_experiment
    if status == "ambiguous" and proposals:
        best = proposals[0]
        by = f"this experiment separates the alternatives best (by {number(best.separation)} times the noise)"
        return [f"Record the arm in its current state once more: {EXPERIMENTS[best.name]}; {by}."]
    if status == "ambiguous":
        return ["Record the arm in its current state once more, with other commands."]
    if status == "unexplained":
        return ["Check the arm, the marker plates and the cameras: no effect of the catalogue explains the change."]
    if status == "unchanged":
        return ["Repeat the commands of the first recording in more trials to detect smaller changes."]
    return []

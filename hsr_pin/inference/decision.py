"""What to report: of all reports that the probabilities suggest, the one with the smallest expected loss.

A report names one set of causes or a few alternatives, or some names, or kinds of physics, or nothing. The gain of a report where
a set of causes is the truth follows from one table (:class:`Loss`), whose entries anyone may change: whoever acts on a wrong name
at once will want it dearer than whoever looks first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from itertools import combinations
from math import isfinite, nan

from hsr_pin.errors import InputError, quoted
from hsr_pin.inference.posterior import Names, Posterior

#: Sets of causes that are looked at, the most probable first: what is less likely than all of these changes no report.
_SETS = 8


@dataclass(frozen=True)
class Loss:
    """What a report gains where it is right, and loses where it is not.

    Attributes:
        exact: the causes that are there and no others, or nothing where none of those offered is there.
        alternative: taken off for every further alternative.
        part: taken off where only a part is named; the gain is the share of the gap that this part explains.
        kind: the kinds of all that is there, without their names.
        wrong_name: a cause that is not there.
        none_right: alternatives of which none is right.
        wrong_kind: a kind of which nothing is there.
    """

    exact: float = 1.0
    alternative: float = 0.08
    part: float = 0.1
    kind: float = 0.5
    wrong_name: float = -4.0
    none_right: float = -3.0
    wrong_kind: float = -2.0

    @classmethod
    def of(cls, text: str) -> Loss:
        """From ``wrong_name=-8,part=0``: the entries that are given, the others as they are.

        Raises:
            InputError: an entry that there is not, or a value that is no finite number.
        """
        known = {fact.name for fact in fields(cls)}
        given: dict[str, float] = {}
        for item in filter(None, (part.strip() for part in text.split(","))):
            name, _, value = (part.strip() for part in item.partition("="))
            if name not in known:
                raise InputError("loss", expected=f"entries among {', '.join(sorted(known))}", received=quoted(name))
            given[name] = _finite(name, value)
        return cls(**given)


def _finite(name: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        raise InputError(f"loss {name}", expected=f"a number, as in {name}=-4", received=quoted(text))
    return value


@dataclass(frozen=True)
class Decision:
    """A report.

    Attributes:
        sets: what may be the case, the most probable first: one set of causes, or alternatives. Empty: no whole set is reported.
        names: causes that are there; where ``sets`` has one, those of it.
        kinds: kinds of physics that are there, those of the names among them.
        gain: expected, by the table.
        probability: that the report is right: that the set, one of the alternatives, or all names and kinds are there.
    """

    sets: tuple[Names, ...]
    names: Names
    kinds: tuple[str, ...]
    gain: float
    probability: float


@dataclass(frozen=True)
class _Truth:
    """One set of causes that may be the truth.

    Attributes:
        names: of its causes. named: those of them that are no flexible laws.
        kinds: of each of its causes.
        probability: of it.
    """

    names: Names
    named: frozenset[str]
    kinds: Mapping[str, str]
    probability: float


def decide(found: Posterior, loss: Loss | None = None) -> Decision:
    """The report with the largest expected gain; of equal ones the one that says less."""
    table = loss or Loss()
    truths = _truths(found)
    explained = _explained(found)
    reports = [Decision((), (), (), 0.0, 0.0), *_alternatives(truths), *_partial(truths)]

    def expected(report: Decision) -> float:
        return sum(truth.probability * _gain(report, truth, table, explained) for truth in truths)

    best = max(reports, key=lambda report: round(expected(report), 9))
    right = sum(truth.probability for truth in truths if _holds(best, truth))
    return Decision(best.sets, best.names, best.kinds, expected(best), right)


def _truths(found: Posterior) -> list[_Truth]:
    answers = []
    for names, probability in found.sets.items():
        causes = found.leader(names).causes
        named = frozenset(cause.name for cause in causes if not cause.flexible)
        answers.append(_Truth(names, named, {cause.name: cause.kind for cause in causes}, probability))
    return answers


def _explained(found: Posterior) -> dict[Names, float]:
    """By how much each set of causes lowers the misfit of the nominal model, at best."""
    nominal = max(model.misfit for model in found.models if not model.causes)
    answers: dict[Names, float] = {}
    for model in found.models:
        answers[model.names] = max(answers.get(model.names, 0.0), nominal - model.misfit)
    return answers


def _alternatives(truths: list[_Truth]) -> Iterator[Decision]:
    """One set of causes, and the two, three and more most probable sets."""
    likely = [truth for truth in truths if truth.names][:_SETS]
    for count in range(1, len(likely) + 1):
        some = likely[:count]
        sets = tuple(truth.names for truth in some)
        names = frozenset.intersection(*(truth.named for truth in some))
        kinds = frozenset.intersection(*(frozenset(truth.kinds.values()) for truth in some))
        if count > 1 or len(names) == len(sets[0]):  # a flexible law alone is reported as its kind
            yield Decision(sets, tuple(sorted(names)), tuple(sorted(kinds)), 0.0, 0.0)


def _partial(truths: list[_Truth]) -> Iterator[Decision]:
    """Some names, with or without kinds of what is beside them."""
    likely = [truth for truth in truths if truth.names][:_SETS]
    seen: set[tuple[Names, tuple[str, ...]]] = set()
    for truth in likely:
        for names in _subsets(sorted(truth.named)):
            own = {truth.kinds[name] for name in names}
            for more in _subsets(sorted(set(truth.kinds.values()) - own)):
                report = names, tuple(sorted(own | set(more)))
                if report not in seen and report[1]:
                    seen.add(report)
                    yield Decision((), *report, 0.0, 0.0)


def _subsets(items: Iterable[str]) -> list[tuple[str, ...]]:
    own = list(items)
    return [some for count in range(len(own) + 1) for some in combinations(own, count)]


def _gain(report: Decision, truth: _Truth, table: Loss, explained: Mapping[Names, float]) -> float:
    """What a report gains where ``truth`` is the case."""
    if not report.sets and not report.kinds:
        return table.exact if not truth.names else 0.0
    if report.sets:
        further = table.alternative * (len(report.sets) - 1)
        if truth.names in report.sets:
            return (table.exact if len(truth.named) == len(truth.names) else table.kind) - further
        parts = [names for names in report.sets if set(names) < set(truth.names)]
        if parts:
            return max(_share(names, truth, table, explained) for names in parts) - further
        return table.wrong_name if len(report.sets) == 1 else table.none_right
    if not truth.named.issuperset(report.names):
        return table.wrong_name
    kinds = set(truth.kinds.values())
    if not kinds.issuperset(report.kinds):
        return table.wrong_kind
    if set(report.names) == set(truth.names):
        return table.exact
    of_part = _share(report.names, truth, table, explained) if report.names else 0.0
    return max(of_part, table.kind if kinds == set(report.kinds) else 0.0)


def _share(names: Names, truth: _Truth, table: Loss, explained: Mapping[Names, float]) -> float:
    """Gain of naming a part of the truth: the share of the gap that it explains, less the price of being a part."""
    whole = explained.get(truth.names, 0.0)
    share = explained.get(names, 0.0) / whole if whole > 0 else 0.0
    return min(max(share, 0.0), 1.0) - table.part


def _holds(report: Decision, truth: _Truth) -> bool:
    """Whether a report is right where ``truth`` is the case."""
    if report.sets:
        return truth.names in report.sets
    if not report.kinds:
        return not truth.names
    return truth.named.issuperset(report.names) and set(truth.kinds.values()).issuperset(report.kinds)

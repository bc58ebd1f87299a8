"""Choice of the report: the one with the smallest expected loss under the posterior.

A report consists of one set of causes, of a few alternative sets, of some names, of kinds of physics, or of nothing. The gain of
a report, given the true set of causes, follows from the table :class:`Loss`. Users may change its entries: a user who acts on a
name without further tests will want a larger loss for a wrong name.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields
from itertools import combinations
from math import isfinite, nan

from hsr_pin.errors import InputError, quoted
from hsr_pin.inference.posterior import Names, Posterior

#: Number of the most probable sets of causes that are considered; less probable sets do not change the report.
_SETS = 8


@dataclass(frozen=True)
class Loss:
    """Table of the gains and losses of a report.

    Attributes:
        exact: gain if the report names exactly the missing causes, or reports nothing where no cause in the catalogue is missing.
        alternative: deduction for every alternative after the first.
        part: deduction if only a part of the causes is named; the gain is the share of the gap that this part explains.
        kind: gain if the kinds of all missing causes are reported without names.
        wrong_name: loss if a cause is named that is not missing.
        none_right: loss if none of the reported alternatives is right.
        wrong_kind: loss if a kind is reported of which no cause is missing.
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
        """Return the table with the entries given in a text such as ``wrong_name=-8,part=0``, and defaults for the others.

        Raises:
            InputError: an entry does not exist, or its value is not a finite number.
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
    """Return the finite number of a loss entry."""
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        raise InputError(f"loss {name}", expected=f"a number, as in {name}=-4", received=quoted(text))
    return value


@dataclass(frozen=True)
class Decision:
    """A report with its expected gain.

    Attributes:
        sets: the reported sets of causes, the most probable first: one set, or several alternatives; empty if no complete set is
            reported.
        names: causes that are reported as missing; those of the set if ``sets`` has one.
        kinds: kinds of physics that are reported as missing, including the kinds of the named causes.
        gain: expected gain of the report.
        probability: probability that the report is right: that the set is the true one, that one of the alternatives is, or that
            all names and kinds are missing.
    """

    sets: tuple[Names, ...]
    names: Names
    kinds: tuple[str, ...]
    gain: float
    probability: float


@dataclass(frozen=True)
class _Truth:
    """A set of causes that may be the true one.

    Attributes:
        names: names of its causes.
        named: the names that are not flexible laws.
        kinds: kind of each of its causes.
        probability: probability of the set.
    """

    names: Names
    named: frozenset[str]
    kinds: Mapping[str, str]
    probability: float


def decide(found: Posterior, loss: Loss | None = None) -> Decision:
    """Return the report with the largest expected gain; of equal ones the one that states less."""
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
    """Return all sets of causes with their probabilities."""
    answers = []
    for names, probability in found.sets.items():
        causes = found.leader(names).causes
        named = frozenset(cause.name for cause in causes if not cause.flexible)
        answers.append(_Truth(names, named, {cause.name: cause.kind for cause in causes}, probability))
    return answers


def _explained(found: Posterior) -> dict[Names, float]:
    """Return the share of the gap of the nominal model that each set of causes explains, in its best variant."""
    answers: dict[Names, float] = {}
    for model, share in zip(found.models, found.explained, strict=True):
        answers[model.names] = max(answers.get(model.names, 0.0), float(share))
    return answers


def _alternatives(truths: list[_Truth]) -> Iterator[Decision]:
    """Yield the reports that name the most probable set of causes, or two or more of the most probable sets."""
    likely = [truth for truth in truths if truth.names][:_SETS]
    for count in range(1, len(likely) + 1):
        some = likely[:count]
        sets = tuple(truth.names for truth in some)
        names = frozenset.intersection(*(truth.named for truth in some))
        kinds = frozenset.intersection(*(frozenset(truth.kinds.values()) for truth in some))
        if count > 1 or len(names) == len(sets[0]):  # a flexible law alone is reported as its kind
            yield Decision(sets, tuple(sorted(names)), tuple(sorted(kinds)), 0.0, 0.0)


def _partial(truths: list[_Truth]) -> Iterator[Decision]:
    """Yield the reports that name some causes, or some kinds of physics, or both."""
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
    """Return all subsets of some items, the smallest first."""
    own = list(items)
    return [some for count in range(len(own) + 1) for some in combinations(own, count)]


def _gain(report: Decision, truth: _Truth, table: Loss, explained: Mapping[Names, float]) -> float:
    """Return the gain of a report if ``truth`` is the true set of causes."""
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
    """Return the gain of naming a part of the true set: the share of the gap that this part explains, minus the deduction."""
    whole = explained.get(truth.names, 0.0)
    share = explained.get(names, 0.0) / whole if whole > 0 else 0.0
    return min(max(share, 0.0), 1.0) - table.part


def _holds(report: Decision, truth: _Truth) -> bool:
    """Return whether a report is right if ``truth`` is the true set of causes."""
    if report.sets:
        return truth.names in report.sets
    if not report.kinds:
        return not truth.names
    return truth.named.issuperset(report.names) and set(truth.kinds.values()).issuperset(report.kinds)

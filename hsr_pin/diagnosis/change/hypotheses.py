"""Change hypotheses: a parameter of the arm may have changed, or an effect may have appeared, changed or disappeared."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import ARM, PLAIN, Part
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Probed amplitudes of an effect [scales]: without and with shape parameters.
_SIZES, _SHAPED = tuple(0.25 * 2 ** (k / 2) for k in range(12)), (0.3, 1.0, 3.0)
#: Probed amplitudes of an effect with a direction, along each of its axes; their influences are superposed.
_SIDED = (0.5, 2.0, 8.0)
#: Probed factors on the stiffness and other parameters of the arm, on the damping, and on an effect of the reference model.
_FACTORS, _WIDER = (0.6, 0.8, 0.9, 0.95, 1.05, 1.1, 1.25, 1.6, 2.5), (0.3, 0.6, 0.8, 1.25, 1.6, 2.5)
_GROWTH = (0.0, 0.5, 0.75, 1.25, 1.5, 2.0)


@dataclass(frozen=True, eq=False)
class ChangeHypothesis:
    """Hypothesis that one thing, or several together, have changed.

    Attributes:
        names: sorted names of the effects, or of the arm's parameters.
        hypothesis: the reference model including them.
        before: (P,) its values in the reference recording.
        open: names of the values that may differ in the current recording.
        probes: (C, K) open values of the probe simulations; for an effect with a direction (S, K, K), along each axis.
        parts: the parts that were added to the reference model.
    """

    names: tuple[str, ...]
    hypothesis: Hypothesis
    before: Array
    open: tuple[str, ...]
    probes: Array = field(default_factory=lambda: np.empty((0, 0)))
    parts: tuple[Part, ...] = ()

    @cached_property
    def places(self) -> list[int]:
        """Indices of the open values among all values."""
        return [self.hypothesis.free.index(name) for name in self.open]

    @cached_property
    def facts(self) -> tuple[Parameter, ...]:
        """Unit, bounds and scale of each open value."""
        return tuple(self.hypothesis.parameters[k] for k in self.places)

    @cached_property
    def sizes(self) -> list[bool]:
        """For each open value, whether it is an amplitude and not a shape parameter."""
        return [fact.amplitude or fact.name in ARM for fact in self.facts]

    @property
    def start(self) -> Array:
        """Open values (K,) in the reference recording."""
        return np.asarray(self.before[self.places])

    @property
    def kinds(self) -> dict[str, str]:
        """Kinds of physics by name."""
        own = {part.name: part.kind for part in self.hypothesis.parts} | {"keq_scale": "elastic", "damping_scale": "damping"}
        return {name: own[name] for name in self.names}

    def values(self, changed: Array) -> Array:
        """Return all values (C, P) of the model for open values (C, K)."""
        points = np.tile(self.before, (len(changed), 1))
        points[:, self.places] = changed
        return points

    def delays(self, changed: Array) -> tuple[Array, Array]:
        """Return the additional command delay (C,) [s] for open values (C, K), and these values with the reference delay."""
        late = np.array([name.endswith(".delay") for name in self.open])
        return (changed - self.start)[:, late].sum(axis=1), np.where(late, self.start, changed)

    def contains(self, other: ChangeHypothesis) -> bool:
        """Return whether another hypothesis is a special case of this one."""
        mine = {part.name: part for part in self.hypothesis.parts if part.name in self.names}
        theirs = [part for part in other.hypothesis.parts if part.name in other.names]
        return self.names != other.names and any(mine[a].contains(b) for a in mine for b in theirs)

    @property
    def unlike(self) -> list[list[str]]:
        """Lists of parameters; some of each list must differ if this hypothesis is more than those that it contains."""
        effects = [part.effect for part in self.hypothesis.parts if part.effect and part.name in self.names]
        return [[f"{effect.name}.{name}" for name in effect.distinguished_by] for effect in effects if effect.distinguished_by]

    def together(self, other: ChangeHypothesis) -> ChangeHypothesis:
        """Return the hypothesis that both have changed."""
        model, before, added = self.hypothesis, self.before, self.parts
        for part in other.parts:
            if part.name not in {each.name for each in added}:
                model = model.with_part(part)
                before = np.append(before, [fact.neutral for fact in model.parameters[len(before) :]])
                added = (*added, part)
        names = tuple(sorted({*self.names, *other.names}))
        return ChangeHypothesis(names, model, before, (*self.open, *other.open), parts=added)


def change_hypotheses(model: Hypothesis, values: Array, parts: Sequence[Part]) -> list[ChangeHypothesis]:
    """Return all single change hypotheses for a reference model with free parameters at ``values`` (P,).

    Args:
        model: the reference model.
        values: (P,) values of its free parameters.
        parts: effects that may appear, in every variant.
    """
    found = [
        _there(model, values, ("keq_scale",), _FACTORS),
        _there(model, values, ("damping_scale",), _WIDER),
    ]
    there = {part.name: part for part in model.parts}
    for part in parts:
        if part.flexible or ((part.resized or part.levels) and part.name not in there):
            continue
        if part.name == ("mass_scale" if "added_mass" in there else "added_mass"):
            continue  # the same law under two names
        if part.name in there:
            if there[part.name].variant == part.variant:
                sizes = [f.name for f in model.parameters if _owner(f.name) == part.name and (f.amplitude or f.name in PLAIN)]
                found.append(_there(model, values, tuple(sizes), _GROWTH if part.effect else _FACTORS))
        else:
            more = model.with_part(part)
            new = more.parameters[len(values) :]
            before = np.append(values, [fact.neutral for fact in new])
            probes = _probes(new) if part.effect else np.array(_FACTORS)[:, None]
            found.append(ChangeHypothesis((part.name,), more, before, tuple(fact.name for fact in new), probes, (part,)))
    return found


def _owner(name: str) -> str:
    return name.partition(".")[0]


def _there(model: Hypothesis, values: Array, names: tuple[str, ...], factors: Sequence[float]) -> ChangeHypothesis:
    at = [model.free.index(name) for name in names]
    low, high = (bound[at] for bound in model.bounds)
    facts = [model.parameters[k] for k in at]
    if _sided(facts):
        return ChangeHypothesis((_owner(names[0]),), model, values, names, _along_axes(facts, values[at]))
    neutral = np.array([0.0 if name in ARM else model.parameters[k].neutral for name, k in zip(names, at, strict=True)])
    probes = np.clip(neutral + np.outer(factors, values[at] - neutral), low, high)
    return ChangeHypothesis((_owner(names[0]),), model, values, names, probes)


def _probes(facts: Sequence[Parameter]) -> Array:
    """Return a few amplitudes with both signs where possible, at a few values of each shape parameter, as probe values."""
    if _sided(facts):
        return _along_axes(facts, np.array([fact.neutral for fact in facts]))
    shaped = not all(fact.amplitude for fact in facts)
    ways = (1.0, -1.0) if all(fact.lower < fact.neutral for fact in facts if fact.amplitude) else (1.0,)
    found: list[tuple[float, ...]] = []
    for size, way in itertools.product(_SHAPED if shaped else _SIZES, ways):
        at = [[float(fact.neutral + way * size * fact.scale)] if fact.amplitude else fact.start_values for fact in facts]
        if all(fact.lower <= values[0] <= fact.upper for fact, values in zip(facts, at, strict=True)):
            found += itertools.product(*at)
    return np.array(found)


def _sided(facts: Sequence[Parameter]) -> bool:
    """Return whether the parameters of an effect are the components of a vector."""
    return len(facts) > 1 and all(fact.amplitude and fact.lower < fact.neutral for fact in facts)


def _along_axes(facts: Sequence[Parameter], values: Array) -> Array:
    """Return for each size the values (S, K, K) with one of them larger by that size, or smaller at an upper bound."""
    steps = np.multiply.outer(_SIDED, [fact.scale for fact in facts])
    ways = np.where(values + steps <= [fact.upper for fact in facts], steps, -steps)
    return np.asarray(values + ways[:, None] * np.eye(len(facts)))

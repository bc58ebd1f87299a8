"""Select the open parameters of a hypothesis by name."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import get_close_matches

import numpy as np

from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import Effect, neutral, with_values
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.hypothesis import LINKS, Hypothesis
from hsr_pin.identification.part import ARM, SESSION
from hsr_pin.identification.prepared import Run
from hsr_pin.robot.specification import Placement

#: Short names of the factors on declared values.
SHORT = {"keq": "keq_scale", "damping": "damping_scale", "mass": "mass_scale", "gain": "torque_gain", "drift": "keq_drift"}
#: Effects that may be named.
_NAMED = EFFECTS | SPATIAL
#: Parameters that differ between stiffness levels.
_BY_LEVEL = ("keq_scale", "damping_scale")
#: Suffix, in place of a level, for a separate parameter at each level.
_EACH = "each"
#: Initial amplitude of an effect, relative to its parameter's scale; at the neutral value its other parameters have no influence.
_INITIAL_AMPLITUDE = 0.5


def choose(
    free: Sequence[str],
    effects: Sequence[Effect],
    runs: Sequence[Run],
    *,
    links: int = LINKS,
    placement: Placement = "mid",
    by_level: bool = False,
) -> Hypothesis:
    """Return a hypothesis with the named parameters open.

    Args:
        free: "keq", "damping", "mass" (or "keq_scale", ...), optionally followed by "@1.11" for the trials declared with that
            Keq; "effect" for all parameters of an effect, "effect.parameter" for one; followed by "@each", one parameter for each
            Keq.
        effects: effects in addition to the nominal model, all their parameters open; their values are the initial values of the
            fit.
        runs: the trials to fit.
        links: number of links of the chain.
        placement: placement of its joints.
        by_level: whether each declared Keq has its own stiffness and damping.

    Raises:
        IdentificationError: a name is unknown, no parameter is named, or no trial has a named level.
    """
    present = {effect.name: effect for effect in effects}
    names: list[str] = []
    each = [f"@{keq:g}" for keq in sorted({run.trial.keq for run in runs})]
    for name in free:
        base, at, level = name.strip().partition("@")
        base = SHORT.get(base, base)
        split = level == _EACH and base not in SESSION
        if base in ARM | SESSION:
            split = split or (by_level and not at and base in _BY_LEVEL)
            names += [base + one for one in (each if split else [at + level])]
            continue
        kind, _, field = base.partition(".")
        facts = _NAMED[kind].parameters() if kind in _NAMED else ()
        chosen = [fact.name for fact in facts if field in ("", fact.name)]
        if not chosen:
            raise _unknown(name)
        if at and not split:
            raise IdentificationError("parameter to fit", expected=f"{base}, or {base}@{_EACH} for each Keq", received=repr(name))
        present.setdefault(kind, neutral(_NAMED[kind]))
        names += [f"{kind}.{fact}{one}" for fact in chosen for one in (each if split else [""])]
    split_up = {name.partition("@")[0] for name in names if "@" in name}
    given = [f"{e.name}.{fact.name}" for e in effects for fact in e.parameters()]
    names = [*(name for name in given if name not in split_up), *names]
    if not names:
        raise IdentificationError("parameters to fit", expected="at least one", received="none", hint="e.g. keq,damping")
    names = list(dict.fromkeys(names))
    hypothesis = Hypothesis(tuple(_activated(e, names) for e in present.values()), tuple(names), links, placement)
    _check(hypothesis, runs)
    return hypothesis


def _activated(effect: Effect, free: Iterable[str]) -> Effect:
    """Return the effect with its open amplitudes moved away from neutral, if all of them are neutral."""
    known = {name.partition("@")[0] for name in free}
    amplitudes = [fact for fact in effect.parameters() if fact.amplitude and f"{effect.name}.{fact.name}" in known]
    if any(getattr(effect, fact.name) != fact.neutral for fact in amplitudes):
        return effect
    away = {fact.name: min(fact.neutral + _INITIAL_AMPLITUDE * fact.scale, fact.upper) for fact in amplitudes}
    return with_values(effect, **away)


def _check(hypothesis: Hypothesis, runs: Sequence[Run]) -> None:
    """Raise an error for levels that do not exist or that contradict each other."""
    levels = sorted({run.trial.keq for run in runs})
    for fact in hypothesis.parameters:
        base, at, level = fact.name.partition("@")
        if at and not np.isclose(float(level), levels).any():
            raise IdentificationError(
                fact.name, expected=f"a declared Keq of the trials, {', '.join(f'{keq:g}' for keq in levels)}", received=level
            )
        if at and base in hypothesis.free:
            raise IdentificationError(fact.name, expected=f"either this or {base} for all levels", received="both")


def _unknown(name: str) -> IdentificationError:
    every = [*SHORT, *ARM, *SESSION, *_NAMED, *(f"{e.name}.{fact.name}" for e in _NAMED.values() for fact in e.parameters())]
    close = get_close_matches(name, EFFECTS, n=1, cutoff=0.5) or get_close_matches(name, every, n=1, cutoff=0.5)
    return IdentificationError(
        "parameter to fit",
        expected=f"{', '.join(SHORT)}, an effect ({', '.join(EFFECTS)}) or effect.parameter",
        received=repr(name),
        hint=f"did you mean {close[0]}?" if close else "",
    )


def without_effects(hypothesis: Hypothesis) -> Hypothesis:
    """Return the declared arm on the same chain, without effects and open parameters."""
    return replace(hypothesis, effects=(), free=())

"""Where to start a search: the misfit of a swinging arm has several basins, one for each swing that it may be out of step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from hsr_pin.identification.evaluation import predict
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import ARM, Part
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import residuals, rms
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Points looked at (a power of two), and how many of them are worth a search of their own.
LOOKS, BEST = 16, 2
#: How far around a factor on a declared value is looked: the damping is the least known.
_AROUND = {"keq_scale": 2.0, "damping_scale": 4.0, "mass_scale": 2.0, "torque_gain": 2.0}
#: How far around the neutral value of an amplitude, over its scale.
_AMPLITUDE = 4.0
#: A point is worth a search only if its misfit is less than this share of that of the start: not for its rounding.
_BETTER = 1 - 1e-6
#: Links of a look, and its error of a step [m at the tip].
_LINKS, _TOLERANCE = 4, 1e-3


def starts(experiment: Experiment, hypothesis: Hypothesis) -> list[Array]:
    """Values (P,) to start a search from.

    They are the hypothesis' own; where effects are open, its own with the arm as it is fitted without them; and the best two of
    sixteen others, and of those with a torque that is late by a little, if they fit better than its own.

    The others are a Sobol sequence (I. M. Sobol, USSR Comput. Math. Math. Phys. 7, 1967) over what is plausible, simulated
    roughly and in one batch. A point at which a simulation fails counts as off by the length of the arm.
    """
    from scipy.stats import qmc  # here: slow to load, and a diagnosis has starts of its own

    own, facts = hypothesis.start, hypothesis.parameters
    unit = qmc.Sobol(len(own), scramble=False).random(LOOKS)
    points = [own, *(np.array([_plausible(*each) for each in zip(facts, own, row, strict=True)]) for row in unit)]
    points += [_late(hypothesis, part) for part in hypothesis.parts if part.kind == "actuation_time"]
    rough = replace(hypothesis, links=min(_LINKS, hypothesis.links), tolerance=max(_TOLERANCE, hypothesis.tolerance))
    predictions = predict(experiment, rough, [(run, point) for point in points for run in experiment.runs])
    count = len(experiment.runs)
    missed = [rms(residuals(experiment, predictions[k * count : (k + 1) * count])) for k in range(len(points))]
    better = [k for k in np.argsort(missed) if missed[k] < _BETTER * missed[0]]
    return [own, *_nested(experiment, hypothesis), *(points[k] for k in better[:BEST])]


def _nested(experiment: Experiment, hypothesis: Hypothesis) -> list[Array]:
    """From a fit of the arm alone a fit with effects cannot well end up worse than it."""
    arm = tuple(name for name in hypothesis.free if name.partition("@")[0] in ARM)
    if not arm or not hypothesis.effects:
        return []
    alone = fit(experiment, replace(hypothesis, effects=(), free=arm), quick=True).named
    return [np.array([alone.get(name, value) for name, value in zip(hypothesis.free, hypothesis.start, strict=True)])]


def _late(hypothesis: Hypothesis, part: Part) -> Array:
    """Its own with one law that makes the torque late at work: else strong damping, which looks late too, may be in its place."""
    amplitudes = {fact.name for fact in hypothesis.parameters if fact.amplitude and fact.name.startswith(f"{part.name}.")}
    late = [fact.neutral + fact.scale / len(amplitudes) if fact.name in amplitudes else None for fact in hypothesis.parameters]
    return np.array([own if value is None else value for own, value in zip(hypothesis.start, late, strict=True)])


def _plausible(fact: Parameter, start: float, u: float) -> float:
    """From ``u`` in [0, 1] to a value of a parameter, evenly by ratio where it is a factor or spans more than one of five."""
    base = fact.name.partition("@")[0]
    by_ratio = base in ARM
    if base in ARM:
        low, high = start / _AROUND[base], start * _AROUND[base]
    elif fact.amplitude:
        low, high = fact.neutral - _AMPLITUDE * fact.scale, fact.neutral + _AMPLITUDE * fact.scale
    else:
        low, high = fact.lower, fact.upper
        by_ratio = low > 0 and high / low > 5
    low, high = max(low, fact.lower), min(high, fact.upper)
    return float(low * (high / low) ** u if by_ratio else low + (high - low) * u)

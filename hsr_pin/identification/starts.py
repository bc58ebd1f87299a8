"""Initial values of a search: the misfit of an oscillating arm has several local minima, one for each period of phase error."""

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

#: Number of tried points (a power of two), and the number of them from which a search starts.
LOOKS, BEST = 16, 2
#: Range of a factor on a declared value: the damping is least known.
_AROUND = {"keq_scale": 2.0, "damping_scale": 4.0, "mass_scale": 2.0, "torque_gain": 2.0}
#: Range of an amplitude about its neutral value, relative to its scale.
_AMPLITUDE = 4.0
#: Largest misfit, relative to that of the first initial values, from which a search starts; not 1 because of rounding.
_BETTER = 1 - 1e-6
#: Number of links and tolerance of a step [m at the tip] when a point is tried.
_LINKS, _TOLERANCE = 4, 1e-3


def starts(experiment: Experiment, hypothesis: Hypothesis) -> list[Array]:
    """Return initial values (P,) of a search.

    They are the hypothesis' own values; if effects are open, its own values with the arm fitted without effects; and the best two
    of sixteen others, and of those with a slightly delayed torque, if they fit better than its own.

    The others are a Sobol sequence (I. M. Sobol, USSR Comput. Math. Math. Phys. 7, 1967) over the plausible range, simulated
    roughly in one batch. A failed simulation counts as an error of the arm's length.
    """
    from scipy.stats import qmc  # late import: slow to load, and not needed by a diagnosis

    own, facts = hypothesis.start, hypothesis.parameters
    unit = qmc.Sobol(len(own), scramble=False).random(LOOKS)
    points = [own, *(np.array([_plausible(*each) for each in zip(facts, own, row, strict=True)]) for row in unit)]
    points += [_with_delay(hypothesis, part) for part in hypothesis.parts if part.kind == "actuation_time"]
    rough = hypothesis.coarser(_LINKS, _TOLERANCE)
    predictions = predict(experiment, rough, [(run, point) for point in points for run in experiment.runs])
    count = len(experiment.runs)
    missed = [rms(residuals(experiment, predictions[k * count : (k + 1) * count])) for k in range(len(points))]
    better = [k for k in np.argsort(missed) if missed[k] < _BETTER * missed[0]]
    return [own, *_nested(experiment, hypothesis), *(points[k] for k in better[:BEST])]


def _nested(experiment: Experiment, hypothesis: Hypothesis) -> list[Array]:
    """Return the values of a fit of the arm alone, so that a fit with effects hardly ends with a larger misfit."""
    arm = tuple(name for name in hypothesis.free if name.partition("@")[0] in ARM)
    if not arm or not hypothesis.effects:
        return []
    alone = fit(experiment, replace(hypothesis, effects=(), free=arm), quick=True).named
    return [np.array([alone.get(name, value) for name, value in zip(hypothesis.free, hypothesis.start, strict=True)])]


def _with_delay(hypothesis: Hypothesis, part: Part) -> Array:
    """Return the hypothesis' own values with one law that delays the torque active, because strong damping resembles a delay."""
    amplitudes = {fact.name for fact in hypothesis.parameters if fact.amplitude and fact.name.startswith(f"{part.name}.")}
    delayed = [fact.neutral + fact.scale / len(amplitudes) if fact.name in amplitudes else None for fact in hypothesis.parameters]
    return np.array([own if value is None else value for own, value in zip(hypothesis.start, delayed, strict=True)])


def _plausible(fact: Parameter, start: float, u: float) -> float:
    """Map ``u`` in [0, 1] to a value of a parameter; logarithmically for a factor or a range of more than five to one."""
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

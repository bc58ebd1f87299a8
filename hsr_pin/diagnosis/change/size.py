"""Sizes of changes with their intervals, and residuals with single trials left out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt

import numpy as np
from scipy import stats

from hsr_pin.diagnosis.change.fitting import Fitted
from hsr_pin.diagnosis.change.frame import Frame
from hsr_pin.identification.part import ARM
from hsr_pin.inference.step import damped_inverse, damped_step
from hsr_pin.trajectory import Array

#: Damping of the normal matrix, as a share of its diagonal: with a trial left out, and without.
_DAMPING, _NEARLY_NONE = 1e-3, 1e-9


@dataclass(frozen=True)
class Size:
    """Size of the change of one parameter.

    Attributes:
        name: name of the effect, or of the arm's parameter.
        parameter: "keq_scale", "effect.parameter".
        unit: unit of the values; "1" for a ratio.
        before, after: values in the reference and in the current recording; ``before`` is None for the shape of a new effect.
        was, becomes: 95 % intervals of both.
        step: 95 % interval of the change: a ratio for a parameter of the arm, otherwise a difference.
    """

    name: str
    parameter: str
    unit: str
    before: float | None
    after: float
    was: tuple[float, float] | None
    becomes: tuple[float, float]
    step: tuple[float, float] | None

    @property
    def moved(self) -> bool:
        """Whether the change is significant."""
        still = 1.0 if self.name in ARM else 0.0
        return self.step is not None and not self.step[0] <= still <= self.step[1]


def left_out(frame: Frame, fitted: Fitted) -> tuple[Array, Array]:
    """Return values (T, K) with each current trial left out, and residuals (n,) of each trial with the values without it."""
    residual, scale = fitted.residual.copy(), np.array([fact.scale for fact in fitted.change.facts])
    values = []
    runs = list(frame.pair.new_runs)
    for run in runs:
        others = frame.run != run
        step = damped_step(fitted.slopes[others] * scale, fitted.residual[others], _DAMPING) if len(runs) > 1 else 0 * scale
        step = scale * np.clip(step, -2.0, 2.0)
        values.append(fitted.after + step)
        residual[~others] += fitted.slopes[~others] @ step
    return np.array(values), residual


def standard_errors(frame: Frame, fitted: Fitted, inflation: float) -> tuple[Array, float]:
    """Return standard errors (K,) of the current values, the larger of those from noise and trials, and their freedom."""
    scale = np.array([fact.scale for fact in fitted.change.facts])
    slopes = fitted.slopes * scale
    new = frame.run >= len(frame.pair.old.runs)
    spread = max(1.0, float(np.mean(fitted.residual[new] ** 2)))
    noise = (
        np.diag(damped_inverse(slopes, _NEARLY_NONE)) * max(spread, inflation) * scale**2
    )  # large for parameters without influence
    values, _ = left_out(frame, fitted)
    count = len(values)
    between = (count - 1) / count * ((values - values.mean(axis=0)) ** 2).sum(axis=0) if count > 1 else np.zeros(len(scale))
    return np.sqrt(np.maximum(noise, between)), max(count - 1, 1)


def sizes(frame: Frame, fitted: Fitted, was: Mapping[str, tuple[float, float]], inflation: float) -> tuple[Size, ...]:
    """Return the sizes of all changes of a hypothesis.

    Args:
        frame: the whitened residuals.
        fitted: the change.
        was: 95 % intervals of the values of the reference model, by name.
        inflation: variance inflation from the trials of the reference recording.
    """
    errors, freedom = standard_errors(frame, fitted, inflation)
    reach = min(float(stats.t.ppf(0.975, freedom)), 3.2) * errors
    found = []
    for k, (fact, start) in enumerate(zip(fitted.change.facts, fitted.change.start, strict=True)):
        after, name = float(fitted.after[k]), fact.name.partition(".")[0]
        there = fitted.change.sizes[k] or fact.name in was
        before = float(start) if there else None
        span = was.get(fact.name, (float(start), float(start))) if there else None
        becomes = _within(fact.lower, fact.upper, after, float(reach[k]), span)
        step = None
        if before is not None:
            low, high = after - reach[k], after + reach[k]
            ends = (max(low, 1e-9) / before, high / before) if fact.name in ARM else (low - before, high - before)
            step = float(ends[0]), float(ends[1])
        found.append(Size(name, fact.name, fact.unit, before, after, span, becomes, step))
    return tuple(found)


def _within(lower: float, upper: float, value: float, reach: float, was: tuple[float, float] | None) -> tuple[float, float]:
    wide = sqrt(reach**2 + ((was[1] - was[0]) / 2) ** 2) if was else reach
    return max(lower, value - wide), min(upper, value + wide)

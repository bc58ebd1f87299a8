"""How large a change is, how sure that is, and how much of the difference it explains on trials that it was not fitted to."""

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

#: Share of the diagonal of the normal matrix that is added to it: where a trial is left out, and where none is.
_DAMPING, _NEARLY_NONE = 1e-3, 1e-9


@dataclass(frozen=True)
class Size:
    """Of one number that has changed.

    Attributes:
        name: of the effect, or of the arm's number.
        parameter: "keq_scale", "effect.parameter".
        unit: "1" for a ratio.
        before, after: the value in OLD (None: the effect was not there, and this is its shape), and in NEW.
        was, becomes: 95 % intervals of both.
        step: 95 % interval of the step between them: of a number of the arm the ratio, else the difference.
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
        """Whether it is certainly another than it was."""
        still = 1.0 if self.name in ARM else 0.0
        return self.step is not None and not self.step[0] <= still <= self.step[1]


def left_out(frame: Frame, fitted: Fitted) -> tuple[Array, Array]:
    """(T, K) the values with each of NEW's trials left out, and (n,) the residuals, each trial's with the values without it."""
    residual, scale = fitted.residual.copy(), np.array([fact.scale for fact in fitted.suspect.facts])
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
    """(K,) of the values in NEW, beside what OLD was: the larger of what noise and of what the trials say; and their freedom."""
    scale = np.array([fact.scale for fact in fitted.suspect.facts])
    slopes = fitted.slopes * scale
    new = frame.run >= len(frame.pair.old.runs)
    spread = max(1.0, float(np.mean(fitted.residual[new] ** 2)))
    noise = np.diag(damped_inverse(slopes, _NEARLY_NONE)) * max(spread, inflation) * scale**2  # of what moves nothing: large
    values, _ = left_out(frame, fitted)
    count = len(values)
    between = (count - 1) / count * ((values - values.mean(axis=0)) ** 2).sum(axis=0) if count > 1 else np.zeros(len(scale))
    return np.sqrt(np.maximum(noise, between)), max(count - 1, 1)


def sizes(frame: Frame, fitted: Fitted, was: Mapping[str, tuple[float, float]], inflation: float) -> tuple[Size, ...]:
    """Of everything that changed.

    Args:
        frame: what residuals are seen through.
        fitted: the change.
        was: 95 % intervals of the values of OLD's model, by name.
        inflation: of the variance, by what OLD's own trials show.
    """
    errors, freedom = standard_errors(frame, fitted, inflation)
    reach = min(float(stats.t.ppf(0.975, freedom)), 3.2) * errors
    found = []
    for k, (fact, start) in enumerate(zip(fitted.suspect.facts, fitted.suspect.start, strict=True)):
        after, name = float(fitted.after[k]), fact.name.partition(".")[0]
        there = fitted.suspect.sizes[k] or fact.name in was
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

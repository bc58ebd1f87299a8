"""Whether the base moves, and how much of what is missing follows from that.

The model takes the base as fixed. What its markers did shortly before foretells the gap where it is not so: an impulse response
of the arm to its base is learnt from all trials but one (ridge regression on lagged motion, a FIR model: L. Ljung, System
Identification, Prentice Hall 1999, ch. 4), and judged on that one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.prepared import BASE
from hsr_pin.trajectory import Array

#: The base is what moves if this share of the squared gap follows from its motion.
MOST = 0.5
#: [s] between lags; how many of them, the first shortly after: what is seen at once may be seen a sample late.
_STEP, _LAGS = 0.02, range(-2, 30)
#: Ridge, over the mean square of the motion.
_RIDGE = 1e-2


@dataclass(frozen=True)
class BaseMotion:
    """Share of the squared gap that the motion of the base's markers foretells in trials that it was not learnt from."""

    foretold: float

    @property
    def kind(self) -> str:
        """Kind of physics that it tells; empty if none."""
        return "measurement" if self.foretold >= MOST else ""

    @property
    def sentence(self) -> str:
        """As a person would say it; empty where the base does not matter."""
        told = (
            f"the base moves, which the model takes as fixed: its markers foretell {100 * self.foretold:.0f} % of what is missing"
        )
        return told if self.kind else ""


def base_motion(experiment: Experiment, missed: Sequence[Array]) -> BaseMotion | None:
    """From the gap of each run (T, M, A) [m]; None without markers at the base, or with one run."""
    dataset = experiment.dataset
    base = [index for index, marker in enumerate(dataset.markers) if marker.arc_length <= BASE * dataset.length]
    if not base or len(experiment.runs) < 2:
        return None
    causes, effects = [], []
    for run, gap in zip(experiment.runs, missed, strict=True):
        motion = run.trial.trajectory.positions[-len(run.time) :, base].reshape(len(run.time), -1)
        every = max(1, round(_STEP / run.step))
        causes.append(np.concatenate([_late(_centred(motion), lag * every) for lag in _LAGS], axis=1)[run.looked_at])
        effects.append(_centred(gap.reshape(len(gap), -1)))
    squares, products = [x.T @ x for x in causes], [x.T @ y for x, y in zip(causes, effects, strict=True)]
    whole, left = 0.0, 0.0
    for k, (cause, effect) in enumerate(zip(causes, effects, strict=True)):
        square, product = sum(squares) - squares[k], sum(products) - products[k]
        ridge = _RIDGE * np.trace(square) / len(square)
        if ridge == 0:
            return None
        response = np.linalg.solve(square + ridge * np.eye(len(square)), product)
        whole, left = whole + float((effect**2).sum()), left + float(((effect - cause @ response) ** 2).sum())
    return BaseMotion(max(0.0, 1 - left / whole)) if whole > 0 else None


def _centred(values: Array) -> Array:
    """(T, K) about their medians; 0 in gaps."""
    seen = np.isfinite(values).any(axis=0)
    middle = np.zeros(values.shape[1])
    middle[seen] = np.nanmedian(values[:, seen], axis=0)
    return np.nan_to_num(values - middle)


def _late(values: Array, samples: int) -> Array:
    """(T, K) moved by some samples; at the ends the outermost goes on."""
    return values[np.clip(np.arange(len(values)) - samples, 0, len(values) - 1)]

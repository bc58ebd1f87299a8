"""The part of the gap that the motion of the base predicts.

The model assumes a fixed base. If the base moves, its recent motion predicts the gap. An impulse response of the arm to its base
is learned from all trials but one (ridge regression on lagged motion, a FIR model: L. Ljung, System Identification, Prentice Hall
1999, ch. 4) and tested on that trial.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.prepared import BASE
from hsr_pin.trajectory import Array

#: The base motion is significant if it predicts this share of the squared gap.
MOST = 0.5
#: Interval between lags [s], and their indices; a few are negative because markers may be recorded a sample late.
_STEP, _LAGS = 0.02, range(-2, 30)
#: Ridge parameter relative to the mean square of the motion.
_RIDGE = 1e-2


@dataclass(frozen=True)
class BaseMotion:
    """Prediction of the gap by the motion of the base markers.

    Attributes:
        predicted: share of the squared gap that is predicted in held-out trials.
    """

    predicted: float

    @property
    def kind(self) -> str:
        """Kind of physics that the base motion indicates; empty if it is not significant."""
        return "measurement" if self.predicted >= MOST else ""

    @property
    def sentence(self) -> str:
        """Conclusion as a clause; empty if the base motion is not significant."""
        share = f"{100 * self.predicted:.0f} %"
        return f"the base moves, although the model assumes it fixed: its markers predict {share} of the gap" if self.kind else ""


def base_motion(experiment: Experiment, missed: Sequence[Array]) -> BaseMotion | None:
    """Return how well the base motion predicts the gaps (T, M, A) [m]; None without base markers or with a single run."""
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
    """Return values (T, K) minus their medians; 0 in gaps."""
    seen = np.isfinite(values).any(axis=0)
    middle = np.zeros(values.shape[1])
    middle[seen] = np.nanmedian(values[:, seen], axis=0)
    return np.nan_to_num(values - middle)


def _late(values: Array, samples: int) -> Array:
    """Return values (T, K) shifted by a number of samples; the first or last value fills the end."""
    return values[np.clip(np.arange(len(values)) - samples, 0, len(values) - 1)]

"""Apparent damping changes that follow from a change of the natural frequency.

The damper of the model is viscous, whereas that of a material is not. In any linear viscoelastic solid (a sum of Maxwell
elements) the viscous coefficient falls with the frequency, at most in inverse proportion to its square: c(w) = sum of E_i t_i /
(1 + (w t_i)^2) (J. D. Ferry, Viscoelastic Properties of Polymers, 1980). Rate-independent damping, as of silicone rubber, lies
half-way between.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import eigh

from hsr_pin.diagnosis.change.fitting import Fitted
from hsr_pin.diagnosis.change.pair import Pair
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.prepared import Run
from hsr_pin.robot.chain import chain_of, mass_matrix, weight_matrix
from hsr_pin.trajectory import Array

#: Damping ratio above which an arm is treated as non-oscillating.
_OVERDAMPED = 0.7


def natural_frequency(experiment: Experiment, run: Run, model: Hypothesis, values: Array) -> float:
    """Return the natural frequency of the straight arm of a run at ``values`` (P,) [rad/s]; 0 if it is overdamped or unstable."""
    batch = model.arm_batch(experiment, run, values[None])
    chain, arrays = chain_of(batch.arms), batch.arrays
    if batch.space:  # equal about both axes
        chain = replace(chain, gravity=arrays.gravity[:, [2, 0]])
    mass = mass_matrix(chain)
    squares, modes = eigh(np.diag(arrays.spring[0]) + weight_matrix(chain), mass, subset_by_index=[0, 0])
    if squares[0] <= 0:
        return 0.0
    slowest, mode = float(np.sqrt(squares[0])), modes[:, 0]
    return slowest if float(mode @ (arrays.damper[0] * mode)) < 2 * _OVERDAMPED * slowest else 0.0


def apparent_damping_range(pair: Pair, fitted: Fitted) -> tuple[float, float]:
    """Return the range of apparent damping factors without a real change; both are 1 if the frequency is unchanged or zero."""
    change = fitted.change
    after = change.values(fitted.after[None])[0]
    was = [natural_frequency(pair.experiment, run, change.hypothesis, change.before) for run in pair.old.runs]
    is_ = [natural_frequency(pair.experiment, run, change.hypothesis, after) for run in pair.new.runs]
    if not (all(was) and all(is_)):
        return 1.0, 1.0
    ratio = np.exp(np.mean([min((np.log(a / b) for a in was), key=abs) for b in is_]))
    return min(1.0, float(ratio**2)), max(1.0, float(ratio**2))

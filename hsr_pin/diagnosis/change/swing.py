"""What damping may do by itself where a change makes an arm swing slower or faster.

The damper of the model is viscous; that of a material is not. In any linear viscoelastic solid, a sum of Maxwell elements, the
viscous constant falls with the frequency, and no faster than its square rises: c(w) = sum of E_i t_i / (1 + (w t_i)^2)
(J. D. Ferry, Viscoelastic Properties of Polymers, 1980); rate-independent damping, as of silicone rubber, is half-way between.
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

#: Damping ratio from which on an arm does not swing.
_CREEPS = 0.7


def rate(experiment: Experiment, run: Run, model: Hypothesis, values: Array) -> float:
    """[rad/s] at which the straight arm of a run swings, with the open parameters at ``values`` (P,); 0 where it does not."""
    columns = model.columns(experiment, run, values[None])
    chain, arrays = chain_of(columns.arms), columns.arrays
    if columns.space:  # the same about both axes
        chain = replace(chain, gravity=arrays.gravity[:, [2, 0]])
    mass = mass_matrix(chain)
    squares, modes = eigh(np.diag(arrays.spring[0]) + weight_matrix(chain), mass, subset_by_index=[0, 0])
    if squares[0] <= 0:
        return 0.0
    slowest, mode = float(np.sqrt(squares[0])), modes[:, 0]
    return slowest if float(mode @ (arrays.damper[0] * mode)) < 2 * _CREEPS * slowest else 0.0


def slack(pair: Pair, fitted: Fitted) -> tuple[float, float]:
    """By which factors damping may seem another though it is the same: both 1 where the arm swings as it did, or does not."""
    suspect = fitted.suspect
    after = suspect.values(fitted.after[None])[0]
    was = [rate(pair.experiment, run, suspect.hypothesis, suspect.before) for run in pair.old.runs]
    is_ = [rate(pair.experiment, run, suspect.hypothesis, after) for run in pair.new.runs]
    if not (all(was) and all(is_)):
        return 1.0, 1.0
    ratio = np.exp(np.mean([min((np.log(a / b) for a in was), key=abs) for b in is_]))
    return min(1.0, float(ratio**2)), max(1.0, float(ratio**2))

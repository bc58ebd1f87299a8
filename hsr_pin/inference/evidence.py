"""Log evidence of a model: a coarsened likelihood with a discrepancy term, an Occam factor and priors.

No model of a robot is exact, and its error repeats in every trial, so that ten thousand samples carry the information of about
ten independent ones. The likelihood is therefore raised to the power nu / N (J. W. Miller, D. B. Dunson, Robust Bayesian
inference via coarsening, JASA 114, 2019), and the variance of the model discrepancy is profiled for each model (M. C. Kennedy, A.
O'Hagan, Bayesian calibration of computer models, J. R. Stat. Soc. B 63, 2001)::

    v      = S + (floor sigma)^2
    log p  = -nu/2 ln v - 1/2 sum_i ln(1 + nu/N e_i / v) - sum_j ln(1 + z_j^2) - kappa |h| - kappa_f |flexible in h|
             - ln(variants)

S is the mean square residual beyond noise and sigma^2 the variance of noise, both for one coordinate; the trial-to-trial scatter
is a part of every model's S. e_i are the eigenvalues of the information of the residuals about the parameters, in units of their
prior, and z_j is the distance of each parameter from the centre of its prior in standard deviations. The tails of the prior are
those of a Cauchy distribution: a parameter far from the centre is penalised, not excluded.
"""

from __future__ import annotations

from math import log

import numpy as np

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.model import Data, Model

#: Smallest variance, which keeps the logarithm finite if a prediction is equal to the recordings.
_NOTHING = 1e-300


def variance(misfit: float, data: Data, calibration: Calibration) -> float:
    """Return v, the variance of one coordinate that a model leaves, at least the floor that is assumed for every model."""
    return max(max(misfit, 0.0) + calibration.floor**2 * data.noise, _NOTHING)


def log_evidence(model: Model, data: Data, calibration: Calibration) -> float:
    """Return the log evidence of a model [nats], up to a constant that all models of the same data share."""
    v = variance(model.misfit, data, calibration)
    fits = -0.5 * calibration.samples * log(v)
    occam = -0.5 * float(np.log1p(calibration.samples / data.count * model.information / v).sum())
    prior = -float(np.log1p(model.departures**2).sum())
    for cause in model.causes:
        prior -= calibration.cause + calibration.flexible * cause.flexible + log(cause.variants)
    return fits + occam + prior


def reachable(model: Model, data: Data, calibration: Calibration) -> float:
    """Return the largest log evidence [nats] that a model with one additional cause could have, with no remaining misfit."""
    nothing = variance(0.0, data, calibration)
    gain = 0.5 * calibration.samples * log(variance(model.misfit, data, calibration) / nothing)
    return log_evidence(model, data, calibration) + gain - calibration.cause

"""Log evidence of a model: a coarsened likelihood with a discrepancy term, an Occam factor and priors.

No model of a robot is exact, and its error repeats in every trial, so that ten thousand samples carry the information of about
ten independent ones. The likelihood is therefore raised to the power nu / N (J. W. Miller, D. B. Dunson, Robust Bayesian
inference via coarsening, JASA 114, 2019), and the variance of the model discrepancy is profiled for each model (M. C. Kennedy, A.
O'Hagan, Bayesian calibration of computer models, J. R. Stat. Soc. B 63, 2001). Channels whose discrepancies differ in size, such
as the joints of a robot, form groups g with a variance of their own::

    v_g    = S_g + (floor sigma_g)^2 + d_g
    log p  = -nu/2 sum_g ln v_g - 1/2 ln det(I + sum_g nu/N_g E_g / v_g) - sum_j ln(1 + z_j^2) - kappa |h|
             - kappa_f |flexible in h| - ln(variants)

S_g is the mean square residual beyond noise, sigma_g^2 the variance of noise and d_g that of known inaccuracies of every model,
each for one coordinate; the trial-to-trial scatter is a part of every model's S_g. E_g is the information of the residuals about
the parameters, in units of their prior, and z_j is the distance of each parameter from the centre of its prior in standard
deviations. The tails of the prior are those of a Cauchy distribution: a parameter far from the centre is penalised, not excluded.
Errors of declared numbers are parameters too, with a Gaussian prior (:mod:`hsr_pin.inference.tolerances`).
"""

from __future__ import annotations

from math import log

import numpy as np

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.model import Data, Model
from hsr_pin.trajectory import Array

#: Smallest variance, which keeps the logarithm finite if a prediction is equal to the recordings.
_NOTHING = 1e-300


def variance(misfits: Array, data: Data, calibration: Calibration) -> Array:
    """Return v (G,), the variance of one coordinate that a model leaves in each group, at least that assumed for every model."""
    return np.maximum(np.maximum(misfits, 0.0) + calibration.floor**2 * data.noise + data.discrepancy, _NOTHING)


def likelihood(misfits: Array, data: Data, calibration: Calibration) -> float:
    """Return the log likelihood [nats] of a model that leaves the misfits (G,)."""
    return -0.5 * calibration.samples * float(np.log(variance(misfits, data, calibration)).sum())


def explained(model: Model, nominal: Model, data: Data, calibration: Calibration) -> float:
    """Return the share of the gap of the nominal model that a model explains, as the mean over the groups of channels.

    A group in which the nominal model leaves no more than every model does has no gap, and hardly counts.
    """
    return float(np.mean((nominal.misfits - model.misfits) / variance(nominal.misfits, data, calibration)))


def log_evidence(model: Model, data: Data, calibration: Calibration) -> float:
    """Return the log evidence of a model [nats], up to a constant that all models of the same data share."""
    weights = calibration.samples / data.count / variance(model.misfits, data, calibration)
    information = np.eye(len(model.departures) + len(model.errors)) + np.einsum("g,gij->ij", weights, model.information)
    occam = -0.5 * float(np.linalg.slogdet(information)[1])
    prior = -float(np.log1p(model.departures**2).sum()) - 0.5 * float((model.errors**2).sum())
    for cause in model.causes:
        prior -= calibration.cause + calibration.flexible * cause.flexible + log(cause.variants)
    return likelihood(model.misfits, data, calibration) + occam + prior


def reachable(model: Model, data: Data, calibration: Calibration) -> float:
    """Return the largest log evidence [nats] that a model with one additional cause could have, with no remaining misfit."""
    gain = likelihood(0 * model.misfits, data, calibration) - likelihood(model.misfits, data, calibration)
    return log_evidence(model, data, calibration) + gain - calibration.cause

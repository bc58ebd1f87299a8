"""Identification of missing causes for any model: fits, a search over causes, their probabilities and the report.

No module in this package knows anything about soft arms or robots.

- ``calibration``: the calibrated constants of the evidence, and the cases that they were fitted to
- ``candidate``: a fitted model with its error on held-out trials
- ``decision``: the report with the smallest expected loss
- ``detection``: sizes from which on causes would have been found
- ``document``: the result of a search as JSON
- ``estimates``: parameter estimates of a fit with their intervals
- ``evidence``: the log evidence of one model
- ``fit``: bounded, robust least squares
- ``fit_pool``: proposals, quick fits and full fits of many models in parallel
- ``heldout``: leave-one-trial-out errors
- ``ladder``: how much of the gap each model explains
- ``misfit``: weighted residuals and derivatives for the optimiser of a fit
- ``model``: a fitted model reduced to its causes, its misfit and the information about its parameters
- ``posterior``: probabilities of models, sets of causes, names and kinds
- ``problem``: the interface between a model with its recordings and this package
- ``proposals``: causes to add to a model, with initial estimates for their fit
- ``resampling``: confidence intervals by resampling trials
- ``residuals``: residuals of a model, and the part of them that is not noise
- ``screening``: selection of the proposals that get a quick fit
- ``search``: the models to fit, until no other model could enter the credible set
- ``step``: one damped Gauss-Newton step
- ``tolerances``: errors of declared numbers, which are eliminated from a fit
- ``trial_parameters``: parameters of single trials, which are eliminated from a fit
- ``uncertainty``: intervals, correlations and parameters that the data do not determine
- ``verdict``: the reported verdict and its sentence
"""

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.decision import Decision, Loss, decide
from hsr_pin.inference.evidence import log_evidence
from hsr_pin.inference.model import Cause, Data, Model
from hsr_pin.inference.posterior import Posterior, posterior

__all__ = ["Calibration", "Cause", "Data", "Decision", "Loss", "Model", "Posterior", "decide", "log_evidence", "posterior"]

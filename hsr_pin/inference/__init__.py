"""Causes named for any model: fits, a search over causes, probabilities, and what to report; nothing here knows an arm.

- ``calibration``: the few numbers of the judgement, and the cases that they were fitted to
- ``candidate``: a fitted model with its error on held-out trials
- ``decision``: the report with the smallest expected loss
- ``document``: what a search found, for JSON
- ``estimates``: what a fit says about its parameters
- ``evidence``: the logarithm of the evidence for one model
- ``fit``: bounded, robust least squares
- ``fit_pool``: proposals, quick fits and full fits of many models side by side
- ``heldout``: leave one trial out
- ``ladder``: how far each model shrinks the gap
- ``misfit``: weighted residuals and derivatives for the search of a fit
- ``model``: what a fitted model says of itself: its causes, what it leaves, what its data say of its parameters
- ``own_numbers``: what belongs to a trial and not to the model
- ``posterior``: probabilities of models, sets of causes, names and kinds
- ``problem``: what a model and its recordings have to offer
- ``proposals``: what may be added to a model, and where its fit would start
- ``resampling``: intervals by drawing trials anew
- ``residuals``: how far a model is from recordings, and what of that is no noise
- ``screening``: which proposals get a quick fit
- ``search``: which models to fit, until none could enter the credible set
- ``step``: one damped Gauss-Newton step
- ``uncertainty``: intervals, correlations, what the data cannot tell
- ``verdict``: what is reported of the posterior, in words
"""

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.decision import Decision, Loss, decide
from hsr_pin.inference.evidence import log_evidence
from hsr_pin.inference.model import Cause, Data, Model
from hsr_pin.inference.posterior import Posterior, posterior

__all__ = ["Calibration", "Cause", "Data", "Decision", "Loss", "Model", "Posterior", "decide", "log_evidence", "posterior"]

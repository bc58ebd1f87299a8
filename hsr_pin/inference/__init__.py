"""Probabilities of causes from fitted models, and what to report of them; nothing here knows what was modelled.

- ``calibration``: the few numbers of the judgement, and the cases that they were fitted to
- ``decision``: the report with the smallest expected loss
- ``evidence``: the logarithm of the evidence for one model
- ``model``: what a fitted model says of itself: its causes, what it leaves, what its data say of its parameters
- ``posterior``: probabilities of models, sets of causes, names and kinds
- ``residuals``: what residuals hold beside noise
"""

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.decision import Decision, Loss, decide
from hsr_pin.inference.evidence import log_evidence
from hsr_pin.inference.model import Cause, Data, Model
from hsr_pin.inference.posterior import Posterior, posterior

__all__ = ["Calibration", "Cause", "Data", "Decision", "Loss", "Model", "Posterior", "decide", "log_evidence", "posterior"]

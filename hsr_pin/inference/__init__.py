"""Probabilities of causes from fitted models, and what to report of them; nothing here knows what was modelled.

=====================  ==================================================================================================
:mod:`.model`          what a fitted model says of itself: its causes, what it leaves, what its data say of its parameters
:mod:`.calibration`    the few numbers of the judgement, and the cases that they were fitted to
:mod:`.evidence`       the logarithm of the evidence for one model
:mod:`.posterior`      probabilities of models, sets of causes, names and kinds
:mod:`.decision`       the report with the smallest expected loss
=====================  ==================================================================================================
"""

from hsr_pin.inference.calibration import Calibration
from hsr_pin.inference.decision import Decision, Loss, decide
from hsr_pin.inference.evidence import log_evidence
from hsr_pin.inference.model import Cause, Data, Model
from hsr_pin.inference.posterior import Posterior, posterior

__all__ = ["Calibration", "Cause", "Data", "Decision", "Loss", "Model", "Posterior", "decide", "log_evidence", "posterior"]

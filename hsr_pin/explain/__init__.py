"""Explanation of the gap of a user-defined model: any function from parameter values and a trial to measured channels.

- ``change``: the difference between two sessions as a model
- ``document``: an explanation as JSON
- ``explain``: the functions ``explain`` and ``explain_change``
- ``model``: Model, Cause and Trial, and the definition of their parameters
- ``mujoco``: a MuJoCo model with parameters that are chosen by name
- ``recordings``: trials together with a model, in the form that the search needs
- ``report``: an explanation as one HTML page
- ``result``: the explanation and its display in Python
- ``where``: the gap by channel, time, trial and label
"""

from hsr_pin.explain.explain import explain, explain_change
from hsr_pin.explain.model import Cause, Model, Trial, amplitude, factor, shape
from hsr_pin.explain.result import Explanation

__all__ = ["Cause", "Explanation", "Model", "Trial", "amplitude", "explain", "explain_change", "factor", "shape"]

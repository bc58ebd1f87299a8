"""Causes named for a model of your own: any function from parameter values and a trial to what was measured.

- ``change``: by how much two sessions differ, as a model of its own
- ``document``: an explanation as JSON
- ``explain``: explain and explain_change: model, trials -> Explanation
- ``model``: Model, Cause, Trial, and the parameters that they have
- ``mujoco``: a MuJoCo model whose numbers are opened by name
- ``recordings``: trials beside a model, as the search asks for them
- ``report``: an explanation as one HTML page
- ``result``: what was found, and how it is shown in Python
- ``where``: which channel, time and label holds the gap
"""

from hsr_pin.explain.explain import explain, explain_change
from hsr_pin.explain.model import Cause, Model, Trial, amplitude, factor, shape
from hsr_pin.explain.result import Explanation

__all__ = ["Cause", "Explanation", "Model", "Trial", "amplitude", "explain", "explain_change", "factor", "shape"]

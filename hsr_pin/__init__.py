"""Simulate hybrid soft robots on Pinocchio, and find out which physics the model lacks.

`__all__` lists the names that most programs need. Each is imported on first use, so that `import hsr_pin` is fast.
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # type checkers know this name; importing `typing` takes time, in which Ctrl-C would leave a traceback
if TYPE_CHECKING:
    from hsr_pin.control.stepping import ArmSimulator
    from hsr_pin.diagnosis.change.diagnose import diagnose_change
    from hsr_pin.diagnosis.diagnose import diagnose
    from hsr_pin.identification.comparison import compare
    from hsr_pin.identification.identify import identify as fit
    from hsr_pin.recordings.read import read_dataset, sample
    from hsr_pin.recordings.write import write_dataset
    from hsr_pin.robot.pressure import PressureMap
    from hsr_pin.robot.specification import ArmSpecification
    from hsr_pin.simulation.batch import simulate_batch
    from hsr_pin.simulation.scenario import Scenario, step_scenario
    from hsr_pin.simulation.simulate import simulate
    from hsr_pin.trajectory import Dataset, Trajectory

#: Public name -> its module, and its name there if that differs (``module:name``). A new name is added here, to the imports for
#: type checkers above and to `__all__`.
_MODULES = {
    "ArmSimulator": "control.stepping",
    "ArmSpecification": "robot.specification",
    "Dataset": "trajectory",
    "PressureMap": "robot.pressure",
    "Scenario": "simulation.scenario",
    "Trajectory": "trajectory",
    "compare": "identification.comparison",
    "diagnose": "diagnosis.diagnose",
    "diagnose_change": "diagnosis.change.diagnose",
    "fit": "identification.identify:identify",
    "read_dataset": "recordings.read",
    "sample": "recordings.read",
    "simulate": "simulation.simulate",
    "simulate_batch": "simulation.batch",
    "step_scenario": "simulation.scenario",
    "write_dataset": "recordings.write",
}

__all__ = [
    "ArmSimulator",
    "ArmSpecification",
    "Dataset",
    "PressureMap",
    "Scenario",
    "Trajectory",
    "compare",
    "diagnose",
    "diagnose_change",
    "fit",
    "read_dataset",
    "sample",
    "simulate",
    "simulate_batch",
    "step_scenario",
    "write_dataset",
]


def __getattr__(name: str) -> object:
    if name == "__version__":
        from importlib.metadata import version

        return version("hsr_pin")
    if name not in _MODULES:
        raise AttributeError(f"hsr_pin has no {name!r}; it offers {', '.join(__all__)}")
    module, _, own = _MODULES[name].partition(":")
    value = globals()[name] = getattr(import_module(f"hsr_pin.{module}"), own or name)
    return value


def __dir__() -> list[str]:
    return __all__

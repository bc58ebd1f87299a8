"""Plants by other authors, who saw neither the model nor the other plants; each is one module with its own physics and laws.

- ``contact_rod``: a slender discrete elastic rod that touches walls, posts and hoses
- ``mujoco_robot``: robots of rigid links in MuJoCo, with faults at their joints
- ``mujoco_servo``: arms of servos that follow commanded angles, in MuJoCo
- ``tendon_arm``: discs on a compliant backbone, driven by two tendons and their motors
- ``valve_arm``: a beam with two pneumatic muscles, filled and vented through orifices

A module has ``CATALOGUE`` and ``OUTSIDE`` (law -> kinds that describe it), and ``record``, which writes one dataset and returns
what is in it. All follows from the seed.
"""

from importlib import import_module
from types import ModuleType

NAMES = ("contact_rod", "tendon_arm", "valve_arm")


def plant(name: str) -> ModuleType:
    """One of these plants by its name."""
    return import_module(f"{__name__}.{name}")

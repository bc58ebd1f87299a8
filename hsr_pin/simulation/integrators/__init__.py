"""One file per method; a new one is a subclass of :class:`Integrator` and a line here."""

from hsr_pin.errors import InputError
from hsr_pin.simulation.integrators.extrapolated_euler import ExtrapolatedEuler
from hsr_pin.simulation.integrators.integrator import Chain, Integrator
from hsr_pin.simulation.integrators.ros2 import Ros2

INTEGRATORS: dict[str, Integrator] = {
    "euler": ExtrapolatedEuler(1),
    "extrapolated2": ExtrapolatedEuler(2),
    "extrapolated3": ExtrapolatedEuler(3),
    "extrapolated4": ExtrapolatedEuler(4),
    "extrapolated5": ExtrapolatedEuler(5),
    "ros2": Ros2(),
}


def integrator(name: str) -> Integrator:
    """An integrator by name.

    Raises:
        InputError: listing the names there are.
    """
    if name not in INTEGRATORS:
        raise InputError("integrator", expected=", ".join(INTEGRATORS), received=repr(name))
    return INTEGRATORS[name]


__all__ = ["INTEGRATORS", "Chain", "ExtrapolatedEuler", "Integrator", "Ros2", "integrator"]

"""The exact motion of a chain, to compare with."""

from __future__ import annotations

from functools import lru_cache

from ours import Ours
from peer_scipy import ScipyChain
from problem import SAMPLE

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.integrator import Integrator
from hsr_pin.trajectory import Array

#: Fixed steps of 1.25 ms.
FINE = Integrator("extrapolated5", step=1.25e-3)


@lru_cache(maxsize=16)
def exact_motion(links: int, sample: float = SAMPLE) -> Array:
    """(T, 1, N) [rad] to 1e-4 mm: SciPy's Radau at 1e-10; above 16 links, where that takes minutes, ours at 1.25 ms.

    At 4 and at 16 links the two agree (tests/test_benchmarks.py).
    """
    arm = ArmSpecification(links=links)
    return Ours([arm], FINE, sample).run() if links > 16 else ScipyChain(arm, "Radau", 1e-10, sample).run()

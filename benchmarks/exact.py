"""Exact motion of a chain, as the reference of all comparisons."""

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
    """Return joint angles (T, 1, N) [rad] exact to 1e-4 mm: SciPy's Radau at 1e-10; above 16 links, hsr_pin at 1.25 ms.

    Radau takes minutes above 16 links. At 4 and at 16 links the two agree (tests/test_benchmarks.py).
    """
    arm = ArmSpecification(links=links)
    return Ours([arm], FINE, sample).run() if links > 16 else ScipyChain(arm, "Radau", 1e-10, sample).run()

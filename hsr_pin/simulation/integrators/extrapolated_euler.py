"""The linearly implicit Euler method, extrapolated to order p.

P. Deuflhard, E. Hairer, J. Zugck, One-step and extrapolation methods for differential-algebraic systems, Numer. Math. 51 (1987);
E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, section IV.9. The step is done with 1, 2, ..., p substeps, and
the p results are combined so that the first p - 1 terms of their common error cancel: p (p + 1) / 2 evaluations.
"""

from __future__ import annotations

from math import prod

import numpy as np

from hsr_pin.simulation.integrators.integrator import Chain, Integrator
from hsr_pin.trajectory import Array


class ExtrapolatedEuler(Integrator):
    """Order 1 (plain linearly implicit Euler) to 6.

    Stable for any step where oscillations are damped by 0.6 % of critical or more (the paper's arm: 10 % at 1 Hz, more above);
    without any damping, orders above 2 let some of them grow slowly (at most 0.5 % a step at order 4): take "ros2" there.
    """

    def __init__(self, order: int = 4) -> None:
        if not 1 <= order <= 6:
            raise ValueError(f"order: expected 1 to 6, got {order}")
        self.order = order
        weights = [prod(n / (n - m) for m in range(1, order + 1) if m != n) for n in range(1, order + 1)]
        assert abs(sum(weights) - 1) < 1e-12
        self._weights = np.array(weights)[:, None, None]

    def lengths(self, step: float) -> tuple[float, ...]:
        return tuple(step / n for n in range(1, self.order + 1))

    def advance(self, chain: Chain, q: Array, v: Array, step: float) -> tuple[Array, Array]:
        q_all, v_all, _ = chain.work[0]
        q_all[:], v_all[:] = q, v
        for substep, (q_n, v_n, d) in enumerate(chain.work):  # the step in n parts is done after n substeps
            change = chain.solve(substep, substep)
            change *= d
            v_n += change
            np.multiply(d, v_n, change)
            q_n += change
        return np.add.reduce(self._weights * q_all), np.add.reduce(self._weights * v_all)

"""ROS2, a two-stage W-method of order 2, L-stable where its Jacobian is exact.

J. G. Verwer, E. J. Spee, J. G. Blom, W. Hundsdorfer, A second-order Rosenbrock method applied to photochemical dispersion
problems, SIAM J. Sci. Comput. 20 (1999), Eq. (2.8). A W-method keeps its order with any approximation of the Jacobian, here the
springs and dampers alone. Stage 2 solves with M at its own pose instead of the first's: they differ by O(h), which leaves
order 2.
"""

from __future__ import annotations

from math import sqrt

from hsr_pin.simulation.integrators.integrator import Chain, Integrator
from hsr_pin.trajectory import Array

GAMMA = 1 - 1 / sqrt(2)


class Ros2(Integrator):
    """Two evaluations a step: the cheapest for fits, where many runs at moderate accuracy are wanted."""

    order = 2

    def lengths(self, step: float) -> tuple[float, ...]:
        return (GAMMA * step,)

    def advance(self, chain: Chain, q: Array, v: Array, step: float) -> tuple[Array, Array]:
        length = GAMMA * step
        pull = length * chain.stiffness
        armature = length * chain.damping + length * pull
        v_1 = chain.solve(0, q, v, 0.0)  # k_1 = (q_1, v_1), slopes of q and v
        q_1 = v + length * v_1
        q_end, v_end = q + step * q_1, v + step * v_1
        w = chain.solve(0, q_end, v_end, step, 2 * (pull * q_1 + armature * v_1))
        v_2 = w - 2 * v_1
        q_2 = v_end - 2 * q_1 + length * v_2
        return q + step * (1.5 * q_1 + 0.5 * q_2), v + step * (1.5 * v_1 + 0.5 * v_2)

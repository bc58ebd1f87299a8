"""What all solve: arms hang at rest, and a torque of 1 N m at every joint bends them for 1 s."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Protocol

import numpy as np

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

TORQUE = 1.0  # [N m]
DURATION = 1.0  # [s]
#: Joint angles are read, and the tip is compared, every so many seconds, unless a line says otherwise.
SAMPLE = 0.02


class Solver(Protocol):
    """One way to solve the problem, set up and ready to run again and again."""

    setting: str

    def run(self) -> Array:
        """Joint angles (T, B, N) [rad] of B arms at its sample times."""


def times(sample: float) -> Array:
    """(T,) [s] from 0 to the end."""
    return sample * np.arange(round(DURATION / sample) + 1, dtype=float)


def tip_error(arms: Sequence[ArmSpecification], angles: Array, exact: Array) -> float:
    """Largest distance [mm] between the tips of two sets of joint angles (T, B, N); infinite where a run diverged."""
    reach = np.array([arm.link_length for arm in arms])
    ours, theirs = (reach * np.exp(1j * q.cumsum(axis=2)).sum(axis=2) for q in (angles, exact))
    error = 1e3 * np.abs(ours - theirs).max()
    return float(error) if np.isfinite(error) else np.inf


@lru_cache(maxsize=16)
def exact_motion(links: int, sample: float = SAMPLE) -> Array:
    """(T, 1, N) [rad] to 1e-4 mm: SciPy's Radau at 1e-10; above 16 links, where that takes minutes, ours at 1.25 ms.

    At 4 and at 16 links the two agree (tests/test_benchmarks.py).
    """
    arm = ArmSpecification(links=links)
    if links > 16:
        from ours import Ours

        return Ours([arm], "extrapolated5", round(sample / 1.25e-3), sample).run()
    from peer_scipy import ScipyChain

    return ScipyChain(arm, "Radau", 1e-10, sample).run()

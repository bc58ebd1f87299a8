"""The benchmark problem: arms hang at rest, and a torque of 1 N m at every joint bends them for 1 s."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

TORQUE = 1.0  # [N m]
DURATION = 1.0  # [s]
#: Joint angles are read, and the tip is compared, every so many seconds, unless a line says otherwise.
SAMPLE = 0.02


class Solver(Protocol):
    """One method to solve the problem, set up and ready to run repeatedly."""

    setting: str

    def run(self) -> Array:
        """Return the joint angles (T, B, N) [rad] of B arms at the sample times."""


def times(sample: float) -> Array:
    """Return the sample times (T,) [s] from 0 to the end."""
    return sample * np.arange(round(DURATION / sample) + 1, dtype=float)


def tip_error(arms: Sequence[ArmSpecification], angles: Array, exact: Array) -> float:
    """Return the largest distance [mm] between the tips of two sets of joint angles (T, B, N); infinite if a run diverged."""
    reach = np.array([arm.link_length for arm in arms])
    ours, theirs = (reach * np.exp(1j * q.cumsum(axis=2)).sum(axis=2) for q in (angles, exact))
    error = 1e3 * np.abs(ours - theirs).max()
    return float(error) if np.isfinite(error) else np.inf

"""Summaries of models without a robot: a few laws with given misfits."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hsr_pin.inference import Calibration, Cause, Data, Model

CALIBRATION = Calibration(samples=14.0, cause=1.0, flexible=3.0, floor=0.15, share=0.02)
DATA = Data.of_one_group(noise=1.0, count=4000)

FRICTION = Cause("friction", "friction")
LAG = Cause("lag", "actuation_time")
MASS = Cause("mass", "mass_gravity")
CURVE = Cause("curve", "elastic", flexible=True)


def model(causes: Sequence[Cause], misfit: float, *, departures: Sequence[float] = (), information: float = 1e4) -> Model:
    """Return a fitted model with two parameters of its own and one for each cause, all of them well determined."""
    count = 2 + len(causes)
    away = np.zeros(count)
    away[: len(departures)] = departures
    return Model(tuple(causes), np.array([misfit]), information * np.eye(count)[None], away)


def noise(size: float, *, trials: int = 4, samples: int = 5000, seed: int = 0) -> list[np.ndarray]:
    """Return white residuals of two markers in each trial."""
    generator = np.random.default_rng(seed)
    return [size * generator.standard_normal((samples, 2, 3)) for _ in range(trials)]


def trials_of(*sizes: float, samples: int = 40) -> list[np.ndarray]:
    """Return residuals of one marker, constant in each trial, with these distances [m]."""
    return [np.tile([size, 0.0, 0.0], (samples, 1, 1)) for size in sizes]

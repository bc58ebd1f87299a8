"""Recording artefacts of real hardware: coloured noise, camera drift, outliers, gaps, manual releases, scattered rest poses."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from .arm import Array
from .laws.law import Law, random_of_trial, random_seed, strength
from .nuisance import Nuisance
from .program import RATE, Program, Trial

#: Smallest and largest noise for each axis [m].
MIN_NOISE, MAX_NOISE = 2e-4, 1.2e-3
#: Length of the arm [m]: a bending of the whole arm by b moves its tip by about b times half of the length.
LENGTH = 0.24


@dataclass(frozen=True)
class RestingPlace(Law, name="resting_place"):
    """Scatter of the rest pose from trial to trial, constant within a trial.

    Real arms show it if they are set up by hand or have a little friction. The law is a small moment along the arm, another one
    in each trial.

    spread: largest bending of the whole arm [rad]; seed: seed of the moments, combined with the session time.
    """

    spread: float = strength(0.01, limit=0.1)
    seed: int = random_seed()

    def command(self, tau: Array, t: Array, keq: float, clock: float) -> Array:
        own = random_of_trial(self.seed, clock).uniform(-1, 1)
        return tau + self.spread * own * keq


@dataclass(frozen=True)
class Artefacts:
    """Recording artefacts of one recording of one arm.

    Attributes:
        colour: correlation time of the noise [s]; 0: white noise.
        drift: amplitude of the slow drift of the cameras, equal for all markers, for each axis [m].
        outliers: share of a marker's samples that are outliers.
        gaps: share of a marker's samples that are missing.
        rest: largest deviation of the tip's rest position between trials [m].
        seed: seed of all artefacts.
    """

    colour: float = 0.0
    drift: float = 0.0
    outliers: float = 0.0
    gaps: float = 0.0
    rest: float = 0.0
    seed: int = 0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Artefacts:
        """Draw artefacts: white noise in half of the cases, up to 1 mm drift, 1 % outliers, 4 % gaps, 3 mm rest deviation."""
        colour = float(np.exp(rng.uniform(np.log(0.02), np.log(0.15)))) if rng.random() < 0.5 else 0.0
        most = (1e-3, 0.01, 0.04, 2.7e-3)  # for an upright arm, gravity increases 2.7 mm to 3 mm
        drift, outliers, gaps, rest = (float(rng.uniform(0, top) * (rng.random() < 0.8)) for top in most)
        return cls(colour, drift, outliers, gaps, rest, int(rng.integers(1 << 31)))

    def law(self) -> RestingPlace:
        """Return the law that changes the rest pose in every trial."""
        return RestingPlace(2 * self.rest / LENGTH, self.seed)

    def with_release_errors(self, program: Program) -> Program:
        """Return the program with manual releases: each has its own initial pose, duration and error of the noted instant."""
        return replace(program, trials=tuple(self._disturbed(trial) if trial.release else trial for trial in program.trials))

    def recorded(self, points: Array, noise: float, clock: float, rng: np.random.Generator) -> Array:
        """Return points (T, M, 3) [m] of a trial that begins at `clock` [s] with noise, drift, outliers and gaps (NaN)."""
        t = clock + np.arange(points.shape[0]) / RATE
        seen = points + noise * _coloured(rng, points.shape, self.colour) + self._drift(t)[:, None, :]
        for marker in np.moveaxis(seen, 1, 0):
            _corrupt(marker, self.outliers, self.gaps, rng)
        return seen

    def describe(self) -> dict[str, Any]:
        """Return the artefacts for an answer file."""
        return asdict(self)

    def _disturbed(self, trial: Trial) -> Trial:
        rng = random_of_trial(self.seed, trial.clock)
        at, side = float(rng.uniform(0.55, 1.0)), float(rng.choice([-1.0, 1.0]))
        return replace(
            trial,
            hold_at=at,
            hold_force=side * trial.keq * float(rng.uniform(0.6, 1.2)) / (LENGTH * at),
            hold_torque=side * trial.keq * float(rng.uniform(-0.2, 0.4)),
            release_duration=float(rng.uniform(0.0, 0.06)),
            start_error=round(float(rng.uniform(-0.02, 0.04)), 3),
        )

    def _drift(self, t: Array) -> Array:
        """Return the drift (T, 3) [m]: two slow waves along each axis, in session time."""
        rng = np.random.default_rng([self.seed, 1])
        period, phase = rng.uniform(60, 400, (2, 1, 3)), rng.uniform(0, 2 * np.pi, (2, 1, 3))
        waves: Array = np.sin(2 * np.pi * t[:, None] / period + phase).mean(axis=0)
        return self.drift * waves


def messy_nuisance(rng: np.random.Generator) -> Nuisance:
    """Return drawn nuisances with 0.2 to 1.2 mm of noise, and a standard deviation of 0.2 mm of the marker places."""
    noise = float(np.exp(rng.uniform(np.log(MIN_NOISE), np.log(MAX_NOISE))))
    return replace(Nuisance.draw(rng), noise=noise, placement=2e-4)


def _coloured(rng: np.random.Generator, shape: tuple[int, ...], time: float) -> Array:
    """Return first-order coloured noise of unit variance along the first axis.

    A. Gelb, Applied Optimal Estimation, 1974, ch. 3.
    """
    white = rng.standard_normal(shape)
    if time <= 0:
        return white
    from scipy.signal import lfilter

    keep = np.exp(-1 / (RATE * time))
    out, _ = lfilter([np.sqrt(1 - keep**2)], [1.0, -keep], white, axis=0, zi=keep * rng.standard_normal((1, *shape[1:])))
    return np.asarray(out)


def _corrupt(marker: Array, outliers: float, gaps: float, rng: np.random.Generator) -> None:
    """Put outliers and gaps into the points of one marker (T, 3), in place; the first 0.1 s remain unchanged."""
    size, first = len(marker), RATE // 10
    for _ in range(rng.poisson(outliers * size / 1.5)):  # a reflection is mistaken for the marker for one or two samples
        start = int(rng.integers(first, size))
        way = rng.standard_normal(3)
        marker[start : start + int(rng.integers(1, 3))] += rng.uniform(0.01, 0.08) * way / np.linalg.norm(way)
    for _ in range(rng.poisson(gaps * size / 12)):
        start = int(rng.integers(first, size))
        marker[start : start + int(rng.integers(2, 23))] = np.nan

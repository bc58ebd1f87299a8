"""What goes wrong where hardware is recorded: coloured noise, drifting cameras, outliers, gaps, hands, places of rest."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from .arm import Array
from .laws.session import RestingPlace
from .nuisance import Nuisance
from .program import RATE, Program, Trial

#: Of the noise per axis [m].
QUIETEST, LOUDEST = 2e-4, 1.2e-3
#: Length of the arm [m]: bending of the whole arm by b moves its tip by about half of that times b.
LENGTH = 0.24


@dataclass(frozen=True)
class Mess:
    """Of one recording of one arm.

    Attributes:
        colour: time over which the noise is correlated [s]; 0: white.
        drift: of the cameras, slow and the same for all markers, each axis [m].
        outliers, gaps: shares of a marker's samples that are elsewhere, and that are missing.
        rest: how far the tip's place of rest differs between trials, at most [m].
        seed: of all of it.
    """

    colour: float = 0.0
    drift: float = 0.0
    outliers: float = 0.0
    gaps: float = 0.0
    rest: float = 0.0
    seed: int = 0

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Mess:
        """Half of the cases white; up to 1 mm of drift, 1 % of outliers, 4 % of gaps, 3 mm between places of rest."""
        colour = float(np.exp(rng.uniform(np.log(0.02), np.log(0.15)))) if rng.random() < 0.5 else 0.0
        most = (1e-3, 0.01, 0.04, 2.7e-3)  # upright, gravity makes 3 mm of 2.7
        drift, outliers, gaps, rest = (float(rng.uniform(0, top) * (rng.random() < 0.8)) for top in most)
        return cls(colour, drift, outliers, gaps, rest, int(rng.integers(1 << 31)))

    def law(self) -> RestingPlace:
        """What makes every trial rest elsewhere."""
        return RestingPlace(2 * self.rest / LENGTH, self.seed)

    def staged(self, program: Program) -> Program:
        """The program as hands do it: each release from a pose of its own, let go in some time, at about the instant noted."""
        return replace(program, trials=tuple(self._by_hand(trial) if trial.release else trial for trial in program.trials))

    def tracked(self, points: Array, noise: float, clock: float, rng: np.random.Generator) -> Array:
        """Points (T, M, 3) [m] of a trial that begins at `clock` [s] as they are recorded, with gaps as nan."""
        t = clock + np.arange(points.shape[0]) / RATE
        seen = points + noise * _coloured(rng, points.shape, self.colour) + self._drift(t)[:, None, :]
        for marker in np.moveaxis(seen, 1, 0):
            _spoil(marker, self.outliers, self.gaps, rng)
        return seen

    def describe(self) -> dict[str, Any]:
        """For an answer file."""
        return asdict(self)

    def _by_hand(self, trial: Trial) -> Trial:
        rng = np.random.default_rng([self.seed, round(100 * trial.clock)])
        at, side = float(rng.uniform(0.55, 1.0)), float(rng.choice([-1.0, 1.0]))
        return replace(
            trial,
            hold_at=at,
            hold_force=side * trial.keq * float(rng.uniform(0.6, 1.2)) / (LENGTH * at),
            hold_torque=side * trial.keq * float(rng.uniform(-0.2, 0.4)),
            fade=float(rng.uniform(0.0, 0.06)),
            late=round(float(rng.uniform(-0.02, 0.04)), 3),
        )

    def _drift(self, t: Array) -> Array:
        """(T, 3) [m]: two slow waves along each axis, on the session's clock."""
        rng = np.random.default_rng([self.seed, 1])
        period, phase = rng.uniform(60, 400, (2, 1, 3)), rng.uniform(0, 2 * np.pi, (2, 1, 3))
        waves: Array = np.sin(2 * np.pi * t[:, None] / period + phase).mean(axis=0)
        return self.drift * waves


def messy_nuisance(rng: np.random.Generator) -> Nuisance:
    """Wrong stiffness and damping as ever, 0.2 to 1.2 mm of noise, markers placed within 0.2 mm."""
    noise = float(np.exp(rng.uniform(np.log(QUIETEST), np.log(LOUDEST))))
    return replace(Nuisance.draw(rng), noise=noise, placement=2e-4)


def _coloured(rng: np.random.Generator, shape: tuple[int, ...], time: float) -> Array:
    """Of unit variance, a first-order process along the first axis (A. Gelb, Applied Optimal Estimation, 1974, ch. 3)."""
    white = rng.standard_normal(shape)
    if time <= 0:
        return white
    from scipy.signal import lfilter

    keep = np.exp(-1 / (RATE * time))
    out, _ = lfilter([np.sqrt(1 - keep**2)], [1.0, -keep], white, axis=0, zi=keep * rng.standard_normal((1, *shape[1:])))
    return np.asarray(out)


def _spoil(marker: Array, outliers: float, gaps: float, rng: np.random.Generator) -> None:
    """Put outliers and gaps into one marker's points (T, 3), in place; the first 0.1 s are left alone."""
    size, first = len(marker), RATE // 10
    for _ in range(rng.poisson(outliers * size / 1.5)):  # for one or two samples the marker is taken for a reflection
        start = int(rng.integers(first, size))
        way = rng.standard_normal(3)
        marker[start : start + int(rng.integers(1, 3))] += rng.uniform(0.01, 0.08) * way / np.linalg.norm(way)
    for _ in range(rng.poisson(gaps * size / 12)):
        start = int(rng.integers(first, size))
        marker[start : start + int(rng.integers(2, 23))] = np.nan

"""Scaling of an effect to a given marker gap."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from hsr_pin.errors import InputError

from .arm import Array
from .chain import ChainPlant
from .laws.law import Law
from .nuisance import Nuisance, noise_floor
from .plant import Plant
from .program import Program

#: Marker gaps of the named sizes, in noise floors.
SIZES: dict[str, float] = {"barely": 2.0, "medium": 6.0, "large": 15.0}
#: Relative tolerance of a gap.
TOLERANCE = 0.1


def target(size: str, noise: float, axes: int = 2) -> float:
    """Return the marker gap [mm] of a named size of `SIZES`, for markers with this noise for each axis [m]."""
    if size not in SIZES:
        raise InputError("size", expected=" or ".join(SIZES), received=size)
    return 1e3 * SIZES[size] * noise_floor(noise, axes)


@dataclass(frozen=True)
class GapSimulator:
    """Simulator of the marker gap that laws cause in a program, on a coarse and fast plant.

    Gaps are RMS distances [mm] over all trials, samples and markers except the one at the base, from the arm with `present_laws`.
    """

    program: Program
    nuisance: Nuisance = field(default_factory=Nuisance)
    plant: Plant = field(default_factory=lambda: ChainPlant(elements=12, step=5e-4))
    present_laws: tuple[Law, ...] = ()

    def gap(self, *laws: Law) -> float:
        """Return the gap between the arm with and without the laws [mm], at the same stiffness and damping."""
        return _rms(self._change(laws))

    def refitted_gap(self, *laws: Law) -> float:
        """Return the gap that remains after the best change of stiffness and damping [mm], which is what a diagnosis can use.

        It is estimated by linear least squares, with differences of 2 % in stiffness and in damping.
        """
        return self._refitted(self._change(laws))

    def refitted_step(self, before: Law, after: Law) -> float:
        """Return the refitted gap of a change from one law to another [mm]."""
        return self._refitted(self._change((after,)) - self._change((before,)))

    def _refitted(self, change: Array) -> float:
        best = np.linalg.lstsq(self._slopes, change, rcond=None)[0]
        return _rms(change - self._slopes @ best)

    def _change(self, laws: tuple[Law, ...]) -> Array:
        return self._watch((*self.present_laws, *laws)) - self._nominal

    @cached_property
    def _nominal(self) -> Array:
        return self._watch(self.present_laws)

    @cached_property
    def _slopes(self) -> Array:
        stiffer, damped = self._watch(self.present_laws, k=1.02), self._watch(self.present_laws, c=1.02)
        return np.stack([stiffer - self._nominal, damped - self._nominal], axis=1)

    def _watch(self, laws: tuple[Law, ...], k: float = 1.0, c: float = 1.0) -> Array:
        nuisance = replace(self.nuisance, k=self.nuisance.k * k, c=self.nuisance.c * c)
        points = self.plant.watch(self.program, laws, nuisance)
        return np.concatenate([p[:, 1:].ravel() for p in points])


@dataclass(frozen=True)
class Scaled:
    """A law with the strength that was asked for.

    Attributes:
        law: the law.
        gap: marker gap that it causes [mm].
        reached: whether this is the wanted gap; if not, the law has its largest allowed strength.
    """

    law: Law
    gap: float
    reached: bool


def scale_to_gap(
    law: Law,
    millimetres: float,
    gap_simulator: GapSimulator,
    refit: bool = False,
    *,
    tolerance: float = TOLERANCE,
    steps: int = 14,
) -> Scaled:
    """Scale a law so that its marker gap has a given size [mm].

    The gap is at the same stiffness and damping or, with `refit`, after the best change of them. The search takes secant steps on
    the logarithms inside the known bracket. It ends within the tolerance or at the law's limit.
    """
    measure = gap_simulator.refitted_gap if refit else gap_simulator.gap
    tried: list[tuple[float, float]] = []  # factor on the strength, gap [mm]
    factor = 1.0
    for _ in range(steps):
        scaled = law.scaled(factor)
        tried.append((factor, measure(scaled)))
        if abs(tried[-1][1] / millimetres - 1) < tolerance:
            return Scaled(scaled, tried[-1][1], True)
        factor = _next_factor(tried, millimetres)
        if law.scaled(factor) == scaled:
            break
    return Scaled(scaled, tried[-1][1], False)


def _next_factor(tried: list[tuple[float, float]], millimetres: float) -> float:
    """Return the factor at which gap ~ factor^p through the last two trials meets the wanted gap, inside the bracket."""
    (f, g), power = tried[-1], 1.0
    if len(tried) > 1 and min(g, tried[-2][1]) > 0:
        power = float(np.clip(np.log(g / tried[-2][1]) / np.log(f / tried[-2][0]), 0.3, 6.0))
    guess = f * float(np.clip((millimetres / max(g, 1e-6)) ** (1 / power), 1 / 8, 8.0))
    weak = max((f for f, g in tried if g < millimetres), default=0.0)
    strong = min((f for f, g in tried if g > millimetres), default=np.inf)
    if weak < guess < strong:
        return guess
    return float(np.sqrt(weak * strong)) if 0 < weak < strong < np.inf else guess


def _rms(change: Array) -> float:
    """Return the RMS length [mm] of vectors (3 k,) [m]."""
    return 1e3 * float(np.sqrt(change @ change / (change.size / 3)))

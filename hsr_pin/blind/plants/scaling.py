"""Gives an effect the strength that moves the markers by so many millimetres."""

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

#: Gaps of the named sizes, in noise floors.
SIZES: dict[str, float] = {"barely": 2.0, "medium": 6.0, "large": 15.0}
#: Of a gap, over the one wanted.
TOLERANCE = 0.1


def target(size: str, noise: float, axes: int = 2) -> float:
    """Gap [mm] of a size of `SIZES`, for markers with this noise per axis [m]."""
    if size not in SIZES:
        raise InputError("size", expected=" or ".join(SIZES), received=size)
    return 1e3 * SIZES[size] * noise_floor(noise, axes)


@dataclass(frozen=True)
class Yardstick:
    """Measures by how far laws move the markers in a program, on a plant that is coarse but quick.

    Gaps are RMS distances over all trials, samples and markers but the one at the base [mm], from the arm with
    the laws that are there `already`.
    """

    program: Program
    nuisance: Nuisance = field(default_factory=Nuisance)
    plant: Plant = field(default_factory=lambda: ChainPlant(elements=12, step=5e-4))
    already: tuple[Law, ...] = ()

    def gap(self, *laws: Law) -> float:
        """With the laws against without them, at the same K and C [mm]."""
        return _rms(self._change(laws))

    def refitted_gap(self, *laws: Law) -> float:
        """What is left of the gap after the best change of K and C [mm]: what a diagnosis has to go by.

        Estimated by linear least squares on differences of 2 % in K and in C.
        """
        return self._refitted(self._change(laws))

    def refitted_step(self, before: Law, after: Law) -> float:
        """The same, from one law to another [mm]."""
        return self._refitted(self._change((after,)) - self._change((before,)))

    def _refitted(self, change: Array) -> float:
        best = np.linalg.lstsq(self._slopes, change, rcond=None)[0]
        return _rms(change - self._slopes @ best)

    def _change(self, laws: tuple[Law, ...]) -> Array:
        return self._watch((*self.already, *laws)) - self._nominal

    @cached_property
    def _nominal(self) -> Array:
        return self._watch(self.already)

    @cached_property
    def _slopes(self) -> Array:
        softer, looser = self._watch(self.already, k=1.02), self._watch(self.already, c=1.02)
        return np.stack([softer - self._nominal, looser - self._nominal], axis=1)

    def _watch(self, laws: tuple[Law, ...], k: float = 1.0, c: float = 1.0) -> Array:
        nuisance = replace(self.nuisance, k=self.nuisance.k * k, c=self.nuisance.c * c)
        points = self.plant.watch(self.program, laws, nuisance)
        return np.concatenate([p[:, 1:].ravel() for p in points])


@dataclass(frozen=True)
class Scaled:
    """A law at the strength asked for.

    Attributes:
        law: the law. gap: marker distance that it makes [mm].
        reached: whether that is the distance asked for; if not, the law is as strong as it may be.
    """

    law: Law
    gap: float
    reached: bool


def scale_to_gap(
    law: Law, millimetres: float, yardstick: Yardstick, refit: bool = False, *, tolerance: float = TOLERANCE, steps: int = 14
) -> Scaled:
    """Scale a law so that the markers move by this much [mm].

    That is at the same K and C or, with `refit`, beyond the best change of them. Secant steps on the
    logarithms, kept inside of what is known to be too weak and too strong; ends within the tolerance or at the
    law's limit.
    """
    measure = yardstick.refitted_gap if refit else yardstick.gap
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
    """Where gap ~ factor^p through the last two trials meets the gap wanted, inside the bracket."""
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
    """RMS length [mm] of vectors (3 k,) [m]."""
    return 1e3 * float(np.sqrt(change @ change / (change.size / 3)))

"""Whether what is missing comes and goes by a clock of its own: a supply that pulses, a muscle that breathes.

A wave of one frequency and one shape (three harmonics) is sought in the torque that the model lacks, the same in every run but
for the moment at which that began, which nobody recorded. It is learnt from all runs but one and judged on that one, where only
the moment is its own. A torque that is added has one size in all runs, a stiffness that pulses goes with the bending. Releases
are left out: they swing by the arm's own frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.residual_torque import ResidualTorque
from hsr_pin.identification.experiment import Experiment
from hsr_pin.trajectory import Array

#: It pulses if a wave foretells this share of the squared torque, and is of the kind that leaves at most this share of what the
#: other leaves.
MOST, LESS = 0.5, 0.85
#: [Hz] sought; apart by this share of a period in the longest run; periods that a run has to hold.
_SLOWEST, _FASTEST, _APART, _PERIODS = 0.5, 8.0, 0.2, 1.2
#: [s] of a run that are looked at, at samples that far apart at least; samples left out at both ends, where derivatives are poor.
_LONGEST, _STEP, _EDGE = 10.0, 0.02, 10
#: Where one course in time, of any size in each run, takes this share of what the wave does, it may be an event in each of them.
_EVENT = 0.9
#: Harmonics of a wave; moments at which it may begin; how often these and its shape are fitted in turn; frequencies for which
#: that is done, and runs that it takes.
_HARMONICS, _MOMENTS, _ROUNDS, _FINALISTS, _RUNS = 3, 48, 4, 6, 3


@dataclass(frozen=True)
class Pulsation:
    """A wave in what is missing.

    Attributes:
        frequency: [Hz].
        added: share of the squared torque that it foretells as a torque that is added, in runs from which it was not learnt.
        elastic: likewise, as a stiffness that pulses.
    """

    frequency: float
    added: float
    elastic: float

    @property
    def kind(self) -> str:
        """Kind of physics that it tells; empty if none."""
        if max(self.added, self.elastic) < MOST:
            return ""
        if 1 - self.elastic <= LESS * (1 - self.added):
            return "elastic"
        return "actuation_map" if 1 - self.added <= LESS * (1 - self.elastic) else ""

    @property
    def sentence(self) -> str:
        """As a person would say it; empty where nothing pulses."""
        if not self.kind:
            return ""
        what, share = ("stiffness", self.elastic) if self.kind == "elastic" else ("torque", self.added)
        return (
            f"a {what} pulses at {self.frequency:.2g} Hz, whatever is commanded: one wave foretells {100 * share:.0f} % of what "
            "is missing in trials from which it was not learnt"
        )


def pulsation(experiment: Experiment, torques: Sequence[ResidualTorque]) -> Pulsation | None:
    """Of the torque that a fitted model lacks; None in space, and where driven trials are too few or too short."""
    driven = [k for k, run in enumerate(experiment.runs) if run.span > 0]
    if len(driven) < _RUNS or len(experiment.directions) > 1 or len(torques) < len(experiment.runs):
        return None
    step = experiment.runs[driven[0]].step
    every = max(1, round(_STEP / step))
    kept = slice(_EDGE, _EDGE + round(_LONGEST / step), every)
    seen = [(torques[k].torque[:-_EDGE][kept].mean(axis=1), torques[k].bending[:-_EDGE][kept]) for k in driven]
    return wave(seen, step * every)


def wave(runs: Sequence[tuple[Array, Array]], step: float) -> Pulsation | None:
    """In what is missing (T,) [N m] of each run, beside its bending (T,) [rad], sampled every ``step`` [s]."""
    longest = max(len(missing) for missing, _ in runs) * step
    found = {}
    for kind in ("added", "elastic"):
        sized = [_Run(missing, bending if kind == "elastic" else np.ones(len(bending)), step) for missing, bending in runs]
        whole = sum(run.square for run in sized)
        shares = {}
        for frequency in np.arange(_SLOWEST, _FASTEST, _APART / longest):
            long = [run for run in sized if run.lasts * frequency >= _PERIODS]
            if len(long) >= _RUNS:
                shares[float(frequency)] = sum(run.taken(frequency) for run in long) / max(whole, 1e-300), long
        ranked = sorted(shares, key=lambda frequency: -shares[frequency][0])[:_FINALISTS]
        found[kind] = max(((_foretold(shares[f][1], f) / max(whole, 1e-300), f) for f in ranked), default=(0.0, 0.0))
    if not max(found.values())[1]:
        return None
    return Pulsation(max(found.values())[1], found["added"][0], found["elastic"][0])


class _Run:
    """What is missing (T,), and how large a wave of unit size is there (T,)."""

    def __init__(self, missing: Array, size: Array, step: float) -> None:
        self.missing, self._size, self._step = missing - missing.mean(), size, step
        self.square, self.lasts = float(self.missing @ self.missing), len(missing) * step

    def basis(self, frequency: float) -> Array:
        """(T, H) complex: the harmonics, from the run's first sample on."""
        phase = 2 * np.pi * frequency * self._step * np.arange(len(self.missing))
        waves = self._size[:, None] * np.exp(1j * phase[:, None] * np.arange(1, _HARMONICS + 1))
        return np.asarray(waves - waves.mean(axis=0))

    def taken(self, frequency: float) -> float:
        """What a wave of its own would take away, of any shape."""
        normal, product = _equations(self.basis(frequency), self.missing)
        return float(product @ _solved(normal, product))


def _foretold(runs: Sequence[_Run], frequency: float) -> float:
    """What a wave learnt from the other runs takes away from each, in all.

    Where it may as well be an event that comes once in each, at the same time, what the first halves of the runs foretell of the
    second halves, over all; nothing if these are too short.
    """
    bases = [run.basis(frequency) for run in runs]
    turns = np.exp(2j * np.pi * np.arange(_MOMENTS)[:, None] / _MOMENTS * np.arange(1, _HARMONICS + 1))

    def left(k: int, shape: Array) -> tuple[float, int]:
        """What a wave of this shape leaves of a run, and the moment at which it leaves least."""
        waves = (bases[k] @ (turns * (shape[:_HARMONICS] - 1j * shape[_HARMONICS:])).T).real
        squares = ((runs[k].missing[:, None] - waves) ** 2).sum(axis=0)
        return float(squares.min()), int(np.argmin(squares))

    def shape(some: Sequence[int], moments: Sequence[int]) -> Array:
        """(2 H,) cosines and sines of the wave that leaves least of some runs."""
        parts = [_equations(bases[k] * turns[moments[k]], runs[k].missing) for k in some]
        return _solved(np.sum([normal for normal, _ in parts], axis=0), np.sum([product for _, product in parts], axis=0))

    every, moments = list(range(len(runs))), [0] * len(runs)
    learnt = min((shape([k], moments) for k in every), key=lambda one: sum(left(k, one)[0] for k in every))
    for _ in range(_ROUNDS):
        moments = [left(k, learnt)[1] for k in every]
        learnt = shape(every, moments)
    moments = [left(k, learnt)[1] for k in every]
    taken = sum(runs[k].square - left(k, shape([other for other in every if other != k], moments))[0] for k in every)
    whole = sum(run.square for run in runs)
    if taken > _at_once(runs) * whole / _EVENT:
        return taken
    if min(run.lasts for run in runs) * frequency < 2 * _PERIODS:
        return 0.0
    return min(taken, whole * _repeated(runs, [basis * turns[m] for basis, m in zip(bases, moments, strict=True)]))


def _at_once(runs: Sequence[_Run]) -> float:
    """Share of what is missing, as long as all runs last, that one course in time explains, of another size in each."""
    length = min(len(run.missing) for run in runs)
    strength = np.linalg.svd(np.array([run.missing[:length] for run in runs]), compute_uv=False) ** 2
    return float(strength[0] / max(strength.sum(), 1e-300))


def _repeated(runs: Sequence[_Run], bases: Sequence[Array]) -> float:
    """Share of the second halves that a wave learnt from the first halves foretells."""
    halves = [len(run.missing) // 2 for run in runs]
    parts = [_equations(basis[:h], run.missing[:h]) for run, basis, h in zip(runs, bases, halves, strict=True)]
    learnt = _solved(np.sum([normal for normal, _ in parts], axis=0), np.sum([product for _, product in parts], axis=0))
    waves = [basis[h:] @ (learnt[:_HARMONICS] - 1j * learnt[_HARMONICS:]) for basis, h in zip(bases, halves, strict=True)]
    seen = [run.missing[h:] for run, h in zip(runs, halves, strict=True)]
    left = sum(float(((one - wave.real) ** 2).sum()) for one, wave in zip(seen, waves, strict=True))
    return 1 - left / max(sum(float(one @ one) for one in seen), 1e-300)


def _equations(basis: Array, missing: Array) -> tuple[Array, Array]:
    """Normal matrix (2 H, 2 H) and right-hand side (2 H,) for a sum of cosines and sines."""
    rows = np.concatenate([basis.real, basis.imag], axis=1)
    return rows.T @ rows, rows.T @ missing


def _solved(normal: Array, product: Array) -> Array:
    return np.asarray(np.linalg.solve(normal + 1e-6 * np.trace(normal) * np.eye(len(normal)) + 1e-300, product))

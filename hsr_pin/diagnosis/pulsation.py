"""Periodic disturbances that do not follow the command, such as a pulsating supply or a pulsating stiffness.

A wave of one frequency and one shape (three harmonics) is fitted to the torque that the model lacks, with the same shape in every
run and an unknown phase in each. It is learned from all runs but one and tested on that run, where only the phase is fitted. An
added torque has the same amplitude in all runs; the torque of a pulsating stiffness is proportional to the bending. Releases are
left out, because they oscillate at the arm's natural frequency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.residual_torque import ResidualTorque
from hsr_pin.identification.experiment import Experiment
from hsr_pin.trajectory import Array

#: A wave is significant if it predicts the first share of the squared torque. Its kind is decided if that kind leaves at most the
#: second share of what the other kind leaves.
MOST, LESS = 0.5, 0.85
#: Range of frequencies [Hz], their spacing in periods of the longest run, and the least number of periods in a run.
_SLOWEST, _FASTEST, _APART, _PERIODS = 0.5, 8.0, 0.2, 1.2
#: Duration of a run that is used [s], least sampling interval [s], and number of samples left out at both ends, where derivatives
#: are inaccurate.
_LONGEST, _STEP, _EDGE = 10.0, 0.02, 10
#: If a common time course with any amplitude explains this share of what the wave explains, it may be a single event in each run.
_EVENT = 0.9
#: Numbers of harmonics, of phases that are tried, of alternations between fitting phases and shape, and of frequencies for which
#: this is done; least number of runs.
_HARMONICS, _MOMENTS, _ROUNDS, _FINALISTS, _RUNS = 3, 48, 4, 6, 3


@dataclass(frozen=True)
class Pulsation:
    """A periodic component in the torque that the model lacks.

    Attributes:
        frequency: frequency of the wave [Hz].
        added: share of the squared torque in held-out runs that the wave predicts as an added torque.
        elastic: share of the squared torque in held-out runs that the wave predicts as a pulsating stiffness.
    """

    frequency: float
    added: float
    elastic: float

    @property
    def kind(self) -> str:
        """Kind of physics that the wave indicates; empty if it is not significant."""
        if max(self.added, self.elastic) < MOST:
            return ""
        if 1 - self.elastic <= LESS * (1 - self.added):
            return "elastic"
        return "actuation_map" if 1 - self.added <= LESS * (1 - self.elastic) else ""

    @property
    def sentence(self) -> str:
        """Conclusion as a clause; empty if there is no significant wave."""
        if not self.kind:
            return ""
        what, share = ("stiffness", self.elastic) if self.kind == "elastic" else ("torque", self.added)
        return (
            f"a {what} pulsates at {self.frequency:.2g} Hz, independently of the command: one wave predicts {100 * share:.0f} % "
            "of the missing torque in held-out trials"
        )


def pulsation(experiment: Experiment, torques: Sequence[ResidualTorque]) -> Pulsation | None:
    """Return the periodic part of the missing torque; None for arms in space, or if driven trials are too few or too short."""
    driven = [k for k, run in enumerate(experiment.runs) if run.span > 0]
    if len(driven) < _RUNS or len(experiment.directions) > 1 or len(torques) < len(experiment.runs):
        return None
    step = experiment.runs[driven[0]].step
    every = max(1, round(_STEP / step))
    kept = slice(_EDGE, _EDGE + round(_LONGEST / step), every)
    seen = [(torques[k].torque[:-_EDGE][kept].mean(axis=1), torques[k].bending[:-_EDGE][kept]) for k in driven]
    return wave(seen, step * every)


def wave(runs: Sequence[tuple[Array, Array]], step: float) -> Pulsation | None:
    """Return the periodic part of the missing torque of some runs.

    Args:
        runs: missing torque (T,) [N m] and bending (T,) [rad] of each run.
        step: sampling interval [s].
    """
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
        found[kind] = max(((_predicted(shares[f][1], f) / max(whole, 1e-300), f) for f in ranked), default=(0.0, 0.0))
    if not max(found.values())[1]:
        return None
    return Pulsation(max(found.values())[1], found["added"][0], found["elastic"][0])


class _Run:
    """Missing torque (T,) of one run, and the amplitude (T,) of a unit wave in it."""

    def __init__(self, missing: Array, size: Array, step: float) -> None:
        self.missing, self._size, self._step = missing - missing.mean(), size, step
        self.square, self.lasts = float(self.missing @ self.missing), len(missing) * step

    def basis(self, frequency: float) -> Array:
        """Return the harmonics (T, H) as complex waves that start at the first sample."""
        phase = 2 * np.pi * frequency * self._step * np.arange(len(self.missing))
        waves = self._size[:, None] * np.exp(1j * phase[:, None] * np.arange(1, _HARMONICS + 1))
        return np.asarray(waves - waves.mean(axis=0))

    def taken(self, frequency: float) -> float:
        """Return the squared torque that a wave of any shape explains in this run alone."""
        normal, product = _equations(self.basis(frequency), self.missing)
        return float(product @ _solved(normal, product))


def _predicted(runs: Sequence[_Run], frequency: float) -> float:
    """Return the squared torque that a wave predicts in held-out runs, summed over the runs.

    If the torque may also be an event that occurs once at the same time in each run, only the share is counted that a wave
    learned from the first halves of the runs predicts in the second halves. It is zero if the runs are too short for that.
    """
    bases = [run.basis(frequency) for run in runs]
    turns = np.exp(2j * np.pi * np.arange(_MOMENTS)[:, None] / _MOMENTS * np.arange(1, _HARMONICS + 1))

    def left(k: int, shape: Array) -> tuple[float, int]:
        """Return the squared torque that a wave of this shape leaves in a run, and the index of the best phase."""
        waves = (bases[k] @ (turns * (shape[:_HARMONICS] - 1j * shape[_HARMONICS:])).T).real
        squares = ((runs[k].missing[:, None] - waves) ** 2).sum(axis=0)
        return float(squares.min()), int(np.argmin(squares))

    def shape(some: Sequence[int], moments: Sequence[int]) -> Array:
        """Return the cosine and sine coefficients (2 H,) of the wave that fits some runs best."""
        parts = [_equations(bases[k] * turns[moments[k]], runs[k].missing) for k in some]
        return _solved(np.sum([normal for normal, _ in parts], axis=0), np.sum([product for _, product in parts], axis=0))

    every, moments = list(range(len(runs))), [0] * len(runs)
    learned = min((shape([k], moments) for k in every), key=lambda one: sum(left(k, one)[0] for k in every))
    for _ in range(_ROUNDS):
        moments = [left(k, learned)[1] for k in every]
        learned = shape(every, moments)
    moments = [left(k, learned)[1] for k in every]
    taken = sum(runs[k].square - left(k, shape([other for other in every if other != k], moments))[0] for k in every)
    whole = sum(run.square for run in runs)
    if taken > _at_once(runs) * whole / _EVENT:
        return taken
    if min(run.lasts for run in runs) * frequency < 2 * _PERIODS:
        return 0.0
    return min(taken, whole * _repeated(runs, [basis * turns[m] for basis, m in zip(bases, moments, strict=True)]))


def _at_once(runs: Sequence[_Run]) -> float:
    """Return the share of the missing torque that one common time course explains, with a different amplitude in each run."""
    length = min(len(run.missing) for run in runs)
    strength = np.linalg.svd(np.array([run.missing[:length] for run in runs]), compute_uv=False) ** 2
    return float(strength[0] / max(strength.sum(), 1e-300))


def _repeated(runs: Sequence[_Run], bases: Sequence[Array]) -> float:
    """Return the share of the second halves of the runs that a wave learned from the first halves predicts."""
    halves = [len(run.missing) // 2 for run in runs]
    parts = [_equations(basis[:h], run.missing[:h]) for run, basis, h in zip(runs, bases, halves, strict=True)]
    learned = _solved(np.sum([normal for normal, _ in parts], axis=0), np.sum([product for _, product in parts], axis=0))
    waves = [basis[h:] @ (learned[:_HARMONICS] - 1j * learned[_HARMONICS:]) for basis, h in zip(bases, halves, strict=True)]
    seen = [run.missing[h:] for run, h in zip(runs, halves, strict=True)]
    left = sum(float(((one - wave.real) ** 2).sum()) for one, wave in zip(seen, waves, strict=True))
    return 1 - left / max(sum(float(one @ one) for one in seen), 1e-300)


def _equations(basis: Array, missing: Array) -> tuple[Array, Array]:
    """Return the normal matrix (2 H, 2 H) and the right-hand side (2 H,) for a sum of cosines and sines."""
    rows = np.concatenate([basis.real, basis.imag], axis=1)
    return rows.T @ rows, rows.T @ missing


def _solved(normal: Array, product: Array) -> Array:
    return np.asarray(np.linalg.solve(normal + 1e-6 * np.trace(normal) * np.eye(len(normal)) + 1e-300, product))

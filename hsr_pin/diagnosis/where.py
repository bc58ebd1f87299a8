"""Maps of the gap: along the arm, over time, over the operating range, and by trial."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hsr_pin.diagnosis.base_motion import BaseMotion, base_motion
from hsr_pin.diagnosis.pulsation import Pulsation, pulsation
from hsr_pin.diagnosis.residual_torque import ResidualTorque, residual_torques
from hsr_pin.diagnosis.smooth import rank_correlation
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.phases import PHASES, phases
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.uncertainty import uncertainty
from hsr_pin.trajectory import Array

_BINS = 4
#: Directions of bending of an arm in space, and least bending, as a share of the largest, that has a direction.
SIDES, _BENT = ("+x", "+y", "-x", "-y"), 0.1
#: A part of the arm or of time with at least this share of the squared gap is named.
_MOST = 0.5
#: Least rank correlation with a quantity with which the gap is said to grow.
_GROWS = 0.3


@dataclass(frozen=True)
class Bin:
    """One part of a map.

    Attributes:
        label: name of the part.
        value: RMS value in the part, in the map's unit.
        share: share of the whole squared gap beyond noise, 0 to 1.
        noise: RMS value that noise alone would cause, in the map's unit.
    """

    label: str
    value: float
    share: float
    noise: float


@dataclass(frozen=True)
class Map:
    """RMS gap as a function of one quantity.

    Attributes:
        quantity: "arc length", "time", "bending angle", ...
        unit: unit of the values.
        bins: the parts in order.
    """

    quantity: str
    unit: str
    bins: tuple[Bin, ...]


@dataclass(frozen=True)
class Where:
    """All maps of the gap that remains with fitted stiffness and damping.

    Attributes:
        arc_length: residual torque along the arm [N m].
        time: marker distance by phase of the motion [mm].
        operating_range: marker distance over bending angle, rate and torque [mm]; in space also over the direction of bending.
        trials: marker distance by trial [mm].
        frequency: frequency at which the residual is strongest [Hz]; None if there is none.
        base: part of the gap that the base motion predicts; None without base markers.
        pulsation: part of the gap that a wave of one frequency predicts; None if it cannot be determined.
        sentence: conclusion as one sentence.
        defect: centre of a local change of stiffness and its 95 % interval, over L; None if none was found.
    """

    arc_length: Map
    time: Map
    operating_range: tuple[Map, ...]
    trials: Map
    frequency: float | None
    base: BaseMotion | None
    pulsation: Pulsation | None
    sentence: str
    defect: tuple[float, float, float] | None = None


def locate(experiment: Experiment, base: Candidate, seed: int) -> Where:
    """Return the maps of the gap that the model with fitted stiffness and damping leaves on held-out trials.

    Args:
        experiment: the recordings.
        base: the model with fitted stiffness and damping, without effects.
        seed: seed of the noise samples.
    """
    gaps = [_distance(residual) for residual in base.heldout]
    noise = experiment.noise_rms
    torques = residual_torques(experiment, base.fit, seed)
    labels = [_phases(run, gap) for run, gap in zip(experiment.runs, base.heldout, strict=True)]
    whole = np.concatenate(gaps)
    along = _along(torques)
    time = Map("time", "mm", _binned(whole, np.concatenate(labels), PHASES, noise))
    ranges = _operating_range(experiment, torques, gaps, noise) if len(torques) == len(gaps) else ()
    names = [run.trial.name for run in experiment.runs]
    index = np.concatenate([np.full(len(gap), k) for k, gap in enumerate(gaps)])
    trials = Map("trial", "mm", _binned(whole, index, names, noise))
    frequency = _frequency(experiment, base.heldout)
    sentence = _sentence(along, time, experiment, torques, gaps, ranges)
    base_moves, pulses = base_motion(experiment, base.heldout), pulsation(experiment, torques)
    return Where(along, time, ranges, trials, frequency, base_moves, pulses, sentence)


def _phases(run: Run, gap: Array) -> NDArray[np.int_]:
    """Return the phase (R,) of each sample of a run; ``gap`` (R, M, A) is predicted minus measured [m]."""
    path = np.full(run.tracked.shape, np.nan)
    path[run.looked_at] = run.compared + gap
    return np.asarray(phases(run, _filled(path))[run.looked_at])


def _distance(residual: Array) -> Array:
    """Return the RMS distance (T,) of the visible markers [m]; NaN where none was visible."""
    square = (residual**2).sum(axis=2)
    seen = np.isfinite(square)
    count = seen.sum(axis=1)
    mean = np.where(seen, square, 0.0).sum(axis=1) / np.maximum(count, 1)
    return np.where(count > 0, np.sqrt(mean), np.nan)


def _filled(positions: Array) -> Array:
    """Return positions (T, M, 3) with gaps interpolated linearly."""
    columns = positions.reshape(len(positions), -1).copy()
    sample = np.arange(len(columns))
    for column in columns.T:
        seen = np.isfinite(column)
        column[:] = np.interp(sample, sample[seen], column[seen]) if seen.any() else 0.0
    return np.asarray(columns.reshape(positions.shape))


def _along(torques: Sequence[ResidualTorque]) -> Map:
    squares = np.abs(np.concatenate([t.torque for t in torques])) ** 2
    noise = np.sqrt(np.mean([t.noise**2 for t in torques], axis=0))
    power = squares.mean(axis=0)
    beyond = np.maximum(power - noise**2, 0.0)
    links = len(power)
    return Map(
        "arc length",
        "N m",
        tuple(
            Bin(f"{k / links:.2f}-{(k + 1) / links:.2f} L", float(power[k] ** 0.5), _share(beyond, k), float(noise[k]))
            for k in range(links)
        ),
    )


def _binned(gap: Array, index: NDArray[np.int_], labels: Sequence[str], noise: float) -> tuple[Bin, ...]:
    seen = np.isfinite(gap)
    sums = np.array([(gap[seen & (index == k)] ** 2).sum() for k in range(len(labels))])
    counts = np.array([(seen & (index == k)).sum() for k in range(len(labels))])
    beyond = np.maximum(sums - counts * noise**2, 0.0)
    return tuple(
        Bin(label, 1e3 * float(np.sqrt(sums[k] / counts[k])), _share(beyond, k), 1e3 * noise)
        for k, label in enumerate(labels)
        if counts[k]
    )


def _share(beyond: Array, k: int) -> float:
    whole = float(beyond.sum())
    return float(beyond[k]) / whole if whole > 0 else 0.0


def _operating_range(
    experiment: Experiment, torques: Sequence[ResidualTorque], gaps: Sequence[Array], noise: float
) -> tuple[Map, ...]:
    gap = np.concatenate(gaps)
    bending = _used_samples(experiment, [t.bending for t in torques])
    quantities = (
        ("bending angle", "rad", np.abs(bending)),
        ("bending rate", "rad/s", np.abs(_used_samples(experiment, [t.rate for t in torques]))),
        ("torque", "N m", np.abs(_used_samples(experiment, [run.torque for run in experiment.runs]))),
    )
    maps = []
    for quantity, unit, values in quantities:
        edges = np.linspace(0.0, float(values.max()), _BINS + 1)
        if edges[-1] <= 0:
            continue
        index = np.clip(np.digitize(values, edges) - 1, 0, _BINS - 1)
        labels = [f"{low:.2g}-{high:.2g} {unit}" for low, high in itertools.pairwise(edges)]
        maps.append(Map(quantity, "mm", _binned(gap, index, labels, noise)))
    if len(experiment.directions) > 1:
        maps.append(_direction(bending, gap, noise))
    return tuple(maps)


def _used_samples(experiment: Experiment, values: Sequence[Array]) -> Array:
    """Return (n,) values (T,) of all runs at the samples that are used, concatenated."""
    return np.concatenate([each[run.looked_at] for run, each in zip(experiment.runs, values, strict=True)])


def _direction(bending: Array, gap: Array, noise: float) -> Map:
    """Return the map over the direction of bending (T,) of an arm in space, in the axes of its base, for large bending only."""
    size = np.abs(bending)
    side = np.round(np.angle(bending) / (np.pi / 2)).astype(int) % 4
    index = np.where(size > _BENT * size.max(), side, -1)
    return Map("direction of bending", "mm", _binned(gap, index, SIDES, noise))


def _frequency(experiment: Experiment, heldout: Sequence[Array]) -> float | None:
    """Return the frequency [Hz] with the largest residual power; None if it is not distinct or lasts less than three periods."""
    spectra: dict[float, float] = {}
    for run, residual in zip(experiment.runs, heldout, strict=True):
        signal = np.nan_to_num(residual.reshape(len(residual), -1))
        power = (np.abs(np.fft.rfft(signal - signal.mean(axis=0), axis=0)) ** 2).sum(axis=1)
        for frequency, value in zip(np.fft.rfftfreq(len(signal), _pace(run))[1:], power[1:], strict=True):
            spectra[round(float(frequency), 1)] = spectra.get(round(float(frequency), 1), 0.0) + float(value)
    powers = np.array(list(spectra.values()))
    peak = int(np.argmax(powers))
    longest = max(len(residual) * _pace(run) for run, residual in zip(experiment.runs, heldout, strict=True))
    frequency = list(spectra)[peak]
    return frequency if powers[peak] > 5 * np.median(powers) and frequency * longest > 3 else None


def _pace(run: Run) -> float:
    """Return the mean interval between the samples that are used [s]."""
    return float(run.instants[-1] - run.instants[0]) / (len(run.instants) - 1)


def local_defect(best: Candidate) -> tuple[float, float, float] | None:
    """Return the centre of a local change of stiffness in the best model and its 95 % interval, over L; None without one."""
    facts = [fact.name for fact in best.fit.hypothesis.parameters]
    if "soft_spot.centre" not in facts:
        return None
    place = facts.index("soft_spot.centre")
    low, high = uncertainty(best.fit).interval[place]
    return float(best.fit.values[place]), float(low), float(high)


def _sentence(
    along: Map,
    time: Map,
    experiment: Experiment,
    torques: Sequence[ResidualTorque],
    gaps: Sequence[Array],
    ranges: Sequence[Map],
) -> str:
    phase = max(time.bins, key=lambda part: part.share)
    when = {
        "rest": "while the arm is at rest",
        "command change": "just after the command changes",
        "transient": "while the arm moves",
        "settled": "after the arm has settled",
    }[phase.label]
    if phase.share < _MOST:
        when = "in all parts of the motion"
    thirds = np.array([part.share for part in along.bins])
    at = (np.arange(len(thirds)) + 0.5) / len(thirds)
    held = [float(thirds[(at >= k / 3) & (at < (k + 1) / 3)].sum()) for k in range(3)]
    names = ("inner third", "middle third", "outer third")
    place = f"in the {names[int(np.argmax(held))]} of the arm" if max(held) >= _MOST else "along the whole arm"
    sides = [part for chart in ranges if chart.quantity == "direction of bending" for part in chart.bins]
    most = max(sides, key=lambda part: part.share, default=None)
    side = f", most where it bends towards {most.label}" if most and most.share >= _MOST else ""
    return f"The gap occurs {when}, {place}{_growth(experiment, torques, gaps)}{side}."


def _growth(experiment: Experiment, torques: Sequence[ResidualTorque], gaps: Sequence[Array]) -> str:
    if len(torques) != len(gaps):
        return ""
    gap = np.concatenate(gaps)
    seen = np.isfinite(gap)
    ranks = {}
    for name, values in (
        ("bending", [np.abs(t.bending) for t in torques]),
        ("the rate of bending", [np.abs(t.rate) for t in torques]),
        ("torque", [np.abs(run.torque) for run in experiment.runs]),
    ):
        value = _used_samples(experiment, values)[seen]
        if np.ptp(value) > 0:
            ranks[name] = rank_correlation(value, gap[seen])
    name, rank = max(ranks.items(), key=lambda item: item[1], default=("", 0.0))
    return f", and grows with {name}" if rank > _GROWS else ""

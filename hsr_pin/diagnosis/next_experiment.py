"""Selection of the next experiment: the standard experiment in which the alternative models differ most, relative to noise."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.prepared import Run
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.integrator import Integrator
from hsr_pin.simulation.motion import Engine
from hsr_pin.trajectory import Array

_STEP, _DURATION = 0.01, 4.0
#: Payload [kg] and tilt of the base [rad] of the experiments with a payload or a tilt.
_PAYLOAD, _TILT = 0.05, 0.35
#: Alternatives whose distance is below this in every experiment [noise floors] count as one.
INDISTINGUISHABLE = 0.1


@dataclass(frozen=True)
class Proposal:
    """A standard experiment with its predicted separation of alternatives.

    Attributes:
        name: "steps", "steps aside", "staircase", "chirp", "release", "payload" or "tilted base".
        separation: RMS distance between the markers predicted by the two closest alternatives, in noise floors; alternatives that
            no experiment separates are not counted.
    """

    name: str
    separation: float


def propose(experiment: Experiment, rivals: Sequence[tuple[Hypothesis, Array]]) -> tuple[Proposal, ...]:
    """Return the standard experiments for fitted alternatives (model, values (P,)), the most informative first.

    Alternatives that no experiment separates count as one law. The result is empty if there are fewer than two different ones.
    """
    if len(rivals) < 2:
        return ()
    separations: dict[str, Array] = {}  # (pairs of alternatives,) in noise floors
    for name, changes in _programs(experiment):
        seen = [_predicted(experiment, model, values, changes) for model, values in rivals]
        if all(np.isfinite(positions).all() for positions in seen):
            pairs = itertools.combinations(seen, 2)
            separations[name] = np.array([np.sqrt(((a - b) ** 2).sum(axis=2).mean()) for a, b in pairs]) / experiment.noise_rms
    if not separations:
        return ()
    distinguishable = np.max(list(separations.values()), axis=0) >= INDISTINGUISHABLE
    proposals = [
        Proposal(name, float(each[distinguishable].min())) for name, each in separations.items() if distinguishable.any()
    ]
    return tuple(sorted(proposals, key=lambda proposal: -proposal.separation))


@dataclass(frozen=True, eq=False)
class _Changes:
    torque: Array
    payload: float = 0.0
    tilt: float = 0.0
    released: bool = False


def _programs(experiment: Experiment) -> list[tuple[str, _Changes]]:
    run = experiment.runs[0]
    largest = max(float(np.abs(each.torque).max()) for each in experiment.runs) or 0.9 * run.trial.keq
    t = np.arange(round(_DURATION / _STEP) + 1) * _STEP
    steps = np.where(t < 0.1, 0.0, largest)
    stairs = largest * np.interp(t, [0, _DURATION / 2, _DURATION], [0, 1, 0])
    stairs = np.round(stairs / largest * 4) / 4 * largest
    chirp = np.where(t < 0.1, 0.0, largest / 2 * (1 - np.cos(2 * np.pi * (0.2 + 0.4 * t) * t)))
    aside = [("steps aside", _Changes(np.asarray(1j * steps)))] if len(experiment.directions) > 1 else []
    return [
        ("steps", _Changes(steps)),
        *aside,
        ("staircase", _Changes(stairs)),
        ("chirp", _Changes(chirp)),
        ("release", _Changes(np.zeros_like(t), released=True)),
        ("payload", _Changes(steps, payload=_PAYLOAD)),
        ("tilted base", _Changes(steps, tilt=_TILT)),
    ]


def _predicted(experiment: Experiment, model: Hypothesis, values: Array, changes: _Changes) -> Array:
    """Return the marker positions (T, M, 3) in a standard experiment [m]."""
    template = experiment.runs[0]
    time: Array = _STEP * np.arange(len(changes.torque), dtype=float)
    torque = changes.torque.astype(template.torque.dtype)
    unseen = np.full((len(time), len(experiment.markers), 3), np.nan)
    run = Run(template.trial, time, torque, unseen, None, 0.0, axes=template.axes)
    plain = model.arm_batch(experiment, run, values[None])
    arms = replace(plain.nominal, tip_mass=plain.nominal.tip_mass + changes.payload, tilt=plain.nominal.tilt + changes.tilt)
    batch = ArmBatch(arms, plain.effects)
    engine = Engine(batch, "compiled")
    command = engine.deliver(run.torque[:, None], run.torque[:1], _STEP)
    q, found = batch.evenly(np.array([0.8])), np.ones(1, dtype=bool)
    if not changes.released:
        q, found = engine.settled(command.initial, found, np.zeros_like(q))
    motion = engine.run(engine.loaded(q, np.zeros_like(q)), command, len(time), Integrator(tolerance=model.tolerance), found)
    positions = experiment.cameras(batch).positions(motion.angles)[:, 0]
    return positions if np.isinf(motion.lost[0]) else np.full_like(positions, np.nan)

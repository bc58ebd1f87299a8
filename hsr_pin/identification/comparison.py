"""Simulation beside measurement: the error in honest numbers, without any alignment of means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import SimulationFailure
from hsr_pin.identification.evaluation import respond
from hsr_pin.identification.experiment import Experiment, prepare
from hsr_pin.identification.hypothesis import Hypothesis, chain_of
from hsr_pin.identification.phases import PHASES, phases
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import ArmSpecification, Placement
from hsr_pin.simulation.integrator import TOLERANCE as SIMULATION_TOLERANCE
from hsr_pin.trajectory import Array, Dataset, Trajectory


@dataclass(frozen=True)
class MarkerError:
    """Distances between simulated and measured positions of one marker (or of all of them).

    Attributes:
        marker: its name; "all" for all of them.
        rms, p95: [m] root mean square and 95th percentile of the distance.
        transient, settled: [m] RMS of the distance while the arm moves, and where it has settled; NaN if it never does.
    """

    marker: str
    rms: float
    p95: float
    transient: float
    settled: float


@dataclass(frozen=True, eq=False)
class TrialComparison:
    """One trial.

    Attributes:
        name: of the trial.
        arm: what was simulated.
        simulated, measured: over the same times, with the same markers.
        errors: of each marker, then of all.
    """

    name: str
    arm: ArmSpecification
    simulated: Trajectory
    measured: Trajectory
    errors: tuple[MarkerError, ...]


@dataclass(frozen=True, eq=False)
class Comparison:
    """A dataset.

    Attributes:
        experiment: the recordings as they were used.
        trials: in the dataset's order.
        errors: over all trials, of each marker, then of all.
    """

    experiment: Experiment
    trials: tuple[TrialComparison, ...]
    errors: tuple[MarkerError, ...]


def compare(
    dataset: Dataset | str | Path,
    *,
    links: int | None = None,
    placement: Placement | None = None,
    effects: Sequence[Effect] = (),
    keq_scale: float = 1.0,
    damping_scale: float = 1.0,
) -> Comparison:
    """Simulate every trial with its own input, mount, payload and start, and compare.

    Args:
        dataset: the recordings; or the folder that holds them, or the name of a sample.
        links: of the chain; default: 16, or as many as simulated the dataset.
        placement: of its joints; default: in the middle of each element, or as in the simulation.
        effects: beside the nominal model.
        keq_scale: on the declared Keq.
        damping_scale: on the declared C.

    Raises:
        IdentificationError: nothing in the dataset can be compared.
        SimulationFailure: a simulation ended early.
    """
    if not isinstance(dataset, Dataset):
        dataset = read_dataset(dataset)
    experiment = prepare(dataset)
    hypothesis = Hypothesis(tuple(effects), **chain_of(dataset, links, placement), tolerance=SIMULATION_TOLERANCE)
    values = np.array([[keq_scale, damping_scale]])
    trials, every = [], []
    for run in experiment.runs:
        answer = respond(experiment, run.whole, hypothesis, values)
        arm = answer.columns.arms.specification(0)
        if not np.isfinite(answer.positions).all():
            failed = float(run.time[int(np.isfinite(answer.positions).all(axis=(1, 2, 3)).sum())])
            raise SimulationFailure(f"{run.trial.name}: the simulation ends early, at t = {failed:.4g} s", answer)
        simulated = Trajectory(
            run.time,
            experiment.markers,
            answer.positions[:, 0],
            torque=run.drive,
            joint_angles=answer.columns.by_joint(answer.angles[:, 0]),
            joint_rates=answer.columns.by_joint(answer.rates[:, 0]),
        )
        measured = Trajectory(run.time, experiment.markers, run.measured, torque=run.drive, notes=run.trial.trajectory.notes)
        distance, phase = np.linalg.norm(simulated.positions - run.measured, axis=2), phases(run, simulated.positions)
        every.append((distance, phase))
        errors = _errors(experiment, distance, phase)
        trials.append(TrialComparison(run.trial.name, arm, simulated, measured, errors))
    whole = _errors(experiment, *(np.concatenate(parts) for parts in zip(*every, strict=True)))
    return Comparison(experiment, tuple(trials), whole)


def _errors(experiment: Experiment, distance: Array, phase: NDArray[np.int_]) -> tuple[MarkerError, ...]:
    names = [marker.name for marker in experiment.markers]
    columns = [distance[:, [i]] for i in range(len(names))] + [distance]
    return tuple(_error(name, column, phase) for name, column in zip([*names, "all"], columns, strict=True))


def _error(name: str, distance: Array, phase: NDArray[np.int_]) -> MarkerError:
    moving = np.isin(phase, [PHASES.index("command change"), PHASES.index("transient")])
    seen = distance[np.isfinite(distance)]
    p95 = float(np.percentile(seen, 95)) if len(seen) else np.nan
    return MarkerError(name, _rms(distance), p95, _rms(distance[moving]), _rms(distance[phase == PHASES.index("settled")]))


def _rms(distance: Array) -> float:
    seen = distance[np.isfinite(distance)]
    return float(np.sqrt(np.mean(seen**2))) if len(seen) else float("nan")

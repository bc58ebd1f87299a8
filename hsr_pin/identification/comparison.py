"""Comparison of simulation and measurement, without any alignment of means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import SimulationFailure
from hsr_pin.identification.evaluation import simulate_run
from hsr_pin.identification.experiment import Experiment, prepare
from hsr_pin.identification.hypothesis import Hypothesis, chain_of
from hsr_pin.identification.phases import PHASES, phases
from hsr_pin.recordings.read import read_dataset
from hsr_pin.robot.specification import ArmSpecification, Placement
from hsr_pin.simulation.integrator import TOLERANCE as SIMULATION_TOLERANCE
from hsr_pin.trajectory import Array, Dataset, Trajectory


@dataclass(frozen=True)
class MarkerError:
    """Distances between simulated and measured positions of one marker, or of all markers.

    Attributes:
        marker: name of the marker; "all" for all markers.
        rms, p95: root mean square and 95th percentile of the distance [m].
        transient, settled: RMS distance while the arm moves, and after it has settled [m]; NaN if it never does.
    """

    marker: str
    rms: float
    p95: float
    transient: float
    settled: float


@dataclass(frozen=True, eq=False)
class TrialComparison:
    """The comparison of one trial.

    Attributes:
        name: name of the trial.
        arm: the simulated arm.
        simulated, measured: the motions at the same times, with the same markers.
        errors: the errors of each marker, then of all markers.
    """

    name: str
    arm: ArmSpecification
    simulated: Trajectory
    measured: Trajectory
    errors: tuple[MarkerError, ...]


@dataclass(frozen=True, eq=False)
class Comparison:
    """The comparison of all trials of a dataset.

    Attributes:
        experiment: the recordings as they were used.
        trials: the comparisons of the trials, in the dataset's order.
        errors: the errors over all trials, of each marker, then of all markers.
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
    """Simulate every trial with its own input, mount, payload and start, and compare it with the measurement.

    Args:
        dataset: the recordings, the folder that contains them, or the name of a sample.
        links: number of links of the chain; default: 16, or that of the model which simulated the dataset.
        placement: placement of its joints; default: in the middle of each element, or as in the simulation.
        effects: effects in addition to the nominal model.
        keq_scale: factor on the declared Keq.
        damping_scale: factor on the declared C.

    Raises:
        IdentificationError: no trial of the dataset can be compared.
        SimulationFailure: a simulation failed.
    """
    if not isinstance(dataset, Dataset):
        dataset = read_dataset(dataset)
    experiment = prepare(dataset)
    hypothesis = Hypothesis(tuple(effects), **chain_of(dataset, links, placement), tolerance=SIMULATION_TOLERANCE)
    values = np.array([[keq_scale, damping_scale]])
    trials, every = [], []
    for run in experiment.runs:
        answer = simulate_run(experiment, run.whole, hypothesis, values)
        arm = answer.batch.arms.specification(0)
        if not np.isfinite(answer.positions).all():
            failed = float(run.time[int(np.isfinite(answer.positions).all(axis=(1, 2, 3)).sum())])
            raise SimulationFailure(f"{run.trial.name}: the simulation ends early, at t = {failed:.4g} s", answer)
        simulated = Trajectory(
            run.time,
            experiment.markers,
            answer.positions[:, 0],
            torque=run.drive,
            joint_angles=answer.batch.by_joint(answer.angles[:, 0]),
            joint_rates=answer.batch.by_joint(answer.rates[:, 0]),
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

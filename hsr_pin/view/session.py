"""Recordings and the model of their arm, which is simulated again for every setting within milliseconds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from hsr_pin.effects.effect import View
from hsr_pin.identification.evaluation import simulate_run
from hsr_pin.identification.experiment import Experiment, prepare
from hsr_pin.identification.hypothesis import Hypothesis, chain_of
from hsr_pin.identification.part import ARM
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.residuals import rms
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.space import base_rotations
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification, Placement, mount_frame
from hsr_pin.trajectory import Array, Dataset
from hsr_pin.view.settings import Settings

#: Number of points of a drawn backbone.
POINTS = 33
#: Effects that move the markers relative to the arm.
_OF_MARKERS = ("marker_offset", "markers_beside")


@dataclass(frozen=True, eq=False)
class Answer:
    """Simulation of one trial.

    Attributes:
        backbone: (T, POINTS, 3) points of the backbone [m].
        markers: (T, M, 3) positions of the markers [m]; NaN after a failure.
        error: (T,) RMS distance of the markers from the measured ones [m]; NaN where none is seen.
        residual: (T, M, A) simulated minus measured positions [m], in the plane (A = 2) or in space (A = 3).
        stopped: time at which the simulation failed [s]; None: it did not.
    """

    backbone: Array
    markers: Array
    error: Array
    residual: Array
    stopped: float | None

    @property
    def rms(self) -> float:
        """RMS distance over the trial [m]; NaN if the simulation failed."""
        return float("nan") if self.stopped is not None else rms([self.residual])


@dataclass(frozen=True, eq=False)
class Session:
    """Recordings and the simulated chain that the page shows.

    Attributes:
        experiment: the recordings.
        links, placement: number of links and placement of the joints of the simulated chain.
    """

    experiment: Experiment
    links: int
    placement: Placement

    @classmethod
    def of(cls, dataset: Dataset, links: int | None = None, placement: Placement | None = None) -> Session:
        """Return a session of the usable trials; the chain is that of :func:`~hsr_pin.identification.hypothesis.chain_of`.

        Raises:
            IdentificationError: no trial is usable.
        """
        return cls(prepare(dataset), **chain_of(dataset, links, placement))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the trials."""
        return tuple(run.trial.name for run in self.experiment.runs)

    @property
    def space(self) -> bool:
        """Whether the arm bends in space."""
        return self.experiment.dataset.bending == "space"

    @property
    def across(self) -> dict[str, Array]:
        """Directions (3,) perpendicular to the straight arm in which the tip is plotted over time, by title of the plot."""
        dataset, title = self.experiment.dataset, "Position of the outermost marker"
        if not self.space:
            return {f"{title}, perpendicular to the straight arm": np.abs(mount_frame(dataset.mount)[1])}
        axes = base_rotations(Arms.of([ArmSpecification.from_trial(dataset, dataset.trials[0])]))[0]
        return {f"{title}, towards {axis} of the base": axes[:, k] for k, axis in enumerate("xy")}

    @property
    def noise(self) -> float:
        """RMS distance due to noise alone [m]."""
        return self.experiment.noise_rms

    def run(self, name: str) -> Run:
        """Return a trial by its name."""
        return self.experiment.runs[self.names.index(name)]

    def answer(self, run: Run, settings: Settings) -> Answer:
        """Simulate a trial with the given settings."""
        hypothesis = Hypothesis(settings.effects(), tuple(ARM), self.links, self.placement)
        values = np.array([[settings.arm(name) for name in ARM]])
        found = simulate_run(self.experiment, run.whole, hypothesis, values)
        markers = found.positions[:, 0]
        residual = markers[..., run.axes] - run.tracked
        squares = (residual**2).sum(axis=-1)
        seen = np.isfinite(squares)
        error = np.sqrt(np.where(seen, squares, 0.0).sum(axis=1) / np.where(seen.any(axis=1), seen.sum(axis=1), np.nan))
        lost = np.flatnonzero(~np.isfinite(markers).all(axis=(1, 2)))
        stopped = float(run.time[lost[0]] - run.time[0]) if len(lost) else None
        return Answer(self._backbone(found), markers, error, residual, stopped)

    def _backbone(self, found: object) -> Array:
        arms, effects = found.batch.arms, found.batch.effects  # type: ignore[attr-defined]
        reach = np.linspace(0.0, self.experiment.dataset.length, POINTS)
        places: Any = space_marker_map(arms, reach) if self.space else marker_map(arms, reach)
        angles = found.angles  # type: ignore[attr-defined]
        shown = places.positions(angles)
        for effect in effects:
            if effect.acts_through("observe") and effect.name not in _OF_MARKERS:
                shown = effect.observe(View(shown, reach, places, angles))
        return np.asarray(shown[:, 0])


def overall(answers: Sequence[Answer]) -> float:
    """Return the RMS distance over several trials [m]; NaN if a simulation failed."""
    return float("nan") if any(each.stopped is not None for each in answers) else rms([each.residual for each in answers])

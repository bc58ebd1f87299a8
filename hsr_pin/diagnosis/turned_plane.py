"""An arm that bends in a plane, but not in the declared one: told, and turned back before any model is asked.

Seen from the declared plane such an arm bends less than it does, by the cosine of the turn, and every model of it is too stiff.
Whether the cameras are turned or the base with its muscles, no recording of the arm alone can tell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.diagnosis.fingerprint.fingerprint import Fingerprint
from hsr_pin.diagnosis.fingerprint.out_of_plane import OutOfPlane, out_of_plane
from hsr_pin.identification.experiment import Experiment
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array


@dataclass(frozen=True, eq=False)
class TurnedPlane:
    """A turn about the straight arm.

    Attributes:
        shown: by which print.
    """

    shown: OutOfPlane

    @property
    def kind(self) -> str:
        """Kind of physics that it tells."""
        return "measurement"

    @property
    def sentence(self) -> str:
        """As a person would say it."""
        turn = self.shown.turn
        low, high = (f"{np.degrees(value):.1f}" for value in (turn.low, turn.high))
        return (
            f"the plane in which the arm bends is turned by {np.degrees(turn.value):.1f} degrees ({low} to {high}) about the "
            "straight arm, by its cameras or its base, and was turned back first"
        )

    def undone(self, experiment: Experiment) -> Experiment:
        """The recordings as if the plane were the declared one."""
        along, across = mount_frame(experiment.dataset.mount)
        across, aside = np.abs(across), np.array([0.0, 1.0, 0.0])  # the world's axes, as the print has them
        c, s = np.cos(self.shown.turn.value), np.sin(self.shown.turn.value)
        turn = np.outer(along, along) + np.outer(across, c * across + s * aside) + np.outer(aside, c * aside - s * across)
        centre = self.shown.beside * aside

        def back(points: Array) -> Array:
            return np.asarray((points - centre) @ turn.T + centre)

        trials = {
            trial.name: replace(trial, trajectory=replace(trial.trajectory, positions=back(trial.trajectory.positions)))
            for trial in experiment.dataset.trials
        }
        runs = tuple(
            replace(
                run,
                trial=trials[run.trial.name],
                measured=back(run.measured),
                start_pose=None if run.start_pose is None else back(run.start_pose),
                start_velocity=None if run.start_velocity is None else run.start_velocity @ turn.T,
                found_poses={},
            )
            for run in experiment.runs
        )
        return replace(experiment, dataset=replace(experiment.dataset, trials=tuple(trials.values())), runs=runs)

    def within(self, prints: Fingerprint) -> Fingerprint:
        """What the recordings show, the turn as it was before it was undone."""
        kept = tuple(self.shown if each.name == self.shown.name else each for each in prints.prints)
        return replace(prints, prints=kept)


def turned_plane(experiment: Experiment) -> TurnedPlane | None:
    """None where the arm bends in the declared plane, or in none, or in space."""
    if len(experiment.directions) > 1:
        return None
    found = out_of_plane(experiment)
    return TurnedPlane(found) if found is not None and found.turned else None

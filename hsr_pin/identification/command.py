"""What a trial's input commands of the arm, section by section."""

from __future__ import annotations

import numpy as np

from hsr_pin.errors import IdentificationError
from hsr_pin.robot.pressure import PAPER
from hsr_pin.trajectory import Array, Dataset, Trial


def command_of(trial: Trial, dataset: Dataset) -> Array:
    """(T, S) [N m] commanded of each section, (T, 1) of an arm without; in space complex.

    Raises:
        IdentificationError: an input of another kind of arm.
    """
    trajectory, sections, space = trial.trajectory, max(1, len(dataset.sections)), len(dataset.axes) == 3
    if not trajectory.has_input:
        return np.zeros((len(trajectory.time), sections), dtype=complex if space else float)
    torque = trajectory.torque if trajectory.pressures is None else trial.keq * _bending(trajectory.pressures)
    assert torque is not None
    if torque.shape[1:] != ((2 * sections,) if space else ()) or (space and trajectory.pressures is not None):
        expected = "two components of torque, for an arm in space" if space else "one torque, or two pressures"
        each = f", for each of {sections} sections" if sections > 1 else ""
        raise IdentificationError(f"input of {trial.name}", expected=expected + each, received=f"values of shape {torque.shape}")
    return torque[:, 0::2] + 1j * torque[:, 1::2] if space else torque[:, None]


def mean_along(command: Array, dataset: Dataset) -> Array:
    """(T,) [N m] the mean along the arm of what its sections are commanded, (T, S)."""
    lengths = np.array([section.length for section in dataset.sections] or [1.0])
    return np.asarray(command @ (lengths / lengths.sum()))


def _bending(pressures: Array) -> Array:
    """Eq. (4) as it stands: measured pressures may leave the regulators' range by their noise."""
    constant, first, second = PAPER.bending_plane
    return np.asarray(constant + first * pressures[:, 0] + second * pressures[:, 1])

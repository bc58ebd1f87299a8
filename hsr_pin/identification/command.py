"""The commanded torque of a trial, section by section."""

from __future__ import annotations

import numpy as np

from hsr_pin.errors import IdentificationError
from hsr_pin.robot.pressure import PAPER
from hsr_pin.trajectory import Array, Dataset, Trial


def command_of(trial: Trial, dataset: Dataset) -> Array:
    """Return the commanded torque (T, S) [N m] of each section, (T, 1) of an arm without sections; complex in space.

    Raises:
        IdentificationError: the input belongs to another kind of arm.
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
    """Return the mean (T,) [N m] along the arm of the section torques (T, S)."""
    lengths = np.array([section.length for section in dataset.sections] or [1.0])
    return np.asarray(command @ (lengths / lengths.sum()))


def _bending(pressures: Array) -> Array:
    """Return the bending by Eq. (4) without range checks, because measured pressures are noisy."""
    constant, first, second = PAPER.bending_plane
    return np.asarray(constant + first * pressures[:, 0] + second * pressures[:, 1])

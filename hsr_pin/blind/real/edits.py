"""Edits of a recording, or of its declared values, that withhold a known cause; each returns a new dataset."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from hsr_pin.blind.plants.arm import MOUNTS
from hsr_pin.errors import InputError
from hsr_pin.trajectory import Array, Dataset, Trajectory

#: Torque of real-pneumatic per difference of pressure [N m/bar]: 0.09 N m/psi according to its source.
TORQUE_PER_BAR = 0.09 * 14.5038


def leave_commanded(dataset: Dataset, amount: float) -> Dataset:
    """Return the dataset unchanged: its input is the command, and the true pressures lag behind it."""
    return dataset


def declare_payload(dataset: Dataset, amount: float) -> Dataset:
    """Return the dataset with every declared payload reduced by this mass [kg]."""
    return replace(dataset, trials=tuple(replace(trial, tip_mass=max(0.0, trial.tip_mass - amount)) for trial in dataset.trials))


def declare_mass(dataset: Dataset, amount: float) -> Dataset:
    """Return the dataset with the declared mass of the arm reduced by this share."""
    return replace(dataset, mass=dataset.mass * (1 - amount))


def declare_middle(dataset: Dataset, amount: float) -> Dataset:
    """Return the dataset with the declared arc lengths of the inner markers (of two: the outer one) reduced by this share."""
    moving = [marker.name for marker in dataset.markers if marker.arc_length > 0]
    wrong = moving[:-1] or moving
    markers = tuple(
        replace(marker, arc_length=marker.arc_length * (1 - amount)) if marker.name in wrong else marker
        for marker in dataset.markers
    )
    return _with_trajectories(dataset, lambda track: replace(track, markers=markers))


def turn_frame(dataset: Dataset, amount: float) -> Dataset:
    """Return the dataset with the cameras' frame rotated about the base in the plane, towards positive bending [rad]."""
    ex, ez = (np.array(axis, dtype=float) for axis in MOUNTS[dataset.mount])
    c, s = np.cos(amount), np.sin(amount)

    def turned(track: Trajectory) -> Trajectory:
        x, z = track.positions @ ex, track.positions @ ez
        moved = (c * x + s * z - x)[..., None] * ex + (c * z - s * x - z)[..., None] * ez
        return replace(track, positions=track.positions + moved)

    return _with_trajectories(dataset, turned)


def move_markers(dataset: Dataset, amount: float) -> Dataset:
    """Return the dataset with all markers moved off the arm towards positive bending [m], on plates that rotate with it."""
    ex, ez = (np.array(axis, dtype=float) for axis in MOUNTS[dataset.mount])

    def moved(track: Trajectory) -> Trajectory:
        angle = directions(track, ex, ez)[..., None]
        return replace(track, positions=track.positions + amount * (np.cos(angle) * ex - np.sin(angle) * ez))

    return _with_trajectories(dataset, moved)


def delay_motion(dataset: Dataset, amount: float) -> Dataset:
    """Return the dataset with the motion delayed by this time [s], as with a late camera clock; it begins with the first pose."""

    def late(track: Trajectory) -> Trajectory:
        flat = track.positions.reshape(len(track.time), -1)
        moved = np.stack([np.interp(track.time - amount, track.time, column) for column in flat.T], axis=1)
        return replace(track, positions=moved.reshape(track.positions.shape))

    return _with_trajectories(dataset, late)


def measured_torque(dataset: Dataset) -> Dataset:
    """Return the dataset with the torque of the measured pressures instead of the commanded ones (real-pneumatic only)."""
    if dataset.path is None:
        raise InputError("recordings", expected="a dataset whose folder contains pressures/", received=dataset.name)
    folder = dataset.path / "pressures"
    trials = []
    for trial in dataset.trials:
        torque = _measured(folder / f"{trial.name}.csv", trial.trajectory.time)
        trials.append(replace(trial, trajectory=replace(trial.trajectory, torque=torque)))
    return replace(dataset, trials=tuple(trials))


def directions(track: Trajectory, ex: Array, ez: Array) -> Array:
    """Return the direction of the arm at each marker, (T, M) [rad] from the straight arm, from the markers alone.

    Between two markers the arm is taken as nearly an arc: at an inner marker its direction is that of the line between the
    neighbours; at the last marker it follows from the arc.
    """
    arcs = [marker.arc_length for marker in track.markers]
    order = [k for k in np.argsort(arcs) if arcs[k] > 0]
    x, z = (np.concatenate([np.zeros((len(track.time), 1)), track.positions[:, order] @ axis], axis=1) for axis in (ex, ez))
    angle = np.zeros_like(x)
    angle[:, 1:-1] = np.arctan2(x[:, 2:] - x[:, :-2], z[:, 2:] - z[:, :-2])
    angle[:, -1] = 2 * np.arctan2(x[:, -1] - x[:, -2], z[:, -1] - z[:, -2]) - angle[:, -2]
    out = np.zeros((len(track.time), len(arcs)))
    out[:, order] = angle[:, 1:]
    return out


def _with_trajectories(dataset: Dataset, edit: Callable[[Trajectory], Trajectory]) -> Dataset:
    return replace(dataset, trials=tuple(replace(trial, trajectory=edit(trial.trajectory)) for trial in dataset.trials))


def _measured(file: Path, time: Array) -> Array:
    try:
        header = file.read_text(encoding="utf-8").partition("\n")[0].split(",")
        values = dict(zip(header, np.loadtxt(file, delimiter=",", skiprows=1, unpack=True), strict=True))
        difference = np.mean([values[f"measured{k}A"] - values[f"measured{k}B"] for k in (1, 2)], axis=0)
        return np.asarray(np.interp(time, values["t"], TORQUE_PER_BAR * difference))
    except (OSError, ValueError, KeyError) as error:
        raise InputError("pressures", expected="columns t, measured1A to measured2B", received=error, file=file) from error

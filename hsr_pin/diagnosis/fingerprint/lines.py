"""Recordings of an arm in space as recordings in a plane, where they are that: trials that stay on one line.

A law about two axes is along one line what it is in a plane: times, loops and decays mean there what they mean in a plane. Off
such a line they mean nothing by themselves (a swing that goes round is no decay, a command that turns leaves loops without any
friction), and nothing is said of them. How far an arm is bent to each side is told as in a plane: twice the angle at which a
marker is seen.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.prepared import Run
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.space import base_rotations
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array

#: A command is on a line if it leaves it by less than this share of its size; a motion by this share of its RMS size, or by so
#: many noises.
_COMMAND, _MOTION, _NOISES = 0.02, 0.1, 2.0


@dataclass(frozen=True, eq=False)
class Lines:
    """Trials of an arm in space that stay on a line, as an arm in a plane would show them.

    Attributes:
        driven: those whose command does.
        swinging: those whose motion does.
        sides: for each of the latter the direction of its line, as a complex number of length one: from x towards y of the base.
        count: how many trials there are.
    """

    driven: Experiment
    swinging: Experiment
    sides: tuple[complex, ...]
    count: int

    @property
    def note(self) -> str:
        """What the prints are of."""
        return (
            f"the fingerprint is of the trials that stay on one line: commands {len(self.driven.runs)}, motions "
            f"{len(self.swinging.runs)} of {self.count}"
        )


def lines(experiment: Experiment) -> Lines:
    """What of the recordings in space is as in a plane; nothing, where no marker is on the backbone."""
    kept = [k for k, marker in enumerate(experiment.markers) if not marker.radius]
    dataset = replace(experiment.dataset, bending="plane", mount="hanging", torsion=np.inf)
    markers, noise = tuple(experiment.markers[k] for k in kept), experiment.noise[kept]
    driven, swinging, sides = [], [], []
    for run in experiment.runs if kept else ():
        bends, reach = _bent(run, base_rotations(Arms.of([ArmSpecification.from_trial(experiment.dataset, run.trial)]))[0], kept)
        side = _of_command(run)
        if side:
            driven.append(_flat(run, bends, reach, side, kept))
        side = _of_motion(bends, reach, noise)
        if side:
            swinging.append(_flat(run, bends, reach, side, kept))
            sides.append(side)
    made = replace(experiment, dataset=dataset, markers=markers, noise=noise)
    on_lines = replace(made, runs=tuple(driven)), replace(made, runs=tuple(swinging))
    return Lines(*on_lines, tuple(sides), len(experiment.runs))


def _bent(run: Run, axes: Array, kept: list[int]) -> tuple[Array, Array]:
    """(T + 1, M) complex bending [rad] of each marker, towards x and towards y, and its distance from the base [m].

    ``axes`` (3, 3) are the base's. The last row is of the pose that a run starts from; NaN without one.
    """
    start = np.full((1, len(kept), 3), np.nan) if run.start_pose is None else run.start_pose[None, kept]
    x, y, along = np.moveaxis(np.concatenate([run.measured[:, kept], start]) @ axes, -1, 0)
    aside = x + 1j * y
    size = np.abs(aside)
    with np.errstate(invalid="ignore"):  # what was not seen
        return 2 * np.arctan2(size, along) * aside / np.maximum(size, 1e-12), np.hypot(size, along)


def _of_command(run: Run) -> complex:
    """The direction of the line through no torque on which a command stays; 0: on none."""
    largest = run.torque[np.argmax(np.abs(run.torque))]
    if not abs(largest) > 0 or not run.span > 0 or run.by_section is not None:  # sections driven apart are on no one line
        return 0j
    side = complex(largest / abs(largest))
    return side if np.abs((run.torque * np.conj(side)).imag).max() < _COMMAND * abs(largest) else 0j


def _of_motion(bends: Array, reach: Array, noise: Array) -> complex:
    """The direction of the line on which the farthest marker moves that was seen for a good part of a run; 0: on none."""
    seen = np.isfinite(bends[:-1])
    often = np.flatnonzero(seen.sum(axis=0) >= 0.5 * seen.sum(axis=0).max())
    marker = max(often, key=lambda k: np.nanmedian(reach[:, k]))
    path = bends[:-1, marker][seen[:, marker]]
    path = path - path.mean()
    spread = np.cov(np.stack([path.real, path.imag]))
    (less, more), ways = np.linalg.eigh(spread)
    grain = 2 * float(noise[marker]) / max(float(np.nanmedian(reach[:, marker])), 1e-9)
    narrow = np.sqrt(max(less, 0.0)) < max(_MOTION * np.sqrt(max(more, 0.0)), _NOISES * grain)
    return complex(*ways[:, 1]) if narrow and np.sqrt(more) > 5 * grain else 0j


def _flat(run: Run, bends: Array, reach: Array, side: complex, kept: list[int]) -> Run:
    """A run on a line as a hanging arm in a plane shows it, which bends towards x."""
    angle = (bends * np.conj(side)).real / 2
    places = np.stack([reach * np.sin(angle), np.zeros_like(angle), -reach * np.cos(angle)], axis=-1)
    return replace(
        run,
        torque=(run.torque * np.conj(side)).real,
        measured=places[:-1],
        start_pose=None if run.start_pose is None else places[-1],
        start_velocity=None,
        axes=(0, 2),
        found_poses={},
        declared={},
    )

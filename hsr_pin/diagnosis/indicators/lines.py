"""Conversion of trials of an arm in space that stay on one line into recordings of a planar arm.

Along one line, a law about two axes acts as in a plane, so that times, loops and decays can be evaluated in the same way. Other
trials are not used: an oscillation on an ellipse is not a decay, and a rotating command produces loops without any friction. The
bending to each side is defined as in a plane: twice the angle at which a marker is seen.
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

#: Largest deviation from a line: of a command as a share of its size; of a motion as a share of its RMS size, or in standard
#: deviations of noise.
_COMMAND, _MOTION, _NOISES = 0.02, 0.1, 2.0


@dataclass(frozen=True, eq=False)
class Lines:
    """Trials of an arm in space that stay on a line, in the form of planar recordings.

    Attributes:
        driven: trials whose command stays on a line.
        swinging: trials whose motion stays on a line.
        sides: for each of the latter the direction of its line as a complex number of length one, from x towards y of the base.
        count: number of all trials.
    """

    driven: Experiment
    swinging: Experiment
    sides: tuple[complex, ...]
    count: int

    @property
    def note(self) -> str:
        """Note on the trials that the indicators use."""
        return (
            f"the model-free indicators use trials that stay on one line: {len(self.driven.runs)} commands and "
            f"{len(self.swinging.runs)} motions of {self.count} trials"
        )


def lines(experiment: Experiment) -> Lines:
    """Return the recordings in space that can be evaluated as in a plane; none if no marker is on the backbone."""
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
    """Return the complex bending (T + 1, M) of each marker towards x and y [rad], and its distance from the base [m].

    ``axes`` (3, 3) are those of the base. The last row belongs to the initial pose; NaN without one.
    """
    start = np.full((1, len(kept), 3), np.nan) if run.start_pose is None else run.start_pose[None, kept]
    x, y, along = np.moveaxis(np.concatenate([run.measured[:, kept], start]) @ axes, -1, 0)
    aside = x + 1j * y
    size = np.abs(aside)
    with np.errstate(invalid="ignore"):  # NaN where a marker was not visible
        return 2 * np.arctan2(size, along) * aside / np.maximum(size, 1e-12), np.hypot(size, along)


def _of_command(run: Run) -> complex:
    """Return the direction of the line through zero torque on which a command stays; 0 if it leaves every line."""
    largest = run.torque[np.argmax(np.abs(run.torque))]
    if not abs(largest) > 0 or not run.span > 0 or run.by_section is not None:  # separately driven sections have no common line
        return 0j
    side = complex(largest / abs(largest))
    return side if np.abs((run.torque * np.conj(side)).imag).max() < _COMMAND * abs(largest) else 0j


def _of_motion(bends: Array, reach: Array, noise: Array) -> complex:
    """Return the direction of the line on which the outermost marker moves, among those that were often visible; 0 if none."""
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
    """Return a run on a line in the form of a planar hanging arm that bends towards x."""
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

"""Writer of markers and datasets in the recording format, version 1 or, in space, 2; the files do not contain the laws."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hsr_pin.errors import OutputError

from .arm import Arm, Array, Motion
from .laws.law import Law, acting
from .program import Program, Trial, pressures


@dataclass(frozen=True)
class Marker:
    """A tracked point with its name and declared arc length [m].

    In space it may be at a distance `radius` [m] from the backbone, at an `angle` from x towards y of its section [rad].
    """

    name: str
    arc_length: float
    radius: float = 0.0
    angle: float = 0.0


MARKERS = (Marker("base", 0.0), Marker("mid", 0.12), Marker("tip", 0.24))


def observe(motion: Motion, arm: Arm, laws: Sequence[Law], markers: Sequence[Marker], error: Array) -> Array:
    """Return marker points (T, M, 3) in the world [m], without noise.

    Args:
        motion: motion of the arm.
        arm: the true arm.
        laws: laws, some of which may move markers or cameras.
        markers: M markers.
        error: (M, 2) error of each marker's place, along and off the backbone [m].
    """
    points = []
    for marker, (along, off) in zip(markers, error, strict=True):
        arc = float(np.clip(marker.arc_length + along, 0.0, arm.length))
        angle = motion.angle_at(arc)
        shifts = [law.shift(marker.arc_length / arm.length, angle) for law in acting(laws, "shift")]
        x, z = motion.at(arc, off + sum(each[1] for each in shifts), sum(each[0] for each in shifts))
        x = x + sum(law.base(motion.t) for law in acting(laws, "base"))
        points.append(arm.to_world(x, z))
    return filmed(np.stack(points, axis=1), laws)


def filmed(points: Array, laws: Sequence[Law]) -> Array:
    """Return points (T, M, 3) in the world [m] as the cameras see them."""
    for law in laws:
        points = law.seen(points)
    return points


def write(folder: Path, program: Program, arm: Arm, markers: Sequence[Marker], points: Sequence[Array]) -> Path:
    """Write one dataset with the name of its folder, from points (T, M, 3) [m] of each trial."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for i, (trial, seen) in enumerate(zip(program.trials, points, strict=True), start=1):
            text = _csv(trial, program.given, markers, seen)
            (folder / f"trial_{i:02d}.csv").write_text(text, encoding="utf-8", newline="\n")
        toml = _toml(folder.name, program, arm, markers)
        (folder / "dataset.toml").write_text(toml, encoding="utf-8", newline="\n")
    except OSError as error:
        raise OutputError("dataset", expected="a writable folder", received=str(error), file=folder) from error
    return folder


def _csv(trial: Trial, given: str, markers: Sequence[Marker], seen: Array) -> str:
    t = np.arange(trial.samples) / 100
    names, columns = ["t"], [t]
    tau = trial.torque()
    if trial.command and np.iscomplexobj(tau):
        names += ["tau_x", "tau_y"]
        columns += [tau.real, tau.imag]
    elif trial.command:
        inputs = pressures(tau, trial.keq) if given == "pressures" else (tau,)
        names += ["P1", "P2"] if given == "pressures" else ["tau"]
        columns += inputs
    for m, marker in enumerate(markers):
        names += [f"{marker.name}_{axis}" for axis in "xyz"]
        columns += list(seen[:, m].T)
    rows = (",".join(f"{value:.6f}" for value in row) for row in np.stack(columns, axis=1))
    return "\n".join([",".join(names), *rows]) + "\n"


def _toml(name: str, program: Program, arm: Arm, markers: Sequence[Marker]) -> str:
    space = arm.gravity().size == 3
    lines = [f"format = {1 + space}", f'name = "{name}"', "", "[robot]"]
    if space:  # its springs are the same about every axis
        lines += ['bending = "space"', f"torsion = {program.trials[0].keq}  # Nm/rad"]
    lines += [f"length = {arm.length}  # m", f"mass = {arm.mass}  # kg"]
    lines += [f"diameter = {arm.diameter}  # m", f'mount = "{program.mount}"']
    for marker in markers:
        lines += [
            "",
            "[[marker]]",
            f'name = "{marker.name}"',
            f"arc_length = {marker.arc_length}  # m",
        ]
        if marker.radius:
            lines += [f"radius = {marker.radius}  # m", f"angle = {marker.angle}  # rad"]
    for i, trial in enumerate(program.trials, start=1):
        lines += ["", "[[trial]]", f'file = "trial_{i:02d}.csv"', f"keq = {trial.keq}  # Nm/rad"]
        lines += [f"damping = {trial.damping}  # Nm s/rad, whole arm"]
        if trial.tip_mass:
            lines += [f"tip_mass = {trial.tip_mass}  # kg"]
        if trial.release:
            lines += [f"t_start = {round(trial.release + trial.start_error, 3)}  # s, released"]
    return "\n".join(lines) + "\n"

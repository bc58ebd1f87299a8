"""Contradictions between declared values and recordings: wrong units of stiffness or damping, and motion before its command."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hsr_pin.recordings.lag import find_lag, second_order_response
from hsr_pin.recordings.plausible import THOUSAND
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array, Dataset, Marker

if TYPE_CHECKING:
    from hsr_pin.identification.prepared import Run

#: A declared value is wrong by a factor of a thousand if the changed value leaves less than the first share of the variance that
#: the declared one leaves, and less than the second share of the variance of the motion.
CLEARLY, FOLLOWS = 0.25, 0.5
#: Alternatives that leave at most this multiple of the smallest variance explain the motion equally well.
ALIKE = 1.5
_GRAVITY = 9.81
#: Sign of the stiffness that gravity adds to a bent arm.
_PULLS = {"hanging": 1, "upright": -1, "horizontal": 0, "flat": 0}


def contradictions(dataset: Dataset, runs: Sequence[Run], markers: Sequence[Marker]) -> tuple[str, ...]:
    """Return sentences about declared values that contradict the recordings.

    Args:
        dataset: the dataset of the runs.
        runs: its trials.
        markers: the markers that are compared.
    """
    far = max(range(len(markers)), key=lambda index: markers[index].arc_length)
    runs = [run for run in runs if np.isfinite(run.measured[:, far]).all(axis=1).sum() > 2]
    bends = [_bending(run.measured[:, far], dataset) * dataset.length / markers[far].arc_length for run in runs]
    levels = dict.fromkeys((run.trial.keq, run.trial.damping) for run in runs)
    groups = [[k for k, run in enumerate(runs) if (run.trial.keq, run.trial.damping) == level] for level in levels]
    wrong = [_unit_error(dataset, [runs[k] for k in group], [bends[k] for k in group]) for group in groups]
    notes = [sentence for sentence in wrong if sentence]
    lags = [find_lag(run.time, run.torque, run.time, bend, signed=True) for run, bend in zip(runs, bends, strict=True)]
    early = {run.trial.name: lag for run, lag in zip(runs, lags, strict=True) if lag is not None and lag.is_early}
    if early:
        lead, sigma = (float(np.median([abs(getattr(lag, name)) for lag in early.values()])) for name in ("value", "sigma"))
        finding = f"{_named(list(early))}: the motion begins {lead:.3g} s (+- {sigma:.1g} s) before its command"
        notes.append(f"{finding}; the input may have been logged late (hsr-import --input-offset shifts it)")
    return tuple(notes)


def _named(trials: Sequence[str]) -> str:
    return ", ".join(trials[:3]) + (f" and {len(trials) - 3} more" if len(trials) > 3 else "")


def _bending(places: Array, dataset: Dataset) -> Any:
    """Return the bending (T,) [rad] of an arm of uniform curvature with its marker at (T, 3) [m]; complex in space."""
    along, across = mount_frame(dataset.mount)
    aside = places @ across + (1j * (places @ np.cross(along, across)) if len(dataset.axes) == 3 else 0.0)
    if np.iscomplexobj(aside):
        size = np.abs(aside)
        return 2 * np.arctan2(size, places @ along) * aside / np.where(size > 0, size, 1.0)
    return 2 * np.arctan2(aside, places @ along)


def _unit_error(dataset: Dataset, runs: Sequence[Run], bends: Sequence[Any]) -> str:
    """Return a sentence if a stiffness or damping a thousand times as large or small explains these runs, else an empty text."""
    less, more, trial = 1 / THOUSAND, THOUSAND, runs[0].trial
    keq, damping = trial.keq, trial.damping or 0.0
    factors = [(less, 1.0), (more, 1.0), *([(1.0, less), (1.0, more), (less, less), (more, more)] if damping else [])]
    unexplained = {each: _unexplained(dataset, runs, bends, *each) for each in factors}
    least = min(unexplained.values())
    if not least < min(FOLLOWS, CLEARLY * _unexplained(dataset, runs, bends, 1.0, 1.0)):
        return ""
    meant = []
    for stiffer, damper in (each for each in factors if unexplained[each] <= ALIKE * least):
        names = [f"keq of {stiffer * keq:.3g} Nm/rad"] if stiffer != 1 else []
        names += [f"damping of {damper * damping:.3g} Nm s/rad"] if damper != 1 else []
        meant.append(" with ".join(names))
    declared = f"keq {keq:g} Nm/rad" + (f" and damping {damping:g} Nm s/rad" if damping else "")
    return (
        f"{_named([run.trial.name for run in runs])}: the declaration is {declared}, but the recorded motion fits "
        f"{' or '.join(meant)}; check the units: a value may be in N mm, or torques or pressures not in N m and bar"
    )


def _unexplained(dataset: Dataset, runs: Sequence[Run], bends: Sequence[Any], stiffer: float, damper: float) -> float:
    """Return the share of the variance of bending that a one-mode model with these factors on the declared values leaves.

    The mode is uniform curvature: with a bending angle phi of the whole arm, a point at s of a length L moves s^2 phi / 2 L
    sideways and s^3 phi^2 / 6 L^2 back along the arm; inertia and weight follow by integration along the arm.
    """
    length, unexplained, whole = dataset.length, 0.0, 0.0
    for run, bend in zip(runs, bends, strict=True):
        keq, load = stiffer * run.trial.keq, run.trial.tip_mass
        inertia = (dataset.mass / 20 + load / 4) * length**2
        weight = _PULLS[dataset.mount] * (dataset.mass / 12 + load / 3) * _GRAVITY * length
        if keq + weight <= 0:
            return np.inf
        torque = run.torque * (stiffer if run.trial.trajectory.pressures is not None else 1.0)
        drive = (torque - torque[0]) / (keq + weight)
        seen = np.isfinite(bend)
        if run.start_pose is not None:  # a release is equivalent to the end of a holding torque
            drive[1:] = drive[1:] - bend[seen][0] + np.mean(bend[seen][-len(bend) // 10 :])
        critical = 2 * np.sqrt((keq + weight) * inertia)
        ratio = damper * run.trial.damping / critical if run.trial.damping else 1.0
        answer = second_order_response(drive, run.step, float(np.sqrt((keq + weight) / inertia)), ratio)
        unexplained += float(np.var((bend - answer)[seen])) * seen.sum()
        whole += float(np.var(bend[seen])) * seen.sum()
    return unexplained / whole if whole else 0.0

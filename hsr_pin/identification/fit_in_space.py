"""Numbers of an arm in space from its releases: least squares over the distances of all markers, without intervals yet.

Each release is followed from the pose and the motion that its markers show, as :mod:`hsr_pin.identification.release` tells them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from hsr_pin.effects.effect import Effect
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.pose_in_space import poses_in_space
from hsr_pin.identification.release import start_of
from hsr_pin.recordings.noise import noise_per_axis
from hsr_pin.robot.space_kinematics import space_marker_map
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import Pose, Scenario
from hsr_pin.simulation.sensitivity import parameter_of, sensitivities, value_of, with_value
from hsr_pin.trajectory import Array, Dataset, Trial

#: Elements of the chain.
LINKS = 8
#: The arm may curl up in a search [rad].
_FURTHEST = 20.0
#: For swings that die away; error of a step [m].
_METHOD = {"integrator": "extrapolated4", "tolerance": 2e-4}
#: A marker of a simulation that failed is this far off [m].
_LOST = 0.3
#: Evaluations of a search.
_MOST = 40


@dataclass(frozen=True, eq=False)
class Release:
    """A trial from shortly after its release on.

    Attributes:
        trial: as recorded.
        time: (T,) [s].
        measured: (T, M, 3) [m].
        pose, velocity: (M, 3) [m], [m/s] of the markers at its start.
    """

    trial: Trial
    time: Array
    measured: Array
    pose: Array
    velocity: Array


@dataclass(frozen=True, eq=False)
class SpaceFit:
    """What was found.

    Attributes:
        values: by the names that were free.
        effects: with their values.
        links: of the chain.
        errors: RMS distance of the markers [m] by trial.
    """

    values: dict[str, float]
    effects: tuple[Effect, ...]
    links: int
    errors: dict[str, float]

    @property
    def rms(self) -> float:
        """Of all trials [m]."""
        return float(np.sqrt(np.mean(np.square(list(self.errors.values())))))

    def predicted(self, dataset: Dataset, releases: Sequence[Release]) -> SpaceFit:
        """The same numbers judged by other releases, none of which they were fitted to."""
        scenarios = _with_values(_scenarios(dataset, releases, self.effects, self.links), self.values)
        return replace(self, errors=_errors(releases, simulate_batch(scenarios, **_METHOD)))  # type: ignore[arg-type]


def releases_of(dataset: Dataset, *, delay: float = 0.1, duration: float = 2.0) -> list[Release]:
    """The free motions of a dataset, each followed for ``duration`` [s] from ``delay`` [s] after its declared start.

    Raises:
        IdentificationError: no trial without an input lasts so long.
    """
    found = []
    for trial in dataset.trials:
        motion = trial.trajectory
        start = start_of(trial, float(np.nanmax(noise_per_axis(trial))), delay)
        end = start.sample + round(duration / motion.step) + 1
        if not motion.has_input and end <= len(motion.time):
            window = slice(start.sample, end)
            found.append(Release(trial, motion.time[window], motion.positions[window], start.pose, start.velocity))
    if not found:
        raise IdentificationError("trials", expected=f"one without an input that goes on for {duration:g} s", received="none")
    return found


def fit_in_space(
    dataset: Dataset,
    releases: Sequence[Release],
    free: Sequence[str] = ("keq", "damping", "mass"),
    effects: Sequence[Effect] = (),
    links: int = LINKS,
) -> SpaceFit:
    """Fit numbers of the arm and its effects to releases.

    Args:
        dataset: that declares the arm.
        releases: of it; all count alike.
        free: names as for :func:`hsr_pin.simulation.sensitivity.sensitivities`; each has one value for all releases.
        effects: where their search begins.
        links: of the chain.

    Raises:
        InputError: an unknown name.
    """
    scenarios = _scenarios(dataset, releases, tuple(effects), links)
    facts = [parameter_of(scenarios[0], name) for name in free]
    begin = np.array([value_of(scenarios[0], name) for name in free])
    scale = np.array([0.2 * b if not fact.amplitude and b else fact.scale for fact, b in zip(facts, begin, strict=True)])
    latest: dict[bytes, tuple[Array, Array]] = {}

    def evaluated(x: Array) -> tuple[Array, Array]:
        key = x.tobytes()
        if key not in latest:
            latest.clear()
            latest[key] = _residuals(releases, _with_values(scenarios, dict(zip(free, x.tolist(), strict=True))), free)
        return latest[key]

    bounds = [fact.lower for fact in facts], [fact.upper for fact in facts]
    begin = np.clip(begin, *(np.array(side) for side in bounds))
    found = least_squares(
        lambda x: evaluated(x)[0], begin, lambda x: evaluated(x)[1], bounds=bounds, x_scale=scale, max_nfev=_MOST
    )
    values = dict(zip(free, found.x.tolist(), strict=True))
    best = _with_values(scenarios, values)
    return SpaceFit(values, best[0].effects, links, _errors(releases, simulate_batch(best, **_METHOD)))  # type: ignore[arg-type]


def _scenarios(dataset: Dataset, releases: Sequence[Release], effects: tuple[Effect, ...], links: int) -> list[Scenario]:
    more = {"links": links, "placement": "shifted", "bending": "space", "bending_limit": _FURTHEST}
    arms = [ArmSpecification.from_trial(dataset, each.trial, **more) for each in releases]
    beside = [marker.beside for marker in dataset.markers]
    places = space_marker_map(arms[0], [marker.arc_length for marker in dataset.markers], beside)
    noise = max(float(np.nanmax(noise_per_axis(each.trial))) for each in releases)
    poses, rates = poses_in_space(
        places, links, np.array([r.pose for r in releases]), np.array([r.velocity for r in releases]), noise
    )
    return [
        Scenario(arm, each.time, np.zeros((len(each.time), 2)), Pose(q, v), effects, dataset.markers)
        for arm, each, q, v in zip(arms, releases, poses, rates, strict=True)
    ]


def _with_values(scenarios: Sequence[Scenario], values: dict[str, float]) -> list[Scenario]:
    changed = list(scenarios)
    for name, value in values.items():
        changed = [with_value(scenario, name, value) for scenario in changed]
    return changed


def _residuals(releases: Sequence[Release], scenarios: Sequence[Scenario], free: Sequence[str]) -> tuple[Array, Array]:
    """Distances (m,) [m] along all axes, and (m, P) their derivatives."""
    results, slopes = sensitivities(scenarios, free, **_METHOD)  # type: ignore[arg-type]
    miss, change = [], []
    for each, result, slope in zip(releases, results, slopes, strict=True):
        shown = np.full(each.measured.shape, np.nan)
        shown[: len(result.trajectory.time)] = result.trajectory.positions
        seen = np.isfinite(each.measured)
        off = np.where(np.isfinite(shown), shown - each.measured, _LOST)
        miss.append(off[seen])
        change.append(np.nan_to_num(slope)[seen])
    return np.concatenate(miss), np.concatenate(change)


def _errors(releases: Sequence[Release], results: Sequence[object]) -> dict[str, float]:
    found = {}
    for each, result in zip(releases, results, strict=True):
        shown = result.trajectory.positions  # type: ignore[attr-defined]
        off = np.full(each.measured.shape[:2], _LOST)
        off[: len(shown)] = np.linalg.norm(shown - each.measured[: len(shown)], axis=2)
        found[each.trial.name] = float(np.sqrt(np.nanmean(off**2)))
    return found

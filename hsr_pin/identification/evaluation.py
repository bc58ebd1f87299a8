"""Predictions of a hypothesis for an experiment, with their derivatives with respect to the parameters."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hsr_pin.identification.holds import without_holds
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.nuisance import DISTURBANCE_SIGMAS, INSTANT_SIGMA, POSE_SIGMA, RELEASE_ENDS
from hsr_pin.identification.pose import pose_from_markers
from hsr_pin.identification.prepared import Prepared, Run
from hsr_pin.inference.problem import Prediction
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.command import Delivered
from hsr_pin.simulation.integrator import Integrator
from hsr_pin.simulation.motion import Dynamics, Engine
from hsr_pin.trajectory import Array

#: Step of finite differences relative to a parameter's scale; it is large enough to average over the corners of friction and stop
#: laws.
FRACTION = 0.02
#: Step of finite differences for the parameters of a trial [rad of the whole arm].
_WIDTH = 0.01
#: If a torque bends an arm by less than this share of what it would without gravity, it hardly determines where the arm rests.
_COMPLIANT = 0.2


class Case(NamedTuple):
    """One run with several parameter values to simulate.

    Attributes:
        run: the run whose input is used.
        values: (C, P) values of the open parameters.
        extra_bending: (C,) bending of the arm before its release in addition to the measured one [rad]; complex in space.
        extra_torque: (C,) constant torque in addition to the delivered command [N m]; complex in space.
        release_torque: (C, H) additional torque in each interval after a release in which the release may be disturbed [N m];
            complex in space.
    """

    run: Run
    values: Array
    extra_bending: Array | None = None
    extra_torque: Array | None = None
    release_torque: Array | None = None


@dataclass(frozen=True, eq=False)
class Response:
    """The simulated motions of one run with several parameter values, at the selected samples.

    Attributes:
        batch: the C arms.
        cameras: the cameras that measure them.
        positions: (T, C, M, 3) marker positions [m]; NaN after a failure.
        angles, rates: (T, C, N) joint angles [rad] and rates [rad/s]; of arms in space (T, C, 3 N).
    """

    batch: ArmBatch
    cameras: Cameras
    positions: Array
    angles: Array
    rates: Array


def simulate_run(
    experiment: Prepared, run: Run, hypothesis: Hypothesis, values: Array, *, dynamics: Dynamics = "compiled"
) -> Response:
    """Simulate one run with the open parameters at each of ``values`` (C, P), with the steps that the first of them needs."""
    return next(simulate_cases(experiment, hypothesis, [Case(run, values)], dynamics))


def simulate_cases(
    experiment: Prepared, hypothesis: Hypothesis, cases: Iterable[Case], dynamics: Dynamics = "compiled"
) -> Iterator[Response]:
    """Simulate several cases; arms that two of them share are built once."""
    made: dict[object, tuple[Engine, Cameras]] = {}
    for case in cases:
        keq = hypothesis.factor("keq_scale", case.run, case.values)
        shared = hypothesis.declared(experiment, case.run), case.values.tobytes(), keq.tobytes()
        if shared not in made:
            batch = hypothesis.arm_batch(experiment, case.run, case.values)
            made[shared] = Engine(batch, dynamics), experiment.cameras(batch)
        yield _simulate_case(experiment, hypothesis, case, *made[shared])


def _simulate_case(experiment: Prepared, hypothesis: Hypothesis, case: Case, engine: Engine, cameras: Cameras) -> Response:
    run, values, batch = case.run, case.values, engine.batch
    command = _delivered(run, engine, hypothesis.factor("torque_gain", run, values))
    if case.extra_torque is not None:
        command = command.with_torque(case.extra_torque)
    if case.release_torque is not None:
        for part, (begin, end) in zip(case.release_torque.T, pairwise((0.0, *RELEASE_ENDS)), strict=True):
            command = command.with_torque_between(part, begin, end)
    found = np.ones(len(values), dtype=bool)
    q, v = _start(experiment, run, hypothesis, batch, cameras)
    if run.start_pose is None:
        q, found = engine.settled(command.initial, found, q)
    elif case.extra_bending is not None:
        q = q + batch.evenly(case.extra_bending)
    method = Integrator(tolerance=min(hypothesis.tolerance, run.tolerance))
    samples = len(run.time) + (run.lead > 0)
    motion = engine.run(engine.loaded(q, v), command, samples, method, found)
    shown = run.looked_at
    angles, rates = (at_samples(run, part)[shown] for part in (motion.angles, motion.rates))
    if run.smoothing is None:
        positions = cameras.positions(angles)
    else:
        positions = run.smoothing(cameras.positions(at_samples(run, motion.angles)))[shown]
    if np.isfinite(motion.lost).any():
        ends = (shown + run.lead + 1) * run.step
        positions[ends[:, None] > motion.lost] = np.nan
    return Response(batch, cameras, positions, angles, rates)


def _delivered(run: Run, engine: Engine, gain: Array) -> Delivered:
    """Return the delivered torque of a run's command with gains (C,); it is cached if it does not depend on the model."""
    smooth = engine.batch.states == 0  # laws with memory need the exact points of reversal
    if (gain == gain[0]).all():
        gain = gain[:1]
    plain = not engine.batch.actuator_effects and gain.tolist() == [1.0]
    if plain and smooth in run.delivered:
        return run.delivered[smooth]
    torque = without_holds(run.command) if run.interpolated else run.command
    if run.lead != 0:
        torque = np.concatenate([torque[:1], torque])
    flow = torque[:, None] * gain[:, None]
    if run.by_section is None:
        flow = flow[..., 0]  # the same for all
    command = engine.deliver(flow, flow[0], run.step, interpolated=run.interpolated, smooth=smooth)
    if plain:
        run.delivered[smooth] = command
    return command


def _start(experiment: Prepared, run: Run, hypothesis: Hypothesis, batch: ArmBatch, cameras: Cameras) -> tuple[Array, Array]:
    """Return the initial pose and its rate, (C, N) each, of arms in space (C, 3 N), from the measured markers.

    For a run that starts at rest, the pose is an initial guess for the equilibrium.
    """
    noise = float(experiment.noise.max())
    steering = tuple(effect for effect in hypothesis.effects if any(map(effect.acts_through, ("stiffness", "observe", "arm"))))
    if run.start_pose is None:  # an approximate pose suffices as initial guess
        steering, hypothesis = (), replace(hypothesis, effects=(), free=(), resized=())
    known = (hypothesis.links, hypothesis.placement, steering, hypothesis.free if steering else ())
    pose, velocity = (run.rest, np.zeros_like(run.rest)) if run.start_pose is None else (run.start_pose, run.start_velocity)
    assert velocity is not None
    if known not in run.found_poses:  # for the initial values of the model, so that the result does not depend on earlier calls
        first = hypothesis.arm_batch(experiment, run, hypothesis.start[None])
        run.found_poses[known] = pose_from_markers(first, experiment.cameras(first), pose, velocity, noise)
    q, v, modes = run.found_poses[known]
    if steering and run.start_pose is not None:
        return pose_from_markers(batch, cameras, pose, velocity, noise, modes)[:2]
    return np.tile(q, (len(batch), 1)), np.tile(v, (len(batch), 1))


def predict(experiment: Prepared, hypothesis: Hypothesis, cases: Sequence[tuple[Run, Array]]) -> list[Prediction]:
    """Simulate runs, each with its own values (P,) of the open parameters."""
    answers = simulate_cases(experiment, hypothesis, (Case(run, values[None]) for run, values in cases))
    return [Prediction(answer.positions[:, 0][..., experiment.axes]) for answer in answers]


def predict_all(experiment: Prepared, hypothesis: Hypothesis, values: Array) -> list[Prediction]:
    """Simulate every run with the open parameters at ``values`` (P,)."""
    return predict(experiment, hypothesis, [(run, values) for run in experiment.runs])


def predict_with_slopes(
    experiment: Prepared,
    hypothesis: Hypothesis,
    values: Array,
    *,
    central: bool = False,
    conditional: Sequence[bool] | None = None,
    own: bool = True,
) -> list[Prediction]:
    """Simulate every run at ``values`` (P,), with the derivatives with respect to the open parameters.

    The derivatives are one-sided differences, or ``central`` ones at twice the cost. ``conditional``: for each run, whether the
    disturbance of its release is among its own parameters; default: for every release, if the experiment has disturbed releases.
    ``own``: whether the parameters of the trials are included.
    """
    lower, upper = hypothesis.bounds
    width = FRACTION * hypothesis.scale
    width = np.where(
        [name.partition("@")[0].endswith("_scale") for name in hypothesis.free], np.minimum(width, width * values), width
    )
    ahead = np.where(values + width <= upper, width, -width)
    behind = np.where(values - ahead < lower, 2 * ahead, np.where(values - ahead > upper, 2 * ahead, -ahead))
    sides = (ahead, behind) if central else (ahead,)

    def acting(run: Run) -> list[int]:
        return [p for p, name in enumerate(hypothesis.free) if hypothesis.acts(name, run)]

    disturbed_runs = [experiment.has_conditional(run) for run in experiment.runs]
    if conditional is not None:
        disturbed_runs = [possible and included for possible, included in zip(disturbed_runs, conditional, strict=True)]

    def case(run: Run, disturbed: bool) -> Case:
        points = [values, *(values + side[p] * np.eye(len(values))[p] for side in sides for p in acting(run))]
        if not own:
            return Case(run, np.array(points))
        released = run.start_pose is not None
        ways = _WIDTH * np.array(experiment.directions if released or experiment.systematic else ())
        disturbances = np.kron(np.eye(len(RELEASE_ENDS)), ways[:, None]) if disturbed else np.zeros((0, len(RELEASE_ENDS)))
        rows = np.array([*points, *[values] * (len(ways) + len(disturbances))])
        aside = np.concatenate([np.zeros(len(points)), ways, np.zeros(len(disturbances))])
        if not released:
            return Case(run, rows, extra_torque=run.trial.keq * aside if len(ways) else None)
        release_torque = run.trial.keq * np.concatenate(
            [np.zeros((len(rows) - len(disturbances), len(RELEASE_ENDS))), disturbances]
        )
        return Case(run, rows, extra_bending=aside, release_torque=release_torque if len(disturbances) else None)

    predictions, cases = [], map(case, experiment.runs, disturbed_runs)
    for run, disturbed, answer in zip(
        experiment.runs, disturbed_runs, simulate_cases(experiment, hypothesis, cases), strict=True
    ):
        seen = answer.positions[..., experiment.axes]
        slopes, moved = np.zeros((*seen[:, 0].shape, len(values))), acting(run)
        for place, p in enumerate(moved):
            chord = (seen[:, 1 + place] - seen[:, 0]) / ahead[p]
            if central:
                other = (seen[:, 1 + len(moved) + place] - seen[:, 0]) / behind[p]
                chord = (ahead[p] * other - behind[p] * chord) / (ahead[p] - behind[p])
            slopes[..., p] = chord
        nuisance = _nuisance(experiment, run, answer, disturbed) if own else None
        predictions.append(Prediction(seen[:, 0], np.nan_to_num(slopes), nuisance))
    return predictions


def _nuisance(experiment: Prepared, run: Run, answer: Response, disturbed: bool) -> Array:
    """Return the effects (T, M, A, K) [m] of the parameters of a trial on the first arm, per standard deviation.

    The last arms, one for each direction, have an additional bending or torque.
    """
    length, seen = experiment.dataset.length, answer.positions[..., experiment.axes]
    columns, directions = [], experiment.directions
    disturbances = len(RELEASE_ENDS) * len(directions) if disturbed else 0
    asides = range(-len(directions) - disturbances, -disturbances)
    if experiment.systematic:
        for k, direction in zip(asides, directions, strict=True):
            columns.append(_rested(experiment, run, answer, k, direction))
    if run.start_pose is not None:
        held = np.hypot(POSE_SIGMA * length, float(experiment.noise.max()))
        for k in asides:
            columns.append((seen[:, k] - seen[:, 0]) / _WIDTH * 2 * held / length)
        columns.append(np.gradient(seen[:, 0], run.looked_at, axis=0) * INSTANT_SIGMA)
    if disturbances:
        aside = _aside(answer)
        for k in range(disturbances):
            columns.append((seen[:, k - disturbances] - seen[:, 0]) / _WIDTH * aside * DISTURBANCE_SIGMAS[k // len(directions)])
    return np.nan_to_num(np.stack(columns, axis=-1)) if columns else np.zeros((*seen[:, 0].shape, 0))


def _aside(answer: Response) -> float:
    """Return the initial bending of the first arm in excess of its mean bending [rad]."""
    further = answer.angles[0, 0] - answer.angles[:, 0].mean(axis=0)
    return float(np.abs(answer.batch.bends(further).sum()))


def _rested(experiment: Prepared, run: Run, answer: Response, k: int, direction: complex) -> Array:
    """Return the effect (T, M, A) [m] of one standard deviation of the resting position.

    A constant torque represents the deviation: it moves an arm with play far at rest, and hardly while it is driven. If the
    torque moves the arm by less than `_COMPLIANT` of what it would without gravity, and after a release, a constant additional
    bending is used instead.
    """
    length, axes = experiment.dataset.length, list(experiment.axes)
    if run.start_pose is None:
        pushed = answer.positions[:, k][..., axes] - answer.positions[:, 0][..., axes]
        far = float(np.linalg.norm(pushed[0, int(np.argmax(experiment.reach))]))
        if far > _COMPLIANT * _WIDTH * length / 2:
            return np.asarray(pushed / far * experiment.rest_scatter)
    bent = answer.batch.evenly(np.array([direction]))[None]
    change = answer.cameras.first.velocities(answer.angles[:, :1], bent)[:, 0][..., axes]
    return np.asarray(change * 2 * experiment.rest_scatter / length)


def at_samples(run: Run, values: Array) -> Array:
    """Interpolate values (T + 1, ...) on a grid that leads the samples by ``run.lead`` steps to the T samples (cubic)."""
    f = run.lead
    if f == 0:
        return values
    nodes = np.arange(-1, 3)
    weights = [np.prod([(f - m) / (n - m) for m in nodes if m != n]) for n in nodes]
    # the arm rests before the start: the value there equals the first one
    padded = np.concatenate([values[:1], values, 2 * values[-1:] - values[-2:-1]])
    count = len(run.time)
    return np.asarray(sum(w * padded[k : k + count] for k, w in enumerate(weights)))

"""What a hypothesis predicts for an experiment, and how far that is from what was measured, along its axes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from hsr_pin.identification.holds import unheld
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.nuisance import GRIP, HELD, INSTANT, LETS_GO
from hsr_pin.identification.pose import pose_from_markers
from hsr_pin.identification.prepared import Prepared, Run
from hsr_pin.inference.problem import Prediction
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.command import Delivered
from hsr_pin.simulation.integrator import Integrator
from hsr_pin.simulation.motion import Dynamics, Engine
from hsr_pin.trajectory import Array

#: Difference for derivatives over a parameter's scale: wide enough to average over the corners of sticking and stopping laws.
FRACTION = 0.02
#: Difference for derivatives to what belongs to a trial [rad of the whole arm].
_WIDTH = 0.01
#: Share of what a torque would bend an arm without gravity, below which it hardly says where the arm rests.
_GIVES = 0.2


class Case(NamedTuple):
    """What to simulate.

    Attributes:
        run: whose input.
        values: (C, P) of the open parameters.
        bent: (C,) [rad] how much further than the markers show the arm was held before its release; in space complex.
        pushed: (C,) [N m] torque beside what arrives of the command, always there; in space complex.
        gripped: (C, H) [N m] likewise in each stretch after a release in which a hand may still hold the arm.
    """

    run: Run
    values: Array
    bent: Array | None = None
    pushed: Array | None = None
    gripped: Array | None = None


@dataclass(frozen=True, eq=False)
class Response:
    """Arms that differ in their parameters, all under the input of one run, at its measured times (those that are looked at).

    Attributes:
        columns: the C arms.
        cameras: that see them.
        positions: (T, C, M, 3) [m] of the markers; NaN from a failure on.
        angles, rates: (T, C, N) [rad], [rad/s]; in space (T, C, 3 N).
    """

    columns: Columns
    cameras: Cameras
    positions: Array
    angles: Array
    rates: Array


def respond(
    experiment: Prepared, run: Run, hypothesis: Hypothesis, values: Array, *, dynamics: Dynamics = "compiled"
) -> Response:
    """Simulate one run with the open parameters at each of ``values`` (C, P); all take the steps that the first needs."""
    return next(respond_each(experiment, hypothesis, [Case(run, values)], dynamics))


def respond_each(
    experiment: Prepared, hypothesis: Hypothesis, cases: Iterable[Case], dynamics: Dynamics = "compiled"
) -> Iterator[Response]:
    """Likewise for each of some cases; arms that two of them share are made once."""
    made: dict[object, tuple[Engine, Cameras]] = {}
    for case in cases:
        keq = hypothesis.factor("keq_scale", case.run, case.values)
        shared = hypothesis.declared(experiment, case.run), case.values.tobytes(), keq.tobytes()
        if shared not in made:
            columns = hypothesis.columns(experiment, case.run, case.values)
            made[shared] = Engine(columns, dynamics), experiment.cameras(columns)
        yield _respond(experiment, hypothesis, case, *made[shared])


def _respond(experiment: Prepared, hypothesis: Hypothesis, case: Case, engine: Engine, cameras: Cameras) -> Response:
    run, values, columns = case.run, case.values, engine.columns
    command = _delivered(run, engine, hypothesis.factor("torque_gain", run, values))
    if case.pushed is not None:
        command = command.beside(case.pushed)
    if case.gripped is not None:
        for grip, (begin, end) in zip(case.gripped.T, pairwise((0.0, *LETS_GO)), strict=True):
            command = command.beside_at_first(grip, begin, end)
    found = np.ones(len(values), dtype=bool)
    q, v = _start(experiment, run, hypothesis, columns, cameras)
    if run.start_pose is None:
        q, found = engine.settled(command.initial, found, q)
    elif case.bent is not None:
        q = q + columns.evenly(case.bent)
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
    return Response(columns, cameras, positions, angles, rates)


def _delivered(run: Run, engine: Engine, gain: Array) -> Delivered:
    """What arrives of a run's command, with a gain (C,) of each; where all get it as it is, it is known from before."""
    smooth = engine.columns.states == 0  # what remembers the path must not miss where it turns
    if (gain == gain[0]).all():
        gain = gain[:1]
    plain = not engine.columns.muscles and gain.tolist() == [1.0]
    if plain and smooth in run.delivered:
        return run.delivered[smooth]
    torque = unheld(run.command) if run.interpolated else run.command
    if run.lead != 0:
        torque = np.concatenate([torque[:1], torque])
    flow = torque[:, None] * gain[:, None]
    if run.by_section is None:
        flow = flow[..., 0]  # the same for all
    command = engine.deliver(flow, flow[0], run.step, interpolated=run.interpolated, smooth=smooth)
    if plain:
        run.delivered[smooth] = command
    return command


def _start(experiment: Prepared, run: Run, hypothesis: Hypothesis, columns: Columns, cameras: Cameras) -> tuple[Array, Array]:
    """(C, N) each, in space (C, 3 N): the pose and its rate in which the markers are seen at the start.

    For a run at rest, about there.
    """
    noise = float(experiment.noise.max())
    steering = tuple(effect for effect in hypothesis.effects if any(map(effect.acts_through, ("stiffness", "observe", "arm"))))
    if run.start_pose is None:  # about where the arm rests is enough: it is settled from there
        steering, hypothesis = (), replace(hypothesis, effects=(), free=(), resized=())
    known = (hypothesis.links, hypothesis.placement, steering, hypothesis.free if steering else ())
    pose, velocity = (run.rest, np.zeros_like(run.rest)) if run.start_pose is None else (run.start_pose, run.start_velocity)
    assert velocity is not None
    if known not in run.found_poses:  # of the model as its fit starts: the same whatever was asked before
        first = hypothesis.columns(experiment, run, hypothesis.start[None])
        run.found_poses[known] = pose_from_markers(first, experiment.cameras(first), pose, velocity, noise)
    q, v, modes = run.found_poses[known]
    if steering and run.start_pose is not None:
        return pose_from_markers(columns, cameras, pose, velocity, noise, modes)[:2]
    return np.tile(q, (len(columns), 1)), np.tile(v, (len(columns), 1))


def predict(experiment: Prepared, hypothesis: Hypothesis, cases: Sequence[tuple[Run, Array]]) -> list[Prediction]:
    """Simulate runs, each with its own values (P,) of the open parameters."""
    answers = respond_each(experiment, hypothesis, (Case(run, values[None]) for run, values in cases))
    return [Prediction(answer.positions[:, 0][..., experiment.axes]) for answer in answers]


def predict_all(experiment: Prepared, hypothesis: Hypothesis, values: Array) -> list[Prediction]:
    """Simulate every run at ``values`` (P,)."""
    return predict(experiment, hypothesis, [(run, values) for run in experiment.runs])


def predict_with_slopes(
    experiment: Prepared,
    hypothesis: Hypothesis,
    values: Array,
    *,
    central: bool = False,
    shown: Sequence[bool] | None = None,
    own: bool = True,
) -> list[Prediction]:
    """Simulate every run at ``values`` (P,), with the derivatives to the open parameters.

    One-sided differences, or ``central`` ones at twice the price. ``shown``: for each run whether a hand's hold is among the
    numbers that belong to it; default: of every release, where the experiment has hands. ``own``: whether what belongs to the
    trials is asked for.
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

    hands = [experiment.shown(run) for run in experiment.runs]
    hands = hands if shown is None else [hand and grip for hand, grip in zip(hands, shown, strict=True)]

    def case(run: Run, hand: bool) -> Case:
        points = [values, *(values + side[p] * np.eye(len(values))[p] for side in sides for p in acting(run))]
        if not own:
            return Case(run, np.array(points))
        released = run.start_pose is not None
        ways = _WIDTH * np.array(experiment.directions if released or experiment.lasting else ())
        grips = np.kron(np.eye(len(LETS_GO)), ways[:, None]) if hand else np.zeros((0, len(LETS_GO)))
        rows = np.array([*points, *[values] * (len(ways) + len(grips))])
        aside = np.concatenate([np.zeros(len(points)), ways, np.zeros(len(grips))])
        if not released:
            return Case(run, rows, pushed=run.trial.keq * aside if len(ways) else None)
        gripped = run.trial.keq * np.concatenate([np.zeros((len(rows) - len(grips), len(LETS_GO))), grips])
        return Case(run, rows, bent=aside, gripped=gripped if len(grips) else None)

    predictions, cases = [], map(case, experiment.runs, hands)
    for run, hand, answer in zip(experiment.runs, hands, respond_each(experiment, hypothesis, cases), strict=True):
        seen = answer.positions[..., experiment.axes]
        slopes, moved = np.zeros((*seen[:, 0].shape, len(values))), acting(run)
        for place, p in enumerate(moved):
            chord = (seen[:, 1 + place] - seen[:, 0]) / ahead[p]
            if central:
                other = (seen[:, 1 + len(moved) + place] - seen[:, 0]) / behind[p]
                chord = (ahead[p] * other - behind[p] * chord) / (ahead[p] - behind[p])
            slopes[..., p] = chord
        nuisance = _nuisance(experiment, run, answer, hand) if own else None
        predictions.append(Prediction(seen[:, 0], np.nan_to_num(slopes), nuisance))
    return predictions


def _nuisance(experiment: Prepared, run: Run, answer: Response, hand: bool) -> Array:
    """(T, M, A, K) [m] for the first of the columns; the last, one for each direction, were held or are pushed aside."""
    length, seen = experiment.dataset.length, answer.positions[..., experiment.axes]
    columns, directions = [], experiment.directions
    hands = len(LETS_GO) * len(directions) if hand else 0
    asides = range(-len(directions) - hands, -hands)
    if experiment.lasting:
        for k, direction in zip(asides, directions, strict=True):
            columns.append(_rested(experiment, run, answer, k, direction))
    if run.start_pose is not None:
        held = np.hypot(HELD * length, float(experiment.noise.max()))
        for k in asides:
            columns.append((seen[:, k] - seen[:, 0]) / _WIDTH * 2 * held / length)
        columns.append(np.gradient(seen[:, 0], run.looked_at, axis=0) * INSTANT)
    if hands:
        aside = _aside(answer)
        for k in range(hands):
            columns.append((seen[:, k - hands] - seen[:, 0]) / _WIDTH * aside * GRIP[k // len(directions)])
    return np.nan_to_num(np.stack(columns, axis=-1)) if columns else np.zeros((*seen[:, 0].shape, 0))


def _aside(answer: Response) -> float:
    """[rad] how much further the first of the columns is bent at the start than it is in the mean."""
    further = answer.angles[0, 0] - answer.angles[:, 0].mean(axis=0)
    return float(np.abs(answer.columns.bends(further).sum()))


def _rested(experiment: Prepared, run: Run, answer: Response, k: int, direction: complex) -> Array:
    """(T, M, A) [m] what becomes of a place of rest that is off by one standard deviation.

    A torque made it so, and goes on: an arm with play is moved far by it where it rests, and hardly where it is driven. Where it
    moves it by less than `_GIVES` of what it would without gravity, and after a release, the arm is bent by as much all the time.
    """
    length, axes = experiment.dataset.length, list(experiment.axes)
    if run.start_pose is None:
        pushed = answer.positions[:, k][..., axes] - answer.positions[:, 0][..., axes]
        far = float(np.linalg.norm(pushed[0, int(np.argmax(experiment.reach))]))
        if far > _GIVES * _WIDTH * length / 2:
            return np.asarray(pushed / far * experiment.rest_scatter)
    bent = answer.columns.evenly(np.array([direction]))[None]
    change = answer.cameras.first.velocities(answer.angles[:, :1], bent)[:, 0][..., axes]
    return np.asarray(change * 2 * experiment.rest_scatter / length)


def at_samples(run: Run, values: Array) -> Array:
    """Values (T + 1, ...) on a grid that leads the samples by ``run.lead`` steps, interpolated (cubic) to the T samples."""
    f = run.lead
    if f == 0:
        return values
    nodes = np.arange(-1, 3)
    weights = [np.prod([(f - m) / (n - m) for m in nodes if m != n]) for n in nodes]
    # before the start the arm rests: the sample there equals the first
    padded = np.concatenate([values[:1], values, 2 * values[-1:] - values[-2:-1]])
    count = len(run.time)
    return np.asarray(sum(w * padded[k : k + count] for k, w in enumerate(weights)))

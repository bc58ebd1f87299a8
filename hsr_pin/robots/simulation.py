"""Many simulations of one robot side by side, each with values and a stretch of a recording of its own.

A step is of second order: the articulated-body algorithm of Pinocchio is evaluated half a step ahead, with a speed extrapolated
from the step before. Friction counts implicitly, so that a joint that sticks costs no small steps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from hsr_pin.robots.cause import JointCause, Now, Sizes, Values
from hsr_pin.robots.friction import sliding
from hsr_pin.robots.robot import Robot
from hsr_pin.trajectory import Array

#: Longest step [s].
_LONGEST = 5e-3
#: A joint that is this fast [rad/s] has left its model.
_LOST = 1e3


@dataclass(frozen=True, eq=False)
class Stretch:
    """Part of a recording.

    Attributes:
        time: (N,) [s] of its samples.
        command: (N, n) recorded: torque [N m], or target of a servo [rad], NaN while it is off.
        before_time: (K,) [s] of what was recorded earlier, of which late commands know.
        before: (K, n) likewise.
        q: (n,) [rad] at the start, as the encoders show it.
        v: (n,) [rad/s] likewise.
        a: (n,) [rad/s^2] likewise.
        held: whether a command stays as it is until the next sample; else it goes straight there.
    """

    time: Array
    command: Array
    before_time: Array
    before: Array
    q: Array
    v: Array
    a: Array
    held: bool = False


@dataclass(frozen=True, eq=False)
class Case:
    """One simulation.

    Attributes:
        stretch: what is simulated.
        values: of all causes' parameters, by name.
        aside: (n,) [rad/s] by which the speed at the start differs from the shown one.
    """

    stretch: Stretch
    values: Mapping[str, float]
    aside: Array


def simulate(
    robot: Robot, causes: Sequence[JointCause], neutral: Mapping[str, float], sizes: Sizes, cases: Sequence[Case]
) -> list[Array]:
    """(N, n) [rad] what the encoders show in each case; NaN from where a simulation fails.

    Args:
        robot: as declared.
        causes: what may be missing.
        neutral: values of all their parameters with which nothing is.
        sizes: what is usual.
        cases: what is simulated.
    """
    answers: list[Array] = [np.empty(0)] * len(cases)
    by_length: dict[int, list[int]] = {}
    for k, case in enumerate(cases):
        by_length.setdefault(len(case.stretch.time), []).append(k)
    for own in by_length.values():
        active = _active(causes, neutral, [cases[k] for k in own])
        shown = _Side(robot, active, sizes, [cases[k] for k in own]).run()
        for k, seen in zip(own, shown, strict=True):
            answers[k] = seen
    return answers


class _Side:
    """Simulations of stretches with equally many samples."""

    def __init__(self, robot: Robot, causes: Sequence[JointCause], sizes: Sizes, cases: Sequence[Case]) -> None:
        self.robot, self.sizes, self.cases = robot, sizes, cases
        named = [case.values for case in cases]
        self.servo = robot.servo.numbers(robot.joints, named) if robot.servo else None
        self.limit = np.array(robot.servo.limit if robot.servo else ())
        self.causes = [(cause, Values(cause, robot.joints, named, sizes)) for cause in causes]
        self.groups = self._models()

    def _models(self) -> list[tuple[list[int], pin.ModelPool, Array]]:
        """Simulations that share their bodies: which, their model, and the inverse (G, n, n) of its mass matrix at the start."""
        count, columns = len(self.cases), []
        for cause, values in self.causes:
            columns += [each for each in (cause.bodies(values), cause.armature(values)) if each is not None]
        keys = np.hstack(columns) if columns else np.zeros((count, 0))
        groups: dict[bytes, list[int]] = {}
        for k, key in enumerate(keys):
            groups.setdefault(key.tobytes(), []).append(k)
        found = []
        for own in groups.values():
            model = self.robot.model.copy()
            for cause, values in self.causes:
                bodies, armature = cause.bodies(values), cause.armature(values)
                if bodies is not None:
                    cause.change_bodies(bodies[own[0]], self.robot.joints, model)
                if armature is not None:
                    model.armature = model.armature + self.robot.sorted(armature[own[0]])
            data, order = model.createData(), self.robot.order
            inverse = np.empty((len(own), model.nv, model.nv))
            for place, k in enumerate(own):
                half = np.triu(pin.computeMinverse(model, data, self.cases[k].stretch.q[order]))
                inverse[place] = half + half.T - np.diag(np.diag(half))
            found.append((own, pin.ModelPool(model, 1), inverse))
        return found

    def run(self) -> Array:
        """(B, N, n) [rad] what the encoders show."""
        command, step = self._command(), self._steps()
        straight = np.array([[not case.stretch.held] for case in self.cases])
        q = np.array([case.stretch.q for case in self.cases])
        v = np.array([case.stretch.v + case.aside for case in self.cases])
        moved = q + v
        for cause, values in reversed(self.causes):
            q, moved = cause.read(values, q), cause.read(values, moved)
        v = moved - q
        angles = np.empty((len(q), command.shape[1], q.shape[1]))
        angles[:, 0], last, self.states = q, np.zeros_like(q), [None for _ in self.causes]
        begin = Now(q, v, *self._drive(q, v, last, command[:, 0], 0 * step[:, :1]), 0 * step[:, :1])
        speeding = np.array([case.stretch.a for case in self.cases])
        self.states = [cause.start(values, begin, speeding) for cause, values in self.causes]
        q = q - self._beside()[0]
        with np.errstate(over="ignore", invalid="ignore"):
            for n in range(command.shape[1] - 1):
                parts = max(1, int(np.ceil(step[:, n].max() / _LONGEST - 1e-9)))
                h = step[:, n, None] / parts
                for part in range(parts):
                    at = straight * (part + 0.5) / parts
                    commanded = (1 - at) * command[:, n] + at * command[:, n + 1] if at.any() else command[:, n]
                    now = Now(q + h / 2 * v, v, *self._drive(q, v, last, commanded, h), h)
                    last = self._acceleration(now, v + h / 2 * last)
                    q, v = q + h * v + h**2 / 2 * last, v + h * last
                lost = ~(np.abs(v) < _LOST).all(axis=1)
                q[lost], v[lost], last[lost] = np.nan, 0.0, 0.0
                angles[:, n + 1] = q + self._beside()[0]
        for cause, values in self.causes:
            angles = cause.shown(values, angles)
        return angles

    def _drive(self, q: Array, v: Array, last: Array, command: Array, h: Array) -> tuple[Array, Array]:
        """(B, n) [N m] torque of the motors over a step h (B, 1) [s], and by how much it falls with the speed at its end."""
        torque, slope = command, np.zeros_like(q)
        if self.servo is not None:
            stiffness, damping = self.servo
            ahead, faster = self._beside()
            seen, turns, on = q + h / 2 * v + ahead, v + faster, np.isfinite(command)
            for cause, values in self.causes:
                seen = cause.shown(values, seen)
            torque = np.where(on, stiffness * (command - seen) - damping * turns, 0.0)
            slope = np.where(on, stiffness * h / 4 + damping / 2, 0.0)  # of the mean of both ends of the step
            full = torque - slope * h * last
            beyond = np.abs(full) > self.limit
            torque, slope = np.where(beyond, np.clip(full, -self.limit, self.limit), torque), np.where(beyond, 0.0, slope)
        for cause, values in self.causes:
            if (changed := cause.drive(values, torque)) is not None:
                torque, slope = changed[0], slope * changed[1]
        return torque, slope

    def _beside(self) -> tuple[Array | float, Array | float]:
        """(B, n) [rad] by which what the encoders sit on is ahead of the joints, and (B, n) [rad/s] motors of their speeds."""
        pairs = [(each, state) for each, state in zip(self.causes, self.states, strict=True) if state is not None]
        there = [found for (cause, values), state in pairs if (found := cause.beside(values, state)) is not None]
        return sum(ahead for ahead, _ in there), sum(faster for _, faster in there)

    def _acceleration(self, now: Now, ahead: Array) -> Array:
        """(B, n) [rad/s^2] over a step, from half a step ahead; friction as it is at its end."""
        robot, order, q, v, h = self.robot, self.robot.order, now.q, now.v, now.h
        torque, implicit = now.driven - robot.damping * ahead, now.slope
        if robot.friction.any():
            added, slope = sliding(robot.friction, v)
            torque, implicit = torque + added, implicit + slope
        own = [now if state is None else replace(now, state=state) for state in self.states]
        for (cause, values), at in zip(self.causes, own, strict=True):
            if (more := cause.torque(values, at)) is not None:
                torque, implicit = torque + more[0], implicit + more[1]
        q = np.nan_to_num(q)
        columns = [np.asfortranarray(each[:, order].T) for each in (q, ahead, torque)]
        found = np.empty_like(v)
        for these, pool, inverse in self.groups:
            whole = len(these) == len(v)
            a = pin.abaInParallel(1, pool, *(columns if whole else [np.asfortranarray(each[:, these]) for each in columns]))
            a = np.reshape(a, (v.shape[1], -1)).T
            slope = implicit[:, order] if whole else implicit[these][:, order]
            if slope.any():
                step = h if whole else h[these]
                a = np.linalg.solve(np.eye(a.shape[1]) + step[:, :, None] * inverse * slope[:, None, :], a[..., None])[..., 0]
            found[these] = a
        answer = np.empty_like(v)
        answer[:, order] = found
        self.states = [
            None if at.state is None else cause.after(values, at, answer)
            for (cause, values), at in zip(self.causes, own, strict=True)
        ]
        return answer

    def _steps(self) -> Array:
        return np.array([np.diff(case.stretch.time) for case in self.cases])

    def _command(self) -> Array:
        """(B, N, n) the command that acts."""
        same: dict[int, list[int]] = {}
        for k, case in enumerate(self.cases):
            same.setdefault(id(case.stretch), []).append(k)
        placed: dict[int, Array] = {}
        for own in same.values():
            stretch = self.cases[own[0]].stretch
            time = np.concatenate([stretch.before_time, stretch.time])
            given = np.concatenate([stretch.before, stretch.command])
            on = np.isfinite(given)
            command = np.repeat(_filled(time, given)[None] if not on.all() else given[None], len(own), axis=0)
            for cause, _ in self.causes:
                values = Values(cause, self.robot.joints, [self.cases[k].values for k in own], self.sizes)
                command = cause.command(values, time, command)
            command = np.where(on, command, np.nan) if not on.all() else command
            placed |= dict(zip(own, command[:, len(stretch.before) :], strict=True))
        return np.array([placed[k] for k in range(len(self.cases))])


def _filled(time: Array, values: Array) -> Array:
    """(N, n) values (N, n) with a straight line across what is missing."""
    whole = [(column, np.isfinite(column)) for column in values.T]
    return np.column_stack([np.interp(time, time[on], column[on]) if on.any() else 0 * time for column, on in whole])


def _active(causes: Sequence[JointCause], neutral: Mapping[str, float], cases: Sequence[Case]) -> list[JointCause]:
    """Causes that are there in any case."""
    names = list(neutral)
    values = np.array([list(map(case.values.__getitem__, names)) for case in cases])
    there = {
        name.partition(".")[0] for name, own in zip(names, (values != list(neutral.values())).any(axis=0), strict=True) if own
    }
    return [cause for cause in causes if cause.name in there]

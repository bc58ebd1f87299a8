"""Batch simulation of one robot, each case with its own parameter values and its own stretch of a recording.

The integrator is of second order. It evaluates Pinocchio's articulated-body algorithm at the midpoint, with a speed extrapolated
from the previous step. Friction is treated implicitly, so that sticking joints need no small steps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from hsr_pin.robots.cause import JointCause, Scales, StepStart, Values
from hsr_pin.robots.friction import sliding_friction
from hsr_pin.robots.robot import Robot
from hsr_pin.trajectory import Array

#: Longest step [s].
_LONGEST = 5e-3
#: Time over which the speed of a true angle follows from that of the shown one [s].
_SHORT = 1e-4
#: Speed of a joint at which a simulation counts as diverged [rad/s].
_DIVERGED = 1e3


@dataclass(frozen=True, eq=False)
class Stretch:
    """Part of a recording.

    Attributes:
        time: (N,) sampling times [s].
        command: (N, n) recorded torque [N m], or target angle of a servo [rad], NaN while the servo is off.
        before_time: (K,) times of the samples before the stretch [s], which delayed commands need.
        before: (K, n) commands at these times.
        q: (n,) encoder angles at the start [rad].
        v: (n,) speeds at the start from the encoder angles [rad/s].
        a: (n,) accelerations at the start from the encoder angles [rad/s^2].
        held: whether a command is held until the next sample; otherwise it is interpolated linearly.
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
    """One simulation of a batch.

    Attributes:
        stretch: part of a recording that is simulated.
        values: parameter values of all causes, by name.
        speed_error: (n,) correction of the initial speeds [rad/s].
        angle_error: (n,) correction of the initial angles [rad].
    """

    stretch: Stretch
    values: Mapping[str, float]
    speed_error: Array | float = 0.0
    angle_error: Array | float = 0.0


def simulate(
    robot: Robot, causes: Sequence[JointCause], neutral: Mapping[str, float], scales: Scales, cases: Sequence[Case]
) -> list[Array]:
    """Return the simulated encoder angles of each case, (N, n) [rad]; NaN from the sample at which a simulation diverges.

    Args:
        robot: the robot as declared.
        causes: causes that may be active.
        neutral: parameter values with which no cause is active.
        scales: typical magnitudes in the recordings.
        cases: simulations to run.
    """
    answers: list[Array] = [np.empty(0)] * len(cases)
    by_length: dict[int, list[int]] = {}
    for k, case in enumerate(cases):
        by_length.setdefault(len(case.stretch.time), []).append(k)
    for own in by_length.values():
        active = _active(causes, neutral, [cases[k] for k in own])
        shown = _Batch(robot, active, scales, [cases[k] for k in own]).run()
        for k, seen in zip(own, shown, strict=True):
            answers[k] = seen
    return answers


class _Batch:
    """Batch of simulations of stretches with the same number of samples."""

    def __init__(self, robot: Robot, causes: Sequence[JointCause], scales: Scales, cases: Sequence[Case]) -> None:
        self.robot, self.scales, self.cases = robot, scales, cases
        named = [case.values for case in cases]
        self.servo = robot.servo.numbers(robot.joints, named) if robot.servo else None
        self.limit = np.array(robot.servo.limit if robot.servo else ())
        self.causes = [(cause, Values(cause, robot.joints, named, scales)) for cause in causes]
        for cause, values in self.causes:
            if self.servo is not None and (factors := cause.servo(values)) is not None:
                self.servo = self.servo[0] * factors[0], self.servo[1] * factors[1]
        self.groups = self._models()

    def _models(self) -> list[tuple[list[int], pin.ModelPool, Array]]:
        """Return groups of simulations with equal bodies: their indices, model and initial inverse mass matrices (G, n, n)."""
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
                    model.armature = model.armature + self.robot.in_model_order(armature[own[0]])
            data, order = model.createData(), self.robot.order
            inverse = np.empty((len(own), model.nv, model.nv))
            for place, k in enumerate(own):
                half = np.triu(pin.computeMinverse(model, data, self.cases[k].stretch.q[order]))
                inverse[place] = half + half.T - np.diag(np.diag(half))
            found.append((own, pin.ModelPool(model, 1), inverse))
        return found

    def run(self) -> Array:
        """Return the simulated encoder angles, (B, N, n) [rad]."""
        command, step = self._command(), self._steps()
        linear = np.array([[not case.stretch.held] for case in self.cases])
        q = np.array([case.stretch.q + case.angle_error for case in self.cases])
        v = np.array([case.stretch.v + case.speed_error for case in self.cases])
        moved = q + _SHORT * v
        for cause, values in reversed(self.causes):
            q, moved = cause.true_angle(values, q), cause.true_angle(values, moved)
        v = (moved - q) / _SHORT
        angles = np.empty((len(q), command.shape[1], q.shape[1]))
        angles[:, 0], last, self.states = q, np.zeros_like(q), [None for _ in self.causes]
        begin = StepStart(q, v, *self._drive(q, v, last, command[:, 0], 0 * step[:, :1]), 0 * step[:, :1])
        accelerations = np.array([case.stretch.a for case in self.cases])
        self.states = [cause.initial_state(values, begin, accelerations) for cause, values in self.causes]
        q = q - self._encoder_lead()[0]
        with np.errstate(over="ignore", invalid="ignore"):
            for n in range(command.shape[1] - 1):
                parts = max(1, int(np.ceil(step[:, n].max() / _LONGEST - 1e-9)))
                h = step[:, n, None] / parts
                for part in range(parts):
                    at = linear * (part + 0.5) / parts
                    commanded = (1 - at) * command[:, n] + at * command[:, n + 1] if at.any() else command[:, n]
                    now = StepStart(q + h / 2 * v, v, *self._drive(q, v, last, commanded, h), h)
                    last = self._acceleration(now, v + h / 2 * last)
                    q, v = q + h * v + h**2 / 2 * last, v + h * last
                diverged = ~(np.abs(v) < _DIVERGED).all(axis=1)
                q[diverged], v[diverged], last[diverged] = np.nan, 0.0, 0.0
                angles[:, n + 1] = q + self._encoder_lead()[0]
        for cause, values in self.causes:
            angles = cause.encoder_reading(values, angles)
        return angles

    def _drive(self, q: Array, v: Array, last: Array, command: Array, h: Array) -> tuple[Array, Array]:
        """Return the motor torques over a step h (B, 1) [s], (B, n) [N m], and their decrease per speed at its end."""
        torque, slope = command, np.zeros_like(q)
        if self.servo is not None:
            stiffness, damping = self.servo
            lead, lead_rate = self._encoder_lead()
            seen, motor_speed, on = q + h / 2 * v + lead, v + lead_rate, np.isfinite(command)
            for cause, values in self.causes:
                seen = cause.encoder_reading(values, seen)
            torque = np.where(on, stiffness * (command - seen) - damping * motor_speed, 0.0)
            slope = np.where(on, stiffness * h / 4 + damping / 2, 0.0)  # for the mean of both ends of the step
            full = torque - slope * h * last
            beyond = np.abs(full) > self.limit
            torque, slope = np.where(beyond, np.clip(full, -self.limit, self.limit), torque), np.where(beyond, 0.0, slope)
        for cause, values in self.causes:
            if (changed := cause.drive(values, torque)) is not None:
                torque, slope = changed[0], slope * changed[1]
        return torque, slope

    def _encoder_lead(self) -> tuple[Array | float, Array | float]:
        """Return the lead of the encoders over the joints [rad], and the relative speed of the motors [rad/s], each (B, n)."""
        pairs = [(each, state) for each, state in zip(self.causes, self.states, strict=True) if state is not None]
        leads = [found for (cause, values), state in pairs if (found := cause.encoder_lead(values, state)) is not None]
        return sum(lead for lead, _ in leads), sum(rate for _, rate in leads)

    def _acceleration(self, now: StepStart, speed: Array) -> Array:
        """Return the accelerations over a step, (B, n) [rad/s^2], from the dynamics at midstep with implicit friction."""
        robot, order, q, v, h = self.robot, self.robot.order, now.q, now.v, now.h
        torque, implicit = now.motor_torque - robot.damping * speed, now.slope
        if robot.friction.any():
            added, slope = sliding_friction(robot.friction, v)
            torque, implicit = torque + added, implicit + slope
        own = [now if state is None else replace(now, state=state) for state in self.states]
        for (cause, values), at in zip(self.causes, own, strict=True):
            if (more := cause.torque(values, at)) is not None:
                torque, implicit = torque + more[0], implicit + more[1]
        q = np.nan_to_num(q)
        columns = [np.asfortranarray(each[:, order].T) for each in (q, speed, torque)]
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
            None if at.state is None else cause.next_state(values, at, answer)
            for (cause, values), at in zip(self.causes, own, strict=True)
        ]
        return answer

    def _steps(self) -> Array:
        return np.array([np.diff(case.stretch.time) for case in self.cases])

    def _command(self) -> Array:
        """Return the commands that act, (B, N, n)."""
        same: dict[int, list[int]] = {}
        for k, case in enumerate(self.cases):
            same.setdefault(id(case.stretch), []).append(k)
        placed: dict[int, Array] = {}
        for own in same.values():
            stretch = self.cases[own[0]].stretch
            time = np.concatenate([stretch.before_time, stretch.time])
            given = np.concatenate([stretch.before, stretch.command])
            on = np.isfinite(given)
            command = np.repeat(_gaps_filled(time, given)[None] if not on.all() else given[None], len(own), axis=0)
            for cause, _ in self.causes:
                values = Values(cause, self.robot.joints, [self.cases[k].values for k in own], self.scales)
                command = cause.command(values, time, command)
            command = np.where(on, command, np.nan) if not on.all() else command
            placed |= dict(zip(own, command[:, len(stretch.before) :], strict=True))
        return np.array([placed[k] for k in range(len(self.cases))])


def _gaps_filled(time: Array, values: Array) -> Array:
    """Return values (N, n) with missing samples interpolated linearly."""
    whole = [(column, np.isfinite(column)) for column in values.T]
    return np.column_stack([np.interp(time, time[on], column[on]) if on.any() else 0 * time for column, on in whole])


def _active(causes: Sequence[JointCause], neutral: Mapping[str, float], cases: Sequence[Case]) -> list[JointCause]:
    """Return the causes with a parameter that is not neutral in at least one case."""
    names = list(neutral)
    values = np.array([list(map(case.values.__getitem__, names)) for case in cases])
    names_active = {
        name.partition(".")[0] for name, own in zip(names, (values != list(neutral.values())).any(axis=0), strict=True) if own
    }
    return [cause for cause in causes if cause.name in names_active]

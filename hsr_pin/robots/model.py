"""Model of a robot whose missing causes can be explained; each trial is cut into stretches with their own initial states.

A long simulation of a robot drifts away from the recording if friction is low or badly known. Therefore each trial is cut into
stretches. Each stretch starts at an estimated angle and speed, whose errors are fitted within their priors (multiple shooting: H.
G. Bock, K. J. Plitt, A multiple shooting algorithm for direct solution of optimal control problems, IFAC 1984).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hsr_pin.explain.model import Model, Trial
from hsr_pin.recordings.noise import white_noise
from hsr_pin.robots.cause import JointCause, Scales
from hsr_pin.robots.causes import CAUSES
from hsr_pin.robots.declared import DECLARED
from hsr_pin.robots.read import RobotRecordings, RobotTrial
from hsr_pin.robots.simulation import Case, Stretch, simulate
from hsr_pin.robots.start import half_windows, starts
from hsr_pin.trajectory import Array

#: Lengths of a stretch that are tried, the longest first [s].
_LENGTHS = (2.0, 1.0, 0.5, 0.25)
#: The longest stretch is used at which the RMS error of the declared model is below this share of the motion.
_MAX_ERROR = 0.5
#: Maximum number of stretches; of more, an even selection is used.
_MAX_STRETCHES = 64
#: Duration of the known commands before a stretch [s].
_HISTORY = 0.5


@dataclass(frozen=True, eq=False)
class RobotModel:
    """Model that predicts stretches of the recordings of a robot; it can be pickled for other processes.

    Attributes:
        recordings: recordings of the robot.
        causes: causes that the declared model may lack.
        scales: typical magnitudes in the recordings.
    """

    recordings: RobotRecordings
    causes: tuple[JointCause, ...]
    scales: Scales

    @classmethod
    def of(cls, recordings: RobotRecordings, causes: Sequence[JointCause] = CAUSES) -> RobotModel:
        """Return the model for recordings, with the typical magnitudes computed from them."""
        return cls(recordings, tuple(causes), _scales(recordings))

    @property
    def as_model(self) -> Model:
        """The robot as a :class:`~hsr_pin.explain.model.Model` with its causes."""
        joints = self.recordings.robot.joints
        named = tuple(cause.as_cause(joints, self.scales) for cause in self.causes)
        return Model(
            self.predict,
            parameters=servo.parameters(joints) if (servo := self.recordings.robot.servo) else (),
            causes=named,
            name=self.recordings.name,
            units=dict.fromkeys(joints, "rad"),
            noise=dict(zip(joints, map(float, self.noise), strict=True)),
            tolerances=tuple(DECLARED.named(joints, self.scales)) if self.recordings.robot.accuracy else (),
            predict_many=self.predict_many,
        )

    @property
    def neutral(self) -> dict[str, float]:
        """Parameter values of all causes with which the declared model is unchanged."""
        joints = self.recordings.robot.joints
        return {
            f"{cause.name}.{fact.name}": fact.neutral for cause in self.causes for fact in cause.parameters(joints, self.scales)
        }

    def predict(self, values: Mapping[str, float], trial: Trial) -> Mapping[str, Array]:
        """Return the predicted encoder angles of one stretch, (N,) [rad] for each joint."""
        return self.predict_many([(values, trial)])[0]

    def predict_many(self, cases: Sequence[tuple[Mapping[str, float], Trial]]) -> list[Mapping[str, Array]]:
        """Return the predicted encoder angles of many stretches, simulated as one batch."""
        robot, exact = self.recordings.robot, dict.fromkeys(DECLARED.named(self.recordings.robot.joints, self.scales), 0.0)
        cases = [(exact | dict(values), trial) for values, trial in cases]
        asked = [
            Case(trial.inputs, values, *(np.array([values.get(of(joint), 0.0) for joint in robot.joints]) for of in _ERRORS))
            for values, trial in cases
        ]
        answers = simulate(robot, (*self.causes, DECLARED), self.neutral | exact, self.scales, asked)
        return [dict(zip(robot.joints, answer.T, strict=True)) for answer in answers]

    def trials(self, seconds: float | None = None) -> list[Trial]:
        """Return the recordings cut into stretches.

        Args:
            seconds: length of a stretch; default: the longest one at which the error of the declared model is small enough.
        """
        if seconds is not None:
            return self._cut(seconds)
        for length in _LENGTHS:
            trials = self._cut(length)
            if trials and self._relative_error(trials) < _MAX_ERROR:
                break
        return trials

    def _relative_error(self, trials: Sequence[Trial]) -> float:
        """Return the median over stretches of the declared model's RMS error, divided by the standard deviation of the motion."""
        answers = self.predict_many([(self.neutral, trial) for trial in trials])
        shares = []
        for trial, answer in zip(trials, answers, strict=True):
            errors = np.concatenate([answer[joint] - trial.measured[joint] for joint in trial.measured])
            motion = np.concatenate([np.asarray(each) - np.mean(each) for each in trial.measured.values()])
            shares.append(np.sqrt(np.mean(errors**2) / max(float(np.mean(motion**2)), 1e-12)))
        return float(np.median(np.nan_to_num(shares, nan=np.inf)))

    def _cut(self, seconds: float) -> list[Trial]:
        """Return stretches of a given length [s], evenly selected if there are more than the maximum number."""
        found = [stretch for trial in self.recordings.trials for stretch in self._stretches(trial, seconds)]
        count = min(_MAX_STRETCHES, len(found))
        return [found[round(k * (len(found) - 1) / max(count - 1, 1))] for k in range(count)]

    def _stretches(self, trial: RobotTrial, seconds: float) -> list[Trial]:
        """Return the stretches of one recording, all with the same number of samples."""
        step = float(np.median(np.diff(trial.time)))
        count, joints, found = round(seconds / step) + 1, self.recordings.robot.joints, []
        margin = half_windows(step)[-1]
        begins = range(margin, len(trial.time) - max(count, margin), count)
        if not begins:
            return []
        known = starts(trial.time, trial.position, begins, self.noise, self.resolution)
        own = {_start_speed(joint): float(each) for joint, each in zip(joints, known.speed_error, strict=True)}
        own |= {_start_angle(joint): float(each) for joint, each in zip(joints, known.angle_error, strict=True)}
        states = zip(begins, known.angle, known.speed, known.acceleration, strict=True)
        for number, (begin, position, speed, acceleration) in enumerate(states, 1):
            rows, earlier = slice(begin, begin + count), slice(max(0, begin - round(_HISTORY / step)), begin)
            stretch = Stretch(
                trial.time[rows],
                trial.command[rows],
                trial.time[earlier],
                trial.command[earlier],
                position,
                speed,
                acceleration,
                self.recordings.held,
            )
            found.append(
                Trial(
                    f"{trial.name} {number}",
                    trial.time[rows],
                    dict(zip(joints, trial.position[rows].T, strict=True)),
                    stretch,
                    {"trial": trial.name},
                    own,
                )
            )
        return found

    @cached_property
    def noise(self) -> Array:
        """Standard deviation of the noise of each encoder, (n,) [rad]."""
        white = np.nanmedian([white_noise(trial.position) for trial in self.recordings.trials], axis=0)
        return np.asarray(np.hypot(np.nan_to_num(white), self.resolution))

    @cached_property
    def resolution(self) -> Array:
        """Standard deviation of the rounding of each encoder, (n,) [rad]: of its smallest step."""
        steps = np.abs(np.concatenate([np.diff(trial.position, axis=0) for trial in self.recordings.trials]))
        smallest = np.min(np.where(steps > 0, steps, np.inf), axis=0)
        return np.asarray(np.where(np.isfinite(smallest), smallest, 0.0) / np.sqrt(12))


def _start_speed(joint: str) -> str:
    """Return the name of the parameter that corrects the initial speed of a joint in a stretch."""
    return f"start speed of {joint}"


def _start_angle(joint: str) -> str:
    """Return the name of the parameter that corrects the initial angle of a joint in a stretch."""
    return f"start angle of {joint}"


#: Names of the errors of an initial state, in the order of :class:`~hsr_pin.robots.simulation.Case`.
_ERRORS = (_start_speed, _start_angle)


def _scales(recordings: RobotRecordings) -> Scales:
    """Return the typical magnitudes in recordings."""
    robot, trials = recordings.robot, recordings.trials
    servo = robot.servo
    torque = np.concatenate([servo.torque(each.command, each.position) if servo else each.command for each in trials])
    speed = np.concatenate([np.diff(trial.position, axis=0) / np.diff(trial.time)[:, None] for trial in trials])
    angles = np.concatenate([trial.position for trial in trials])
    inertia, free_inertia = _inertia(recordings)
    return Scales(
        max_torque=np.abs(torque).max(axis=0),
        torque=np.maximum(np.sqrt(np.mean(torque**2, axis=0)), 0.01 * float(np.abs(torque).max()) or 1.0),
        speed=np.maximum(np.sqrt(np.mean(speed**2, axis=0)), 1e-3),
        min_angle=angles.min(axis=0),
        max_angle=angles.max(axis=0),
        mass=float(sum(inertia.mass for inertia in list(robot.model.inertias)[1:])) or 1.0,
        inertia=inertia,
        free_inertia=free_inertia,
        rotor_inertia=np.array(robot.rotor_inertia),
        encoders=robot.encoders,
        accuracy=robot.accuracy,
        interval=float(np.median(np.concatenate([np.diff(trial.time) for trial in trials]))),
        declared_servos=servo is not None and not servo.guessed,
    )


def _inertia(recordings: RobotRecordings) -> tuple[Array, Array]:
    """Return the inertia at each joint with the others fixed, and with them free, each (n,) [kg m^2], at the median pose."""
    import pinocchio as pin

    robot = recordings.robot
    middle = np.median(np.concatenate([trial.position for trial in recordings.trials]), axis=0)
    mass = pin.crba(robot.model, robot.model.createData(), middle[robot.order])
    mass = np.triu(mass) + np.triu(mass, 1).T
    seen, free_inertia = np.empty((2, len(robot.joints)))
    seen[robot.order], free_inertia[robot.order] = np.diag(mass), 1 / np.diag(np.linalg.inv(mass))
    return seen, free_inertia

"""A robot as a model whose missing causes can be explained: recordings cut into stretches that start anew.

Robots without enough friction, or with a badly known one, drift away from any simulation that runs for long. So each trial is cut
into stretches that start where the encoders show the robot to be, with a speed of their own (multiple shooting: H. G. Bock,
K. J. Plitt, A multiple shooting algorithm for direct solution of optimal control problems, IFAC 1984).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.explain.model import Model, Trial
from hsr_pin.recordings.noise import white_noise
from hsr_pin.robots.cause import JointCause, Sizes
from hsr_pin.robots.causes import CAUSES
from hsr_pin.robots.read import RobotRecordings, RobotTrial
from hsr_pin.robots.simulation import Case, Stretch, simulate
from hsr_pin.trajectory import Array

#: Lengths of a stretch that are tried [s], the longest first.
_LENGTHS = (2.0, 1.0, 0.5, 0.25)
#: The longest is taken in which the declared model is off by less than this share of what moves.
_OFF = 0.5
#: Stretches at most: of more, some spread evenly.
_MOST = 64
#: Samples on either side from which a speed is found, and seconds of torque that are known before a stretch.
_SIDE, _BEFORE = 6, 0.5
#: Uncertainty of a speed at the least, over what is usual.
_UNSURE = 0.01


@dataclass(frozen=True, eq=False)
class RobotModel:
    """Predicts stretches of recordings of a robot; it can be sent to other processes.

    Attributes:
        recordings: of the robot.
        causes: what may be missing.
        sizes: what is usual.
    """

    recordings: RobotRecordings
    causes: tuple[JointCause, ...]
    sizes: Sizes

    @classmethod
    def of(cls, recordings: RobotRecordings, causes: Sequence[JointCause] = CAUSES) -> RobotModel:
        """Of recordings, with what is usual in them."""
        return cls(recordings, tuple(causes), _sizes(recordings))

    @property
    def as_model(self) -> Model:
        """It as a model of its own causes."""
        joints = self.recordings.robot.joints
        named = tuple(cause.as_cause(joints, self.sizes) for cause in self.causes)
        noise = {joint: self._noise(k) for k, joint in enumerate(joints)}
        return Model(
            self.predict,
            parameters=servo.parameters(joints) if (servo := self.recordings.robot.servo) else (),
            causes=named,
            name=self.recordings.name,
            units=dict.fromkeys(joints, "rad"),
            noise=noise,
            predict_many=self.predict_many,
        )

    @property
    def neutral(self) -> dict[str, float]:
        """Values with which nothing is missing."""
        joints = self.recordings.robot.joints
        return {
            f"{cause.name}.{fact.name}": fact.neutral for cause in self.causes for fact in cause.parameters(joints, self.sizes)
        }

    def predict(self, values: Mapping[str, float], trial: Trial) -> Mapping[str, Array]:
        """What the encoders show in one stretch."""
        return self.predict_many([(values, trial)])[0]

    def predict_many(self, cases: Sequence[tuple[Mapping[str, float], Trial]]) -> list[Mapping[str, Array]]:
        """Likewise for many at once."""
        robot = self.recordings.robot
        asked = [
            Case(trial.inputs, values, np.array([values.get(_speed(joint), 0.0) for joint in robot.joints]))
            for values, trial in cases
        ]
        answers = simulate(robot, self.causes, self.neutral, self.sizes, asked)
        return [dict(zip(robot.joints, answer.T, strict=True)) for answer in answers]

    def trials(self, seconds: float | None = None) -> list[Trial]:
        """The recordings cut into stretches.

        Args:
            seconds: of each; default: the longest in which the declared model stays near enough to be compared.
        """
        if seconds is not None:
            return self._cut(seconds)
        for length in _LENGTHS:
            trials = self._cut(length)
            if trials and self._off(trials) < _OFF:
                break
        return trials

    def _off(self, trials: Sequence[Trial]) -> float:
        """By how much the declared model is off at the median of stretches, over what moves."""
        answers = self.predict_many([(self.neutral, trial) for trial in trials])
        shares = []
        for trial, answer in zip(trials, answers, strict=True):
            missed = np.concatenate([answer[joint] - trial.measured[joint] for joint in trial.measured])
            moved = np.concatenate([np.asarray(each) - np.mean(each) for each in trial.measured.values()])
            shares.append(np.sqrt(np.mean(missed**2) / max(float(np.mean(moved**2)), 1e-12)))
        return float(np.median(np.nan_to_num(shares, nan=np.inf)))

    def _cut(self, seconds: float) -> list[Trial]:
        """All stretches of a length, or so many of them as are looked at."""
        found = [stretch for trial in self.recordings.trials for stretch in self._stretches(trial, seconds)]
        few = min(_MOST, len(found))
        return [found[round(k * (len(found) - 1) / max(few - 1, 1))] for k in range(few)]

    def _stretches(self, trial: RobotTrial, seconds: float) -> list[Trial]:
        """Of one recording, all with equally many samples."""
        step = float(np.median(np.diff(trial.time)))
        count, joints, found = round(seconds / step) + 1, self.recordings.robot.joints, []
        begins = range(_SIDE, len(trial.time) - max(count, _SIDE), count)
        starts = [self._start(trial, begin) for begin in begins]
        doubt = np.median([np.abs(each) for *_, each in starts], axis=0) if starts else np.zeros(len(joints))
        unsure = np.sqrt(doubt**2 + (_UNSURE * self.sizes.speed) ** 2)
        for number, (begin, (position, speed, speeding, _)) in enumerate(zip(begins, starts, strict=True), 1):
            rows, earlier = slice(begin, begin + count), slice(max(0, begin - round(_BEFORE / step)), begin)
            stretch = Stretch(
                trial.time[rows],
                trial.command[rows],
                trial.time[earlier],
                trial.command[earlier],
                position,
                speed,
                speeding,
                self.recordings.held,
            )
            found.append(
                Trial(
                    f"{trial.name} {number}",
                    trial.time[rows],
                    dict(zip(joints, trial.position[rows].T, strict=True)),
                    stretch,
                    {"trial": trial.name},
                    {_speed(joint): float(each) for joint, each in zip(joints, unsure, strict=True)},
                )
            )
        return found

    def _start(self, trial: RobotTrial, at: int) -> tuple[Array, Array, Array, Array]:
        """(n,) each: angle, speed and acceleration from a cubic through the samples about it; how a parabola differs in speed."""
        rows = slice(at - _SIDE, at + _SIDE + 1)
        t, q = trial.time[rows] - trial.time[at], trial.position[rows]
        parabola, cubic = (np.polynomial.polynomial.polyfit(t, q, degree) for degree in (2, 3))
        return cubic[0], cubic[1], 2 * cubic[2], parabola[1] - cubic[1]

    def _noise(self, joint: int) -> float:
        """[rad] of an encoder: white noise, and the smallest step that it shows."""
        steps = [np.abs(np.diff(trial.position[:, joint])) for trial in self.recordings.trials]
        smallest = min((float(each[each > 0].min()) for each in steps if (each > 0).any()), default=0.0)
        white = float(np.nanmedian([white_noise(trial.position[:, joint]) for trial in self.recordings.trials]))
        return float(np.hypot(np.nan_to_num(white), smallest / np.sqrt(12)))


def _speed(joint: str) -> str:
    """Name of what the speed at the start of a stretch differs by from what the encoders show."""
    return f"start speed of {joint}"


def _sizes(recordings: RobotRecordings) -> Sizes:
    """What is usual in recordings."""
    robot, trials = recordings.robot, recordings.trials
    servo = robot.servo
    torque = np.concatenate([servo.torque(each.command, each.position) if servo else each.command for each in trials])
    speed = np.concatenate([np.diff(trial.position, axis=0) / np.diff(trial.time)[:, None] for trial in trials])
    angles = np.concatenate([trial.position for trial in trials])
    inertia, alone = _inertia(recordings)
    return Sizes(
        largest=np.abs(torque).max(axis=0),
        torque=np.maximum(np.sqrt(np.mean(torque**2, axis=0)), 0.01 * float(np.abs(torque).max()) or 1.0),
        speed=np.maximum(np.sqrt(np.mean(speed**2, axis=0)), 1e-3),
        lowest=angles.min(axis=0),
        highest=angles.max(axis=0),
        mass=float(sum(inertia.mass for inertia in list(robot.model.inertias)[1:])) or 1.0,
        inertia=inertia,
        alone=alone,
        rotor=np.array(robot.rotor_inertia),
        encoders=robot.encoders,
    )


def _inertia(recordings: RobotRecordings) -> tuple[Array, Array]:
    """(n,) [kg m^2] seen at each joint in the middle of what was recorded: with the others at rest, and while they yield."""
    import pinocchio as pin

    robot = recordings.robot
    middle = np.median(np.concatenate([trial.position for trial in recordings.trials]), axis=0)
    mass = pin.crba(robot.model, robot.model.createData(), middle[robot.order])
    mass = np.triu(mass) + np.triu(mass, 1).T
    seen, alone = np.empty((2, len(robot.joints)))
    seen[robot.order], alone[robot.order] = np.diag(mass), 1 / np.diag(np.linalg.inv(mass))
    return seen, alone

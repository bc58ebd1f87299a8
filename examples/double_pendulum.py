"""Find out why a real two-link robot does not move like its URDF, and compare with least squares on inverse dynamics.

FOLDER contains recordings of the double pendulum of the DFKI Underactuated Lab (dfki-ric-underactuated-lab/double_pendulum,
BSD-3-Clause): ``model.urdf``, ``nominal.yml`` and ``trial_*.csv`` with the columns t, q1, q2, tau1_measured, tau2_measured. The
last two trials are held out: both methods are compared on them, by the same simulations of half a second.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from copy import copy
from pathlib import Path

import numpy as np
import pinocchio as pin
from scipy.signal import savgol_filter

from hsr_pin.explain import Explanation
from hsr_pin.robots import Robot, RobotRecordings, RobotTrial, explain_robot
from hsr_pin.robots.model import RobotModel

COLUMNS = ["t", "q1", "q2", "tau1_measured", "tau2_measured"]
SECONDS = 0.5
ASIDE = 2
#: Smoothing window for inverse dynamics [samples], and the speed at which the regularised friction is nearly complete [rad/s].
WINDOW, SLIDES = 31, 0.1
#: Regularisation weight that keeps undetermined parameters of the bodies at their declared values.
NEAR = 1e-3


def read(folder: Path) -> RobotRecordings:
    """Return the recordings in a folder, with the rotor inertia of ``nominal.yml`` multiplied by the square of the gear ratio."""
    numbers = dict(line.split(": ") for line in (folder / "nominal.yml").read_text(encoding="utf-8").splitlines())
    rotor = float(numbers["Ir"]) * float(numbers["gr"]) ** 2
    robot = Robot.load(folder / "model.urdf", ["Joint1", "Joint2"], [rotor, rotor])
    trials = []
    for file in sorted(folder.glob("trial_*.csv")):
        table = np.genfromtxt(file, delimiter=",", names=True)
        t, *columns = (table[name] for name in COLUMNS)
        trials.append(RobotTrial(file.stem, t, np.column_stack(columns[:2]), np.column_stack(columns[2:])))
    return RobotRecordings("double pendulum", robot, tuple(trials), held=False, notes=robot.notes)


def least_squares(recordings: RobotRecordings, trials: Sequence[RobotTrial]) -> tuple[pin.Model, dict[str, float]]:
    """Return a model with fitted bodies and the friction of its joints, from linear least squares on torques."""
    robot = recordings.robot
    model, joints = robot.model, robot.joints
    data, rows, torques = model.createData(), [], []
    for trial in trials:
        step = float(np.median(np.diff(trial.time)))
        even = np.arange(trial.time[0], trial.time[-1], step)
        q, tau = (np.column_stack([np.interp(even, trial.time, x) for x in part.T]) for part in (trial.position, trial.command))
        q, v, a = (savgol_filter(q, WINDOW, 3, deriv=n, delta=step, axis=0) for n in range(3))
        for n in range(WINDOW, len(even) - WINDOW, 5):
            bodies = pin.computeJointTorqueRegressor(model, data, q[n], v[n], a[n])
            rows.append(np.hstack([bodies, np.diag(v[n]), np.diag(np.tanh(v[n] / SLIDES))]))
            torques.append(tau[n] - model.armature * a[n])
    declared = np.concatenate(
        [*(inertia.toDynamicParameters() for inertia in list(model.inertias)[1:]), np.zeros(2 * len(joints))]
    )
    matrix, right = np.vstack(rows), np.concatenate(torques)
    size = np.maximum(np.linalg.norm(matrix, axis=0), 1e-9)
    whole = np.vstack([matrix / size, NEAR * np.eye(len(size))])
    change = np.linalg.lstsq(whole, np.append(right - matrix @ declared, np.zeros(len(size))), rcond=None)[0] / size
    found, changed = declared + change, model.copy()
    for k in range(len(joints)):
        changed.inertias[k + 1] = pin.Inertia.FromDynamicParameters(found[10 * k : 10 * k + 10])
    friction = np.maximum(found[10 * len(joints) :], 0.0).reshape(2, -1)
    names = ("viscous_friction", "coulomb_friction")
    return changed, {f"{name}.{joint}": float(friction[n, k]) for n, name in enumerate(names) for k, joint in enumerate(joints)}


def error(recordings: RobotRecordings, values: dict[str, float], model: pin.Model | None = None) -> float:
    """Return the RMS error of simulations of half a second of the held-out trials [degrees]."""
    robot = copy(recordings.robot)
    if model is not None:
        robot.__dict__["model"] = model
    last = RobotRecordings(recordings.name, robot, recordings.trials[-ASIDE:], held=False)
    simulated = RobotModel.of(last)
    trials = simulated.trials(SECONDS)
    answers = simulated.predict_many([(simulated.neutral | values, trial) for trial in trials])
    missed = [answer[joint] - trial.measured[joint] for trial, answer in zip(trials, answers, strict=True) for joint in answer]
    return float(np.degrees(np.sqrt(np.nanmean(np.concatenate(missed) ** 2))))


def compare(folder: Path, jobs: int | None = None) -> tuple[Explanation, dict[str, float]]:
    """Return the explanation, and the RMS error of each method on the held-out trials [degrees]."""
    recordings = read(folder)
    aside = [trial.name for trial in recordings.trials[-ASIDE:]]
    found = explain_robot(recordings, seconds=SECONDS, test=aside, jobs=jobs)
    print(found)
    model, friction = least_squares(recordings, recordings.trials[:-ASIDE])
    return found, {
        "as declared": error(recordings, {}),
        "least squares on inverse dynamics": error(recordings, friction, model),
        "most probable model": error(recordings, found.values),
    }


def show(errors: dict[str, float]) -> None:
    """Print the RMS error of each method [degrees]."""
    print("\nRMS error on held-out trials, simulations of half a second [degrees]")
    for name, value in errors.items():
        print(f"  {name:<36}{value:8.2f}")


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Print and return the RMS error of each method on the held-out trials [degrees]."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--html", type=Path, help="write the report")
    parser.add_argument("--jobs", type=int, default=None, help="processes; default: one per core")
    chosen = parser.parse_args(arguments)
    found, errors = compare(chosen.folder, chosen.jobs)
    if chosen.html:
        found.to_html(chosen.html)
    show(errors)
    return errors


if __name__ == "__main__":
    main()

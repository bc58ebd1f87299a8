"""Compare the diagnosis of a real double pendulum with parameters that mujoco.sysid fits to the same recordings.

    python benchmarks/robot_identification.py FOLDER

FOLDER is that of ``examples/double_pendulum.py``, which runs first. Then mujoco.sysid (in the package mujoco, group ``bench``)
fits MuJoCo's own model of the robot to the same stretches of the same trials, twice: with the same free parameters that the
diagnosis found, and with all parameters that a joint and a link have in MuJoCo. Each fit is done with two optimizers, and the
better result counts. All methods are compared on the held-out trials by the same simulation.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from mujoco import sysid

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))
import double_pendulum

from hsr_pin.robots import RobotRecordings
from hsr_pin.robots.model import RobotModel

#: Step of MuJoCo [s].
STEP = 1e-3
#: Optimizers of mujoco.sysid that are tried.
OPTIMIZERS = ("mujoco", "scipy")
#: Friction to start from [N m, N m s/rad]: at 0 a fit begins on a bound.
FIRST = 0.05


def _attribute(name: str) -> Callable[[str, Any], Callable[[Any, Any], None]]:
    """Return a factory of functions that add a value to an attribute of a joint."""

    def of(joint: str, declared: Any) -> Callable[[Any, Any], None]:
        first = np.atleast_1d(getattr(declared.joint(joint), name)).copy()

        def change(spec: Any, number: Any) -> None:
            values = first + number.value[0] * (np.arange(len(first)) == 0)  # of damping, the part in proportion to the speed
            setattr(spec.joint(joint), name, values if len(values) > 1 else values[0])

        return change

    return of


def _body(name: str) -> Callable[[str, Any], Callable[[Any, Any], None]]:
    """Return a factory of functions that scale the declared mass and inertia of the link of a joint, or its inertia only."""

    def of(joint: str, declared: Any) -> Callable[[Any, Any], None]:
        own = declared.joint(joint).parent
        first = own.mass, own.fullinertia.copy()

        def change(spec: Any, number: Any) -> None:
            body = spec.joint(joint).parent
            if name == "mass":  # it comes before the inertia
                body.mass, body.fullinertia = (each * (1 + number.value[0]) for each in first)
            else:
                body.fullinertia = first[1] * body.mass / first[0] * (1 + number.value[0])

        return change

    return of


def _gear(joint: str, _: Any) -> Callable[[Any, Any], None]:
    """Return a function that scales the torque of a motor."""
    return lambda spec, number: setattr(spec.actuator(joint), "gear", [1 + number.value[0], 0, 0, 0, 0, 0])


#: How MuJoCo has each cause, and its bounds.
NUMBERS = {
    "coulomb_friction": (_attribute("frictionloss"), 0.0, 2.0),
    "viscous_friction": (_attribute("damping"), 0.0, 1.0),
    "rotor_inertia": (_attribute("armature"), -0.002, 0.1),
    "link_mass": (_body("mass"), -0.9, 5.0),
    "link_inertia": (_body("inertia"), -0.99, 5.0),
    "torque_gain": (_gear, -0.5, 0.5),
}


def specification(recordings: RobotRecordings) -> Any:
    """Return the MuJoCo specification of the robot: damping and friction only as fitted, a motor and an encoder at each joint."""
    spec = mujoco.MjSpec.from_string(recordings.robot.urdf)
    spec.option.timestep, spec.option.integrator = STEP, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = recordings.robot.gravity
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    for joint, rotor in zip(recordings.robot.joints, recordings.robot.rotor_inertia, strict=True):
        found = spec.joint(joint)
        found.armature, found.limited = rotor, mujoco.mjtLimited.mjLIMITED_FALSE
        spec.add_actuator(name=joint, target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        spec.add_sensor(
            name=f"{joint}_angle", type=mujoco.mjtSensor.mjSENS_JOINTPOS, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname=joint
        )
    return spec


def fitted(recordings: RobotRecordings, names: Sequence[str], optimizer: str) -> dict[str, float]:
    """Return the values of causes (``cause.joint``) that mujoco.sysid fits to recordings."""
    joints = recordings.robot.joints
    spec, opened = specification(recordings), sysid.ParameterDict()
    for name in names:
        cause, _, joint = name.partition(".")
        change, lower, upper = NUMBERS[cause]
        opened.add(sysid.Parameter(name, 0.0, lower, upper, modifier=change(joint, spec)))
        opened[name].value[:] = FIRST if "friction" in cause else 0.0
    trials = RobotModel.of(recordings).trials(double_pendulum.SECONDS)
    model, starts, controls, sensors = spec.compile(), [], [], []
    for trial in trials:
        clock = trial.time - trial.time[0]
        measured = np.column_stack([trial.measured[joint] for joint in joints])
        starts.append(sysid.create_initial_state(model, trial.inputs.q, trial.inputs.v))
        controls.append(sysid.TimeSeries(clock, trial.inputs.command))
        sensors.append(sysid.TimeSeries.from_names(clock, measured, model))
    sequences = sysid.ModelSequences("robot", spec, [trial.name for trial in trials], starts, controls, sensors)
    residuals = sysid.build_residual_fn(models_sequences=[sequences])
    with contextlib.redirect_stdout(io.StringIO()):  # the progress of every iteration
        found, _ = sysid.optimize(opened, residuals, optimizer=optimizer, verbose=False, x_scale="jac")
    return {name: float(found[name].value[0]) for name in names}


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Print the held-out error and the run time of each method, and return the errors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    chosen = parser.parse_args(arguments)
    found, errors = double_pendulum.compare(chosen.folder)
    recordings = double_pendulum.read(chosen.folder)
    trained = replace(recordings, trials=recordings.trials[: -double_pendulum.ASIDE])
    joints = recordings.robot.joints
    every = [f"{cause}.{joint}" for cause in NUMBERS for joint in joints]
    same = [name for name in every if found.values[name]]
    for label, names in (("the same numbers", same), (f"all {len(every)} numbers", every)):
        begun = time.perf_counter()
        tried = [fitted(trained, names, optimizer) for optimizer in OPTIMIZERS]
        left = [double_pendulum.error(recordings, values) for values in tried]
        errors[f"mujoco.sysid, {label}"] = min(left)
        best = tried[int(np.argmin(left))]
        seconds = (time.perf_counter() - begun) / len(OPTIMIZERS)
        print(f"mujoco.sysid, {label} ({seconds:.0f} s): " + ", ".join(f"{name} {value:.3g}" for name, value in best.items()))
    double_pendulum.show(errors)
    return errors


if __name__ == "__main__":
    main()

"""Find the cause that a MuJoCo model of a two-link arm lacks: friction that the recorded arm has.

The recordings are simulated with a different time step and integrator than those of the diagnosed model.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

from hsr_pin.explain import Cause, Explanation, Trial, amplitude, explain
from hsr_pin.explain.mujoco import MujocoInputs, MujocoModel, Opened, opened

XML = """
<mujoco>
  <option timestep="{step}" integrator="{integrator}"/>
  <worldbody>
    <body name="upper"><joint name="shoulder" axis="0 1 0" damping="0.05"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.02" mass="1.2"/>
      <body name="lower" pos="0 0 -0.4"><joint name="elbow" axis="0 1 0" damping="0.05"/>
        <geom type="capsule" fromto="0 0 0 0 0 -0.3" size="0.02" mass="0.7"/>
      </body>
    </body>
  </worldbody>
  <actuator><motor name="m1" joint="shoulder"/><motor name="m2" joint="elbow"/></actuator>
</mujoco>
"""
JOINTS = ("shoulder", "elbow")
TIME = np.arange(0, 3, 0.01)
CAUSES = (
    opened("friction", "friction", "dof_frictionloss", [amplitude(j, 0.1, "N m", lower=0) for j in JOINTS], "dry friction"),
    opened("damping", "damping", "dof_damping", [amplitude(j, 0.05, "N m s/rad", lower=-0.05) for j in JOINTS], "damping"),
    opened("rotor", "inertia", "dof_armature", [amplitude(j, 0.01, "kg m^2", lower=0) for j in JOINTS], "inertia of the motors"),
    opened("mass", "inertia", "body_mass", [amplitude(b, 0.05, lower=-0.5) for b in ("upper", "lower")], "masses", relative=True),
    opened("gear", "actuation", "actuator_gear", [amplitude(m, 0.05, lower=-0.5) for m in ("m1", "m2")], "gears", relative=True),
    Opened(Cause("late", "actuation_time", (amplitude("delay", 0.02, "s", lower=0, upper=0.2),), "late commands"), delay=True),
)


def model(step: float = 0.005, integrator: str = "implicitfast") -> MujocoModel:
    """Return the model of the arm with a time step [s] and an integrator of MuJoCo."""
    xml = XML.format(step=step, integrator=integrator)
    channels = {"q1": "shoulder", "q2": "elbow"}
    return MujocoModel(xml, channels, CAUSES, name="two links", units=dict.fromkeys(channels, "rad"))


def recorded(**missing: float) -> list[Trial]:
    """Return trials of a simulated arm with the given values of causes that the model lacks."""
    plant, noise, trials = model(0.001, "RK4"), np.random.default_rng(0), []
    values = plant.as_model.neutral | {name.replace("__", "."): value for name, value in missing.items()}
    for number in range(4):
        steps = np.where(TIME < 0.5, 0, np.where(TIME < 1.5, 1, -0.5))[:, None] * [1.5, 0.4]
        controls = steps + [0.5, 0.3] * np.sin((2 + number) * TIME)[:, None] * (number + 1)
        inputs = MujocoInputs(controls, qpos=np.zeros(2), qvel=np.zeros(2))
        empty = Trial(f"trial {number}", TIME, {"q1": 0 * TIME, "q2": 0 * TIME}, inputs)
        seen = plant.predict(values, empty)
        measured = {name: angle + 1e-3 * noise.normal(size=len(TIME)) for name, angle in seen.items()}
        trials.append(Trial(empty.name, TIME, measured, empty.inputs))
    return trials


def main(arguments: Sequence[str] | None = None) -> Explanation:
    """Print and return the explanation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=None, help="processes; default: one per core")
    chosen = parser.parse_args(arguments)
    found = explain(model().as_model, recorded(friction__elbow=0.15), jobs=chosen.jobs)
    print(found)
    return found


if __name__ == "__main__":
    main()

"""Plan torques in MuJoCo with a corrected model, and apply them to the arm.

Torques that move the tip along a reference are found by least squares over rollouts in MuJoCo: once with the declared model, and
once with the corrected model, which has the lag and the friction of the arm. The arm is simulated by hsr_pin, and the planner
does not know it. Each plan is applied in open loop, and with a controller that keeps the planned bending.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.rollout import Rollout
from picture import Run, options, report
from scipy.optimize import least_squares

from hsr_pin import ArmSpecification
from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reference import Reference, reference_through_tips
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect
from hsr_pin.export.mjcf import to_mjcf
from hsr_pin.export.model import CorrectedModel
from hsr_pin.trajectory import Array

ARM = ArmSpecification(links=4, keq=1.11)
TRUE = tuple(map(parse_effect, ("actuator_lag:time_constant=0.08", "dry_friction:level=0.06")))
TIPS = [(0.0, -0.24), (0.13, -0.20), (-0.09, -0.22)]  # x, z [m]
KNOTS = 0.15  # [s] between the planned torques
STIFFNESS, LOSS = 0.5, 0.02  # [Nm/rad], [Nm s/rad] gains of the controller


@dataclass(frozen=True, eq=False)
class Plan:
    """Plan from MuJoCo: torques (T - 1,) [N m], and the bending (T - 1,) [rad] that they cause in MuJoCo."""

    torque: Array
    bending: Array


def plan(effects: Sequence[object], reference: Reference) -> Plan:
    """Return piecewise linear torques whose motion in MuJoCo is closest to the reference."""
    model = mujoco.MjModel.from_xml_string(to_mjcf(CorrectedModel(ARM, tuple(effects))).text)  # type: ignore[arg-type]
    data = [mujoco.MjData(model) for _ in range(2)]
    rest = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data[0], rest, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    substeps, time = round(reference.step / model.opt.timestep), reference.time[:-1]
    places = np.arange(0.0, time[-1] + KNOTS, KNOTS)
    sensor = model.sensor("tip").adr[0]

    def moved(knots: Array) -> tuple[Array, Array]:
        """Return the tip positions (B, T - 1, 3) [m] and the bending (B, T - 1) [rad] for torques at the knots (B, K) [N m]."""
        torque = np.array([np.interp(time, places, row) for row in knots])
        states, sensed = rollouts.rollout(
            model, data, np.tile(rest, (len(knots), 1)), np.repeat(torque, substeps, axis=1)[..., None]
        )
        return sensed[:, ::substeps, sensor : sensor + 3], states[:, ::substeps, 1 : 1 + model.nq].sum(axis=2)

    def missed(knots: Array) -> Array:
        return np.asarray((moved(knots[None])[0][0] - reference.tip[:-1]).ravel())

    def slopes(knots: Array) -> Array:
        width = 1e-3
        tips, _ = moved(np.vstack([knots, knots + width * np.eye(len(knots))]))
        return np.asarray((tips[1:] - tips[0]).reshape(len(knots), -1).T / width)

    with Rollout(nthread=2) as rollouts:
        start = np.interp(places, reference.time, reference.torque)
        knots = least_squares(missed, start, jac=slopes, max_nfev=5).x
        return Plan(np.interp(time, places, knots), moved(knots[None])[1][0])


def carry_out(found: Plan, reference: Reference, *, regulated: bool) -> Run:
    """Return the run of a plan on the arm: in open loop, or with a controller of the bending, which is measured with noise."""
    arm, noise = ArmSimulator(ARM, TRUE), np.random.default_rng(0)
    run, rates = Run([arm.observe()[-1]]), np.gradient(found.bending, reference.step)
    for torque, bending, rate in zip(found.torque, found.bending, rates, strict=True):
        if regulated:
            torque += STIFFNESS * (bending - arm.state.angles.sum() + noise.normal(0, 4e-3))
            torque += LOSS * (rate - arm.state.rates.sum() + noise.normal(0, 4e-2))
        arm.step(float(torque), dt=reference.step)
        run.tip.append(arm.observe()[-1])
        run.torque.append(float(torque))
    return run


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Run the example and return the RMS tip error of both plans [mm], in open and in closed loop."""
    chosen = options(arguments, __doc__)
    reference = reference_through_tips(ArmDynamics(ARM), TIPS[:2] if chosen.quick else TIPS, (-1.2, 1.2))
    runs = {}
    for model, effects in (("declared", ()), ("corrected", TRUE)):
        found = plan(effects, reference)
        runs[f"{model} model, open loop"] = carry_out(found, reference, regulated=False)
        runs[f"{model} model, closed loop"] = carry_out(found, reference, regulated=True)
    return report("Planned in MuJoCo, for an arm with lag and friction", reference, runs, chosen.plot)


if __name__ == "__main__":
    main()

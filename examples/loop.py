"""Control loop of the examples: a controller and a simulated arm with one effect that the controller does not know.

Joint angles and rates are measured with noise. The regulators set pressures of constant stiffness, at a limited rate.
"""

from __future__ import annotations

import numpy as np
from picture import Run

from hsr_pin import ArmSpecification
from hsr_pin.control.controllers import Controller
from hsr_pin.control.reference import Reference
from hsr_pin.control.regulators import Regulators
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect

ARM = ArmSpecification(links=4, keq=1.11)
REGULATORS = Regulators(ARM.keq, rate=20.0)  # [bar/s]
TIPS = [(0.0, -0.24), (0.13, -0.20), (-0.09, -0.22), (0.06, -0.23)]  # x, z [m]
ANGLE_NOISE, RATE_NOISE = 2e-3, 2e-2  # [rad], [rad/s]


def follow(reference: Reference, controller: Controller, unknown: str) -> Run:
    """Return the run of a controller on an arm with the effect ``unknown``, written as for ``hsr-sim --effect``."""
    noise = np.random.default_rng(0)
    plant, command = ArmSimulator(ARM, [parse_effect(unknown)]), None
    run = Run([plant.observe()[-1]])
    for k in range(len(reference.time) - 1):
        q = plant.state.angles + noise.normal(0, ANGLE_NOISE, ARM.links)
        v = plant.state.rates + noise.normal(0, RATE_NOISE, ARM.links)
        command = REGULATORS.command(controller.torque(k, q, v), reference.step, command)
        plant.step(pressures=command.pressures, dt=reference.step)
        run.tip.append(plant.observe()[-1])
        run.torque.append(command.torque)
    return run

"""Follow a tip reference by inverse dynamics along it, plus a spring and a damper towards it.

The arm has a hysteresis that the controller does not know. Joint angles and rates are measured with noise; the regulators give
pressures on the line of constant stiffness, at a limited rate.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from picture import Run, options, report

from hsr_pin import ArmSpecification
from hsr_pin.control.controllers import Controller, FeedforwardPD, OpenLoop
from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reference import Reference, reference_through_tips
from hsr_pin.control.regulators import Regulators
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect

ARM = ArmSpecification(links=4, keq=1.11)
UNKNOWN = parse_effect("hysteresis:amplitude=0.15,yield_angle=0.3")
REGULATORS = Regulators(ARM.keq, rate=20.0)  # [bar/s]
TIPS = [(0.0, -0.24), (0.13, -0.20), (-0.09, -0.22), (0.06, -0.23)]  # x, z [m]
ANGLE_NOISE, RATE_NOISE = 2e-3, 2e-2  # [rad], [rad/s]


def follow(reference: Reference, controller: Controller) -> Run:
    """Close the loop: measure, decide, set the pressures, step."""
    noise = np.random.default_rng(0)
    plant, command = ArmSimulator(ARM, [UNKNOWN]), None
    run = Run([plant.observe()[-1]])
    for k in range(len(reference.time) - 1):
        q = plant.state.angles + noise.normal(0, ANGLE_NOISE, ARM.links)
        v = plant.state.rates + noise.normal(0, RATE_NOISE, ARM.links)
        command = REGULATORS.command(controller.torque(k, q, v), reference.step, command)
        plant.step(pressures=command.pressures, dt=reference.step)
        run.tip.append(plant.observe()[-1])
        run.torque.append(command.torque)
    return run


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Open loop against closed loop: RMS tip errors [mm]."""
    chosen = options(arguments, __doc__)
    model = ArmDynamics(ARM)
    reference = reference_through_tips(model, TIPS[:2] if chosen.quick else TIPS, REGULATORS.torque_range)
    runs = {
        "open loop": follow(reference, OpenLoop(reference)),
        "closed loop": follow(reference, FeedforwardPD(model, reference, kp=5.0, kd=0.05)),
    }
    return report("Feedforward and PD, with an unknown hysteresis", reference, runs, chosen.plot)


if __name__ == "__main__":
    main()

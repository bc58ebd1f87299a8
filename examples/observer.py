"""Estimate the state of the arm from two markers by a Kalman filter, and follow a tip reference with this estimate.

A constant torque that the controller does not know acts on the arm. The filter estimates this torque too, and the controller
subtracts it from the command.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from loop import ARM, REGULATORS, TIPS
from picture import Run, options, report

from hsr_pin.control.controllers import LQR, Controller, OpenLoop, lqr_gain
from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.observer import Observer
from hsr_pin.control.reference import Reference, reference_through_tips
from hsr_pin.control.stepping import ArmSimulator
from hsr_pin.effects import parse_effect

UNKNOWN = parse_effect("torque_bias:bias=0.15")
MARKER_NOISE = 5e-4  # [m] of each coordinate


def follow(reference: Reference, controller: Controller, observer: Observer | None) -> Run:
    """Return the run of a controller that uses the estimated state; without an observer the true state is used."""
    noise = np.random.default_rng(0)
    plant, command = ArmSimulator(ARM, [UNKNOWN]), None
    estimate = observer.begin() if observer else None
    run = Run([plant.observe()[-1]])
    for k in range(len(reference.time) - 1):
        if observer and estimate:
            seen = plant.observe() + noise.normal(0, MARKER_NOISE, (len(plant.markers), 3))
            estimate = observer.correct(estimate, seen[1:])
            run.unknown_torque.append(estimate.disturbance)
            wanted = controller.torque(k, estimate.q, estimate.v) - estimate.disturbance
        else:
            wanted = controller.torque(k, plant.state.angles, plant.state.rates)
        command = REGULATORS.command(wanted, reference.step, command)
        if observer and estimate:
            estimate = observer.predict(estimate, command.torque)
        plant.step(pressures=command.pressures, dt=reference.step)
        run.tip.append(plant.observe()[-1])
        run.torque.append(command.torque)
    return run


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Run the example and return the RMS tip error of each run [mm]: in open loop and in closed loop."""
    chosen = options(arguments, __doc__)
    model = ArmDynamics(ARM)
    reference = reference_through_tips(model, TIPS[:2] if chosen.quick else TIPS, REGULATORS.torque_range)
    middle_and_tip = ArmSimulator(ARM).markers[1:]
    observer = Observer(model, middle_and_tip, reference.step, noise=MARKER_NOISE)
    gain = lqr_gain(model, torque=0.0, dt=reference.step)
    runs = {
        "open loop": follow(reference, OpenLoop(reference), None),
        "closed loop": follow(reference, LQR(reference, gain), observer),
    }
    return report("LQR from a Kalman filter on two markers, with an unknown torque of 0.15 N m", reference, runs, chosen.plot)


if __name__ == "__main__":
    main()

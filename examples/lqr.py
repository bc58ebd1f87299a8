"""Follow a tip reference with a linear-quadratic regulator (LQR) for one pose of the arm.

The arm creeps (a viscoelastic branch parallel to its spring), which the controller does not know.
"""

from __future__ import annotations

from collections.abc import Sequence

from loop import ARM, REGULATORS, TIPS, follow
from picture import options, report

from hsr_pin.control.controllers import LQR, OpenLoop, lqr_gain
from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reference import reference_through_tips

UNKNOWN = "viscoelastic:ratio=0.4,time_constant=0.5"


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Run the example and return the RMS tip error of each run [mm]: in open loop and in closed loop."""
    chosen = options(arguments, __doc__)
    model = ArmDynamics(ARM)
    reference = reference_through_tips(model, TIPS[:2] if chosen.quick else TIPS, REGULATORS.torque_range)
    gain = lqr_gain(model, torque=0.0, dt=reference.step)  # about the straight arm
    runs = {
        "open loop": follow(reference, OpenLoop(reference), UNKNOWN),
        "closed loop": follow(reference, LQR(reference, gain), UNKNOWN),
    }
    return report("LQR about the straight pose, with unknown creep", reference, runs, chosen.plot)


if __name__ == "__main__":
    main()

"""Follow a tip reference with a computed-torque controller, which uses inverse dynamics of the measured state.

The arm has dry friction that the controller does not know.
"""

from __future__ import annotations

from collections.abc import Sequence

from loop import ARM, REGULATORS, TIPS, follow
from picture import options, report

from hsr_pin.control.controllers import ComputedTorque, OpenLoop
from hsr_pin.control.dynamics import ArmDynamics
from hsr_pin.control.reference import reference_through_tips

UNKNOWN = "dry_friction:level=0.08"


def main(arguments: Sequence[str] | None = None) -> dict[str, float]:
    """Run the example and return the RMS tip error of each run [mm]: in open loop and in closed loop."""
    chosen = options(arguments, __doc__)
    model = ArmDynamics(ARM)
    reference = reference_through_tips(model, TIPS[:2] if chosen.quick else TIPS, REGULATORS.torque_range)
    runs = {
        "open loop": follow(reference, OpenLoop(reference), UNKNOWN),
        "closed loop": follow(reference, ComputedTorque(model, reference, frequency=80.0), UNKNOWN),
    }
    return report("Computed torque, with an unknown dry friction", reference, runs, chosen.plot)


if __name__ == "__main__":
    main()

"""Find out what has changed in an arm since the first of four sessions.

The simulated arm has springs that stiffen with bending. From the third session on its stiffness is 8 % smaller, and in the last
session its muscles fill more slowly.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hsr_pin import ArmSpecification, Dataset, Trajectory, simulate, step_scenario
from hsr_pin.diagnosis.change.history import History, history
from hsr_pin.effects import parse_effect
from hsr_pin.trajectory import Trial

TORQUES = (0.4, 0.7, 1.0, -0.6, -0.9)  # [N m]
MARKER_NOISE = 3e-4  # [m] of each coordinate
SESSIONS = {
    "january": (1.0, 0.03),  # stiffness relative to the first session, time constant of the muscles [s]
    "march": (1.0, 0.03),
    "may": (0.92, 0.03),
    "july": (0.92, 0.06),
}


def recorded(name: str, stiffness: float, lag: float) -> Dataset:
    """Return one session: steps to a few torques, each with a slightly different equilibrium."""
    rng = np.random.default_rng(list(SESSIONS).index(name))
    arm = ArmSpecification(links=16, placement="mid")
    effects = tuple(map(parse_effect, ("stiffening:cubic=0.3", f"actuator_lag:time_constant={lag}")))
    found = []
    for number, torque in enumerate(TORQUES, 1):
        scenario = step_scenario(replace(arm, keq=stiffness * arm.keq), torque, duration=1.5, step=0.02)
        resting = parse_effect(f"torque_bias:bias={rng.normal(0, 0.004)}")
        motion = simulate(replace(scenario, effects=(*effects, resting)), dynamics="compiled").trajectory
        seen = motion.positions + MARKER_NOISE * rng.standard_normal(motion.positions.shape)
        recording = Trajectory(motion.time, motion.markers, seen, torque=motion.torque)
        found.append(Trial(f"trial_{number:02d}", recording, keq=arm.keq, damping=arm.damping))
    return Dataset(name, arm.length, arm.mass, arm.diameter, arm.mount, tuple(found))


def main(arguments: Sequence[str] | None = None) -> History:
    """Simulate the sessions, compare them with the first one, and print what has changed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer candidates")
    parser.add_argument("--html", metavar="FILE", help="write the report")
    chosen = parser.parse_args(arguments)
    sessions = [recorded(name, *state) for name, state in SESSIONS.items()]
    quick = {"effects": ["actuator_lag", "tip_mass"], "max_effects": 2, "links": 8}
    found = history(sessions, jobs=1, **(quick if chosen.quick else {}))
    for name, diagnosis in zip(found.names[1:], found.diagnoses, strict=True):
        print(f"{name}: {diagnosis.verdict.sentence}\n")
    for quantity in found.quantities:
        values = "".join(f"{point.value:>9.3f}" for point in quantity.points)
        certain = "" if quantity.first is None else f"   changed significantly from {found.names[quantity.first]} on"
        print(f"{quantity.name:<28}{values}{certain}")
    if chosen.html:
        from hsr_pin.diagnosis.change.report import write_report

        write_report(found, chosen.html)
    return found


if __name__ == "__main__":
    main()

"""Synthetic recordings with a known error of the declared arm."""

import zlib

import numpy as np

from hsr_pin.effects import parse_effect
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Marker

from ..filmed import filmed

#: Declared Keq [Nm/rad] and C [Nm s/rad], and the torques [N m] before and after the second step, of six trials.
TRIALS = (
    (1.11, 0.05, (0.5, 0.15)),
    (1.11, 0.05, (0.9, 0.5)),
    (1.11, 0.05, (-0.7, 0.3)),
    (2.33, 0.1, (1.0, 0.4)),
    (2.33, 0.1, (1.9, 0.9)),
    (2.33, 0.1, (-1.4, 0.6)),
)

#: Every effect of the catalogue, as large as one would notice.
CATALOGUE = (
    "stiffness_gradient:slope=-0.9",
    "soft_spot:depth=0.7,centre=0.35,width=0.08",
    "stiffening:cubic=0.4",
    "bending_stop:ratio=6,angle=0.5",
    "backlash:gap=0.2",
    "dry_friction:level=0.06",
    "hysteresis:amplitude=0.12,yield_angle=0.25",
    "viscoelastic:ratio=0.4,time_constant=0.4",
    "quadratic_damping:coefficient=0.008",
    "damping_gradient:slope=1.5",
    "actuator_lag:time_constant=0.08",
    "dead_time:delay=0.045",
    "torque_bias:bias=0.1",
    "torque_map:quadratic=0.2",
    "torque_decay:decay=0.3",
    "gravity_tilt:angle=0.12",
    "tip_mass:mass=0.05",
    "added_mass:mass=0.08",
    "marker_offset:offset=0.006",
)


def made(
    *effects,
    trials=TRIALS,
    duration=2.0,
    step=0.02,
    links=24,
    keq=1.1,
    damping=0.8,
    noise=3e-4,
    markers=(0.0, 0.5, 1.0),
    name="made",
    draw="",
):
    """Return a dataset simulated on a fine chain with effects (texts or laws); the factors relate true to declared Keq and C."""
    laws = tuple(parse_effect(effect) if isinstance(effect, str) else effect for effect in effects)
    time = np.arange(round(duration / step) + 1) * step
    motions = []
    for declared, loss, (first, second) in trials:
        arm = ArmSpecification(links=links, placement="mid", keq=declared * keq, damping=loss * damping, bending_limit=2 * np.pi)
        torque = np.select([time < 0.1 - 1e-9, time < duration / 2], [0.0, first], second)
        scenario = Scenario(
            arm, time, torque, Settled(0.0), laws, tuple(Marker(f"marker_{at:g}", at * arm.length) for at in markers)
        )
        motions.append(simulate(scenario, dynamics="compiled").trajectory)
    seed = zlib.crc32((repr(effects) + draw).encode())
    recorded = filmed(motions, noise, seed, [levels for *levels, _ in trials])
    return Dataset(name, arm.length, arm.mass, arm.diameter, arm.mount, recorded)

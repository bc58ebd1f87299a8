"""Derivatives of marker positions with respect to parameters, by finite differences within one batch.

A parameter is named as in a report: a number of the arm ("keq", "damping", "mass", "tip_mass", "tilt") or of one of the
scenario's effects ("effect.parameter"). Every perturbed run takes the steps of the base run, so that only the parameter differs
and the differences are smooth down to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi

import numpy as np

from hsr_pin.effects.effect import Effect, with_values
from hsr_pin.errors import InputError
from hsr_pin.parameters import Parameter
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.batch import result_of, simulate_together
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.integrator import TOLERANCE, Integrator
from hsr_pin.simulation.motion import Dynamics
from hsr_pin.simulation.result import SimulationResult
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array

#: Parameters of the arm that recordings can identify.
ARM_PARAMETERS = {
    fact.name: fact
    for fact in (
        Parameter("keq", "Nm/rad", 1.11, 1e-3, 1e3, 0.5, False, "bending stiffness of the arm"),
        Parameter("damping", "Nm s/rad", 0.05, 0.0, 1e2, 0.05, False, "damping of the arm"),
        Parameter("mass", "kg", 0.15, 1e-4, 1e2, 0.1, False, "mass of the arm"),
        Parameter("tip_mass", "kg", 0.0, 0.0, 1e2, 0.05, True, "point mass at the tip"),
        Parameter("tilt", "rad", 0.0, -pi, pi, 0.1, True, "turn of the base from its mount"),
        Parameter("cross_tilt", "rad", 0.0, -pi, pi, 0.1, True, "turn of the base towards its side, in space"),
        Parameter("torsion", "Nm/rad", 1.0, 0.0, 1e3, 0.5, False, "stiffness of the arm against twisting, in space"),
    )
}

#: Finite difference relative to the parameter's scale: both the truncation error (quadratic) and the amplified rounding error are
#: below 1e-6.
FRACTION = 1e-3


def sensitivities(
    scenarios: Sequence[Scenario],
    names: Sequence[str],
    *,
    fraction: float = FRACTION,
    dynamics: Dynamics = "compiled",
    integrator: str | None = None,
    tolerance: float = TOLERANCE,
    step: float | None = None,
) -> tuple[list[SimulationResult], list[Array]]:
    """Simulate scenarios and compute the derivatives of their marker positions with respect to parameters.

    Args:
        scenarios: any mixture; each must have the named effects.
        names: names of P parameters.
        fraction: size of the finite difference relative to the parameter's scale.
        dynamics: as for :func:`hsr_pin.simulation.batch.simulate_batch`.
        integrator: as for :func:`hsr_pin.simulation.batch.simulate_batch`.
        tolerance: as for :func:`hsr_pin.simulation.batch.simulate_batch`.
        step: as for :func:`hsr_pin.simulation.batch.simulate_batch`.

    Returns:
        The results of the scenarios, and for each the derivatives (T, M, 3, P) [m per unit of the parameter] of second order,
        central or (at a bound) one-sided; NaN if the run, or all perturbed runs of a parameter, failed.
    """
    method = Integrator(integrator, tolerance, step)
    own, slopes = [], []
    for scenario in scenarios:
        family, offsets = [scenario], np.empty((len(names), 2))
        for name, pair in zip(names, offsets, strict=True):
            value = value_of(scenario, name)
            pair[:] = _offsets(value, parameter_of(scenario, name), fraction)
            family += [with_value(scenario, name, value + offset) for offset in pair]
        batch = ArmBatch.of(family)
        motion = simulate_together(family, batch, method, dynamics)
        positions = Cameras(batch, scenario.reach, scenario.beside).positions(motion.angles)
        results = [result_of(each, motion, positions, b) for b, each in enumerate(family)]
        own.append(results[0])
        slopes.append(_derivatives(results, offsets))
    return own, slopes


def parameter_of(scenario: Scenario, name: str) -> Parameter:
    """Return the unit, bounds and scale of a parameter.

    Raises:
        InputError: the scenario has no such parameter; the message lists the existing ones.
    """
    facts = ARM_PARAMETERS | {f"{effect.name}.{fact.name}": fact for effect in scenario.effects for fact in effect.parameters()}
    if name not in facts:
        raise InputError("parameter", expected=", ".join(facts), received=repr(name))
    return facts[name]


def value_of(scenario: Scenario, name: str) -> float:
    """Return the value of a parameter in a scenario."""
    owner, field = _owner(scenario, name)
    return float(getattr(owner if owner else scenario.arm, field))


def with_value(scenario: Scenario, name: str, value: float) -> Scenario:
    """Return the scenario with one parameter changed."""
    owner, field = _owner(scenario, name)
    if owner is None:
        return replace(scenario, arm=replace(scenario.arm, **{field: value}))  # type: ignore[arg-type]  # all are floats
    return replace(scenario, effects=tuple(with_values(e, **{field: value}) if e is owner else e for e in scenario.effects))


def _owner(scenario: Scenario, name: str) -> tuple[Effect | None, str]:
    parameter_of(scenario, name)  # raises for an unknown one
    owner, _, field = name.rpartition(".")
    return next((effect for effect in scenario.effects if effect.name == owner), None), field


def _offsets(value: float, fact: Parameter, fraction: float) -> tuple[float, float]:
    """Return two offsets within the bounds: h and -h, or h and 2 h away from the nearer bound.

    The offset of a parameter that every arm has (not of an amplitude, which may be zero) is a fraction of its value if that is
    smaller than the scale: an arm a tenth as stiff as the paper's gets a tenth of the change.
    """
    has_it = fact.name in ("keq", "damping", "mass") and value > 1e-6 * fact.scale
    h = fraction * (min(fact.scale, value) if has_it else fact.scale)
    if value + h > fact.upper:
        return -h, -2 * h
    return (h, -h) if value - h >= fact.lower else (h, 2 * h)


def _derivatives(results: Sequence[SimulationResult], offsets: Array) -> Array:
    """Return the derivatives (T, M, 3, P), each from the parabola through the base run and two perturbed runs."""
    base, *neighbours = results
    whole = (len(base.scenario.time), len(base.scenario.markers), 3)
    slopes = np.full((*whole, len(offsets)), np.nan)
    if not base.completed:
        return slopes
    centre = base.trajectory.positions
    for p, steps in enumerate(offsets):
        chords = [
            ((side.trajectory.positions - centre) / offset, offset)
            for side, offset in zip(neighbours[2 * p : 2 * p + 2], steps, strict=True)
            if side.completed
        ]
        if len(chords) == 2:
            (first, a), (second, b) = chords
            slopes[..., p] = (a * second - b * first) / (a - b)
        elif chords:
            slopes[..., p] = chords[0][0]
    return slopes

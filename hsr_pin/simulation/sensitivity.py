"""How marker positions change with parameters: finite differences through one family of columns.

A parameter is named as in a report: a number of the arm ("keq", "damping", "mass", "tip_mass", "tilt") or of one of the
scenario's effects ("effect.parameter"). Every perturbed run takes the steps of the base run, so that what differs is the
parameter alone and the differences are smooth to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi

import numpy as np

from hsr_pin.effects.effect import Effect, with_values
from hsr_pin.errors import InputError
from hsr_pin.parameters import Parameter
from hsr_pin.simulation.batch import moved, result_of
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.integrator import TOLERANCE, Integrator
from hsr_pin.simulation.motion import Dynamics
from hsr_pin.simulation.result import SimulationResult
from hsr_pin.simulation.scenario import Scenario
from hsr_pin.trajectory import Array

#: Numbers of the arm that a recording can tell apart from others.
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

#: Size of a difference, over the parameter's scale: its truncation (square) and the rounding it magnifies are both below 1e-6.
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
    """Simulate scenarios, and the derivatives of their marker positions to parameters.

    Args:
        scenarios: any mixture; each must have the named effects.
        names: P parameters.
        fraction: size of a difference over the parameter's scale.
        dynamics: as for :func:`hsr_pin.simulation.batch.simulate_batch`.
        integrator: likewise.
        tolerance: likewise.
        step: likewise.

    Returns:
        The scenarios' own results, and for each (T, M, 3, P) [m per unit of the parameter]: second-order differences, central or
        (at a bound) one-sided; NaN where the run itself, or all neighbours, failed.
    """
    method = Integrator(integrator, tolerance, step)
    own, slopes = [], []
    for scenario in scenarios:
        family, offsets = [scenario], np.empty((len(names), 2))
        for name, pair in zip(names, offsets, strict=True):
            value = value_of(scenario, name)
            pair[:] = _offsets(value, parameter_of(scenario, name), fraction)
            family += [with_value(scenario, name, value + offset) for offset in pair]
        columns = Columns.of(family)
        motion = moved(family, columns, method, dynamics)
        positions = Cameras(columns, scenario.reach, scenario.beside).positions(motion.angles)
        results = [result_of(each, motion, positions, b) for b, each in enumerate(family)]
        own.append(results[0])
        slopes.append(_derivatives(results, offsets))
    return own, slopes


def parameter_of(scenario: Scenario, name: str) -> Parameter:
    """Unit, bounds and scale of a parameter.

    Raises:
        InputError: the scenario has no such parameter; lists those it has.
    """
    facts = ARM_PARAMETERS | {f"{effect.name}.{fact.name}": fact for effect in scenario.effects for fact in effect.parameters()}
    if name not in facts:
        raise InputError("parameter", expected=", ".join(facts), received=repr(name))
    return facts[name]


def value_of(scenario: Scenario, name: str) -> float:
    """The value of a parameter."""
    owner, field = _owner(scenario, name)
    return float(getattr(owner if owner else scenario.arm, field))


def with_value(scenario: Scenario, name: str, value: float) -> Scenario:
    """The scenario with one parameter changed."""
    owner, field = _owner(scenario, name)
    if owner is None:
        return replace(scenario, arm=replace(scenario.arm, **{field: value}))  # type: ignore[arg-type]  # all are floats
    return replace(scenario, effects=tuple(with_values(e, **{field: value}) if e is owner else e for e in scenario.effects))


def _owner(scenario: Scenario, name: str) -> tuple[Effect | None, str]:
    parameter_of(scenario, name)  # raises for an unknown one
    owner, _, field = name.rpartition(".")
    return next((effect for effect in scenario.effects if effect.name == owner), None), field


def _offsets(value: float, fact: Parameter, fraction: float) -> tuple[float, float]:
    """Two offsets within the bounds: h and -h, or h and 2 h away from the nearer bound.

    A number that every arm has (not an amplitude, which may be zero) is changed by a fraction of itself where that is less: an
    arm a tenth as stiff as the paper's bears a tenth of the change.
    """
    has_it = fact.name in ("keq", "damping", "mass") and value > 1e-6 * fact.scale
    h = fraction * (min(fact.scale, value) if has_it else fact.scale)
    if value + h > fact.upper:
        return -h, -2 * h
    return (h, -h) if value - h >= fact.lower else (h, 2 * h)


def _derivatives(results: Sequence[SimulationResult], offsets: Array) -> Array:
    """(T, M, 3, P): slope at the first of the results of the parabola through it and the two beside it."""
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

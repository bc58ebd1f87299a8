"""How marker positions change with parameters: finite differences through one batch.

A parameter is named as in a report: a number of the arm ("keq", "damping", "mass", "tip_mass", "tilt") or of one of the
scenario's effects ("effect.parameter"). Every perturbed run shares the base run's integration (``implicit_as``), so that what
differs is the parameter alone and the differences are smooth to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi

import numpy as np

from hsr_pin.effects.effect import Effect, with_values
from hsr_pin.errors import InputError
from hsr_pin.parameters import Parameter
from hsr_pin.simulation.batch import STEP, simulate_batch
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
    )
}

#: Size of a difference, over the parameter's scale: its truncation (square) and the rounding it magnifies are both below 1e-6.
FRACTION = 1e-3


def sensitivities(
    scenarios: Sequence[Scenario],
    names: Sequence[str],
    *,
    fraction: float = FRACTION,
    central: bool = True,
    dynamics: str = "aba",
    integrator: str = "extrapolated4",
    step: float = STEP,
    threads: int = 1,
) -> tuple[list[SimulationResult], list[Array]]:
    """Simulate scenarios, and the derivatives of their marker positions to parameters, in one batch.

    Args:
        scenarios: any mixture; each must have the named effects.
        names: P parameters.
        fraction: size of a difference over the parameter's scale.
        central: False takes one neighbour instead of two: half the runs, first-order differences.
        dynamics: as for :func:`simulate_batch`.
        integrator: likewise.
        step: likewise.
        threads: likewise.

    Returns:
        The scenarios' own results, and for each (T, M, 3, P) [m per unit of the parameter]: second-order differences, central or
        (at a bound) one-sided; NaN where the run itself, or all neighbours, failed.
    """
    runs: list[Scenario] = []
    neighbours = 2 if central else 1
    offsets = np.empty((len(scenarios), len(names), neighbours))
    for scenario, pairs in zip(scenarios, offsets, strict=True):
        runs.append(scenario)
        for name, pair in zip(names, pairs, strict=True):
            value = value_of(scenario, name)
            pair[:] = _offsets(value, parameter_of(scenario, name), fraction)[:neighbours]
            shared = replace(scenario, implicit_as=scenario.implicit_as or scenario)
            runs += [with_value(shared, name, value + offset) for offset in pair]
    results = simulate_batch(runs, dynamics=dynamics, integrator=integrator, step=step, threads=threads)
    own = 1 + neighbours * len(names)
    return results[::own], [_derivatives(results[i * own : (i + 1) * own], pairs) for i, pairs in enumerate(offsets)]


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
    h = fraction * (min(fact.scale, value) if fact.name in ("keq", "damping", "mass") and value > 0 else fact.scale)
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
    per = offsets.shape[1]
    for p, steps in enumerate(offsets):
        chords = [
            ((side.trajectory.positions - centre) / offset, offset)
            for side, offset in zip(neighbours[per * p : per * (p + 1)], steps, strict=True)
            if side.completed
        ]
        if len(chords) == 2:
            (first, a), (second, b) = chords
            slopes[..., p] = (a * second - b * first) / (a - b)
        elif chords:
            slopes[..., p] = chords[0][0]
    return slopes

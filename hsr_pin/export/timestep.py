"""Largest accurate and stable time step in MuJoCo."""

from __future__ import annotations

import numpy as np

from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.parts import Parts
from hsr_pin.robot.chain import chain_of, mass_matrix
from hsr_pin.trajectory import Array

#: Candidate steps [s]; the first keeps arms within 0.5 mm of hsr_pin's motion (checked by a test); the others serve stiffer arms.
TIMESTEPS = (2.5e-4, 2e-4, 1.25e-4, 1e-4, 5e-5, 2.5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6)
#: Squared ratio of the step to the longest stable one.
_SAFETY = 4.0


def timestep(model: CorrectedModel, parts: Parts) -> float:
    """Return the longest accurate and stable time step [s].

    MuJoCo's implicit integrators are implicit in the dampers but not in the springs. With mass matrix M, dampers D and springs K,
    a step h is stable if 4 M + 2 h D - h^2 K is positive definite (for one oscillator: from its characteristic polynomial). The
    integrators are of first order, so that the step decreases with the square root of the stiffness.
    """
    arrays, arm = model.batch.arrays, model.loaded_arm
    mass = mass_matrix(chain_of(model.batch.arms))
    keq, length = np.full(1, model.arm.keq), np.full(1, model.arm.length)
    added = {effect.name: 2 * float(np.max(effect.tangent(keq, length)[0])) for effect in model.effects}
    stiff = arrays.spring[0] + sum((each.stiffest for each in parts.elements.values() if len(each.stiffest)), np.zeros(arm.links))
    stiff = stiff + arm.links * sum(added[effect.name] for effect in parts.called)
    lasting = sum(added[effect.name] for effect in model.effects if not effect.states) / model.arm.keq
    longest = TIMESTEPS[0] / np.sqrt(1 + lasting)
    systems = [(mass, arrays.damper[0], stiff)]
    if model.batch.space and np.isfinite(arrays.twist).all():
        systems.append((_twisted(arrays.axial[0]), arrays.twist_damper[0], arrays.twist[0]))
    for step in TIMESTEPS:
        if step <= longest and all(_stable(step, *system) for system in systems):
            return step
    return TIMESTEPS[-1]


def _stable(step: float, mass: Array, damper: Array, spring: Array) -> bool:
    left = 4 * mass + 2 * step * np.diag(damper) - _SAFETY * step**2 * np.diag(spring)
    return bool(np.linalg.eigvalsh(left)[0] > 0)


def _twisted(axial: Array) -> Array:
    """Return the torsional mass matrix (N, N) [kg m^2] of the straight arm: the inertia beyond the farther of two joints."""
    beyond = np.cumsum(axial[::-1])[::-1]
    return np.asarray(beyond[np.maximum.outer(np.arange(len(axial)), np.arange(len(axial)))])

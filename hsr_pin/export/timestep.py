"""How long a step of MuJoCo may be."""

from __future__ import annotations

import numpy as np

from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.parts import Parts
from hsr_pin.robot.chain import chain_of, mass_matrix
from hsr_pin.trajectory import Array

#: Steps [s]: the first keeps an arm within 0.5 mm of hsr_pin's motion (a test compares them), the others are for stiffer ones.
TIMESTEPS = (2.5e-4, 2e-4, 1.25e-4, 1e-4, 5e-5, 2.5e-5, 2e-5, 1e-5, 5e-6, 2e-6, 1e-6)
#: By how much a step is shorter than the longest stable one, squared.
_SAFETY = 4.0


def timestep(model: CorrectedModel, parts: Parts) -> float:
    """[s] the longest that is accurate and stable.

    MuJoCo's implicit integrators are implicit in the dampers and not in the springs: with mass matrix M, dampers D and springs K
    a step h is stable while 4 M + 2 h D - h^2 K is positive definite (of one oscillator: its characteristic polynomial). They are
    of first order: what is stiffer is quicker by the square root, and wants steps shorter by as much.
    """
    arrays, arm = model.columns.arrays, model.loaded_arm
    mass = mass_matrix(chain_of(model.columns.arms))
    keq, length = np.full(1, model.arm.keq), np.full(1, model.arm.length)
    added = {effect.name: 2 * float(np.max(effect.tangent(keq, length)[0])) for effect in model.effects}
    stiff = arrays.spring[0] + sum((each.stiffest for each in parts.elements.values() if len(each.stiffest)), np.zeros(arm.links))
    stiff = stiff + arm.links * sum(added[effect.name] for effect in parts.called)
    lasting = sum(added[effect.name] for effect in model.effects if not effect.states) / model.arm.keq
    longest = TIMESTEPS[0] / np.sqrt(1 + lasting)
    systems = [(mass, arrays.damper[0], stiff)]
    if model.columns.space and np.isfinite(arrays.twist).all():
        systems.append((_twisted(arrays.axial[0]), arrays.twist_damper[0], arrays.twist[0]))
    for step in TIMESTEPS:
        if step <= longest and all(_stable(step, *system) for system in systems):
            return step
    return TIMESTEPS[-1]


def _stable(step: float, mass: Array, damper: Array, spring: Array) -> bool:
    left = 4 * mass + 2 * step * np.diag(damper) - _SAFETY * step**2 * np.diag(spring)
    return bool(np.linalg.eigvalsh(left)[0] > 0)


def _twisted(axial: Array) -> Array:
    """(N, N) [kg m^2] of the straight arm that twists: what lies beyond the farther joint of two turns with both."""
    beyond = np.cumsum(axial[::-1])[::-1]
    return np.asarray(beyond[np.maximum.outer(np.arange(len(axial)), np.arange(len(axial)))])

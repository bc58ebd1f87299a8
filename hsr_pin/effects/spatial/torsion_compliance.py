"""An arm in space that twists."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.effects.effect import Effect
from hsr_pin.parameters import amplitude
from hsr_pin.robot.specification import ArmSpecification

#: Ratio of torsional to bending stiffness above which the arm is treated as rigid in torsion.
_RIGID = 1e6


@dataclass(frozen=True)
class TorsionCompliance(Effect):
    """Additional torsional compliance: 1 / torsion = 1 / declared + ratio / Keq.

    A round, uniform rod of Poisson's ratio nu has ratio = 1 + nu.
    """

    name = "torsion_compliance"
    lacks = "the arm twists"
    cause = "a body that is as soft in torsion as in bending"
    citation = "D. C. Rucker, R. J. Webster III, Statics and dynamics of continuum robots with tendon routing, IEEE TRO 27 (2011)"
    kind = "elastic"
    in_plane = False
    passive = True

    ratio: float = amplitude(0.5, "1", lower=0.0, upper=20.0, description="ratio of twist to bending under the same moment")

    def arm(self, specification: ArmSpecification) -> ArmSpecification:
        with np.errstate(divide="ignore"):
            softness = np.divide(specification.keq, specification.torsion) + self.ratio
            torsion = np.where(softness * _RIGID > 1, specification.keq / softness, np.inf)
        return replace(specification, torsion=torsion if torsion.ndim else float(torsion))  # type: ignore[arg-type]

"""An arm that becomes longer as it bends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, View
from hsr_pin.parameters import amplitude
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class LengthChange(Effect):
    """Elongation of the line of markers with bending: p_measured = p (1 + depth |theta(s)| / s).

    The line of markers is strained by depth |kappa|; this is exact for uniform curvature. The side of the arm that keeps its
    length is at the distance ``depth`` from the line: the chamber that is filled becomes longer, the opposite one does not. The
    effect of the elongation on the inertia of the arm is neglected.
    """

    name = "length_change"
    lacks = "the arm grows longer as it bends"
    cause = "no backbone, or one that lies on the side of the empty chamber"
    citation = (
        "R. J. Webster III, B. A. Jones, Design and kinematic modeling of constant curvature continuum robots, IJRR 29 (2010)"
    )
    kind = "measurement"
    passive = True

    depth: float = amplitude(
        0.002,
        "m",
        lower=-0.1,
        upper=0.1,
        description="distance from the line of markers to the side of constant length, positive away from the bend",
    )

    def observe(self, view: View) -> Array:
        along = np.maximum(view.arc_lengths, 1e-9)
        strain = np.asarray(self.depth)[..., None] * np.abs(view.turned) / along
        return np.asarray(view.positions * (1.0 + strain[..., None]))

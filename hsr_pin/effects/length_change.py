"""An arm that grows longer as it bends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from hsr_pin.effects.effect import Effect, View
from hsr_pin.parameters import parameter
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class LengthChange(Effect):
    """p_seen = p (1 + depth |theta(s)| / s): the line of markers is strained by depth |kappa|; exact for even curvature.

    The side that keeps its length lies ``depth`` beside the line: the chamber that is filled grows, the one across does not. What
    the growth does to the arm's inertia is left out.
    """

    name = "length_change"
    lacks = "the arm grows longer as it bends"
    cause = "no backbone, or one that lies on the side of the empty chamber"
    citation = (
        "R. J. Webster III, B. A. Jones, Design and kinematic modeling of constant curvature continuum robots, IJRR 29 (2010)"
    )
    kind = "measurement"
    passive = True

    depth: float = parameter(
        0.0,
        lower=-0.1,
        upper=0.1,
        unit="m",
        scale=0.002,
        amplitude=True,
        description="from the line of markers to the one that keeps its length, away from the bend where positive",
    )

    def observe(self, view: View) -> Array:
        along = np.maximum(view.arc_lengths, 1e-9)
        strain = np.asarray(self.depth)[..., None] * np.abs(view.turned) / along
        return np.asarray(view.positions * (1.0 + strain[..., None]))

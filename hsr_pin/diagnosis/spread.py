"""How what is missing is spread along the arm, whatever it does in time.

The moments of a force at the tip fall from the base to the tip with its lever; those of the muscles are even; those of laws of
the joints go with the bending. Each of these shapes, as large as it takes at every instant, leaves a share of the residual
torque; where a force at the tip leaves little and clearly less than the others, something pushes there. (An even torque tells
nothing: in the fourth sealed run what stood out as one was play or hysteresis in four of six cases.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.diagnosis.residual_torque import ResidualTorque
from hsr_pin.trajectory import Array

#: Largest share of the squared residual torque that a shape may leave, and how much less than the next it must leave.
MOST, LESS = 0.35, 0.85
#: Less than this counts as this: so well nothing is known.
_LEAST = 0.02
#: Samples at both ends of a run that are left out: derivatives are poor there.
_EDGE = 10
#: In words.
_WORDS = {"tip": "a force at the tip", "even": "an even torque of the muscles", "bending": "one that goes with the bending"}


@dataclass(frozen=True)
class Spread:
    """Shares of the squared residual torque that are left, beyond noise, by shape: "tip", "even", "bending"."""

    left: dict[str, float]

    @property
    def kind(self) -> str:
        """Kind of physics that it tells; empty if none."""
        return "contact" if self.left["tip"] <= min(MOST, LESS * self.left[self._next]) else ""

    @property
    def _next(self) -> str:
        return min(("even", "bending"), key=self.left.__getitem__)

    @property
    def sentence(self) -> str:
        """As a person would say it; empty where nothing stands out."""
        if not self.kind:
            return ""
        return (
            f"what is missing is spread along the arm as by {_WORDS['tip']} (this leaves "
            f"{100 * self.left['tip']:.0f} % of its square, {_WORDS[self._next]} {100 * self.left[self._next]:.0f} %)"
        )


def spread(torques: Sequence[ResidualTorque]) -> Spread | None:
    """Of an arm in a plane; None where there is not more than noise, or too few markers to tell shapes apart."""
    whole, samples, left = 0.0, 0, dict.fromkeys(("tip", "even", "bending"), 0.0)
    for each in torques:
        if np.iscomplexobj(each.torque) or each.modes < 2:
            return None
        noise, kept = np.maximum(each.noise, 1e-12), slice(_EDGE, -_EDGE)
        seen = each.torque[kept] / noise
        whole, samples = whole + float((seen**2).sum()) - seen.size, samples + seen.size
        for shape, values in (("tip", each.levers), ("even", np.ones_like(each.bends)), ("bending", each.bends)):
            left[shape] += _left(seen, values[kept] / noise)
    return Spread({shape: max(value / whole, _LEAST) for shape, value in left.items()}) if whole > samples else None


def _left(seen: Array, shape: Array) -> float:
    """What is left of (T, N) numbers of unit noise, beyond that, by a shape (T, N) times the best factor at each time."""
    factor = (seen * shape).sum(axis=1) / np.maximum((shape**2).sum(axis=1), 1e-300)
    return float(((seen - factor[:, None] * shape) ** 2).sum()) - seen.size + len(seen)

"""How what is missing is spread along the arm, whatever it does in time.

The moments of a force at the tip fall from the base to the tip with its lever; those of the muscles are even; those of laws of
the joints go with the bending. Each of these shapes, as large as it takes at every instant, leaves a share of the residual
torque; where a force at the tip leaves little and clearly less than the others, something pushes there. (An even torque tells
nothing: in the fourth sealed run what stood out as one was play or hysteresis in four of six cases.)

The fitted stiffness and damping took their share of it, of another shape. Once an error of theirs, one for all trials, is open
beside a shape, no law that acts alike at every place of the arm can take away what an even torque leaves, whatever it does in
time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hsr_pin.diagnosis.residual_torque import ResidualTorque

#: Largest share of the squared residual torque that a shape may leave, and how much less than the next it must leave.
MOST, LESS = 0.35, 0.85
#: What is missing is not even where a force at the tip takes away at least this share of it more than an even torque does, and
#: leaves no more than this much of what that leaves: so it was in the five forces, and in none of 18 laws that act evenly, among
#: the cases of the ninth sealed run by which this was set.
MORE, NEARER = 0.1, 0.75
#: ... or this much more, and leaves no more than this much: of 1196 diagnoses (tenth to thirteenth sealed run, and two further
#: plants) 13 show that and not the former; a law that acts evenly is in one of them, and closes its gap.
SOME, NEAREST = 0.05, 0.34
#: Less than this counts as this: so well nothing is known.
_LEAST = 0.02
#: Samples of a run that are looked at: derivatives are poor at its ends.
_KEPT = slice(10, -10)
#: In words.
_WORDS = {"tip": "a force at the tip", "even": "an even torque of the muscles", "bending": "one that goes with the bending"}


@dataclass(frozen=True)
class Spread:
    """Shares of the squared residual torque that are left, beyond noise, by shape: "tip", "even", "bending".

    Attributes:
        left: by each shape alone.
        beside: by each shape, and stiffness and damping, of what these leave.
    """

    left: dict[str, float]
    beside: dict[str, float] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """Kind of physics that it tells; empty if none."""
        return "contact" if self.left["tip"] <= min(MOST, LESS * self.left[self._next]) else ""

    @property
    def uneven(self) -> bool:
        """Whether no law that acts alike at every place of the arm can be what is missing: a force at the tip is nearer to it.

        By itself, where stiffness and damping leave nothing beyond noise.
        """
        tip, even = self._shares
        return self.plain or (even - tip >= MORE and tip <= NEARER * even)

    @property
    def plain(self) -> bool:
        """Whether a force at the tip is far nearer."""
        tip, even = self._shares
        return even - tip >= SOME and tip <= NEAREST * even

    @property
    def _shares(self) -> tuple[float, float]:
        shares = self.beside or self.left
        return shares["tip"], shares["even"]

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
    if any(np.iscomplexobj(each.torque) or each.modes < 2 for each in torques):
        return None
    shapes = ("tip", "even", "bending")
    whole, samples = _left(torques, ""), sum(each.torque[_KEPT].size for each in torques)
    if whole <= samples:
        return None
    left = {shape: max(_left(torques, shape) / whole, _LEAST) for shape in shapes}
    rest = _left(torques, "", beside=True)
    own = {shape: max(_left(torques, shape, beside=True) / rest, _LEAST) for shape in shapes} if rest > samples else {}
    return Spread(left, own)


def _left(torques: Sequence[ResidualTorque], shape: str, *, beside: bool = False) -> float:
    """What is left of numbers of unit noise, beyond that, by a shape times the best factor at each time; none for "".

    ``beside``: and by a stiffness and a damping, one for all.
    """
    rows, columns, told = [], [], 0
    for each in torques:
        noise = np.maximum(each.noise, 1e-12)
        arm = (each.bends, each.rates) if beside else ()
        values = [part[_KEPT] / noise for part in (each.torque, *arm)]
        if shape:
            one = {"tip": each.levers, "even": np.ones_like(each.bends), "bending": each.bends}[shape][_KEPT] / noise
            size = np.maximum((one**2).sum(axis=1), 1e-300)[:, None]
            values = [part - one * ((part * one).sum(axis=1)[:, None] / size) for part in values]
        told += values[0].size - len(values[0]) * bool(shape)
        rows.append(values[0].ravel())
        columns.append(np.stack([part.ravel() for part in values[1:]], axis=1) if beside else np.zeros((values[0].size, 0)))
    missing, known = np.concatenate(rows), np.concatenate(columns)
    rest = missing - known @ np.linalg.lstsq(known, missing, rcond=None)[0] if beside else missing
    return float(rest @ rest) - told

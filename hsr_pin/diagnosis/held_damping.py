"""The other reading of a large damping: damping as it was declared, and a torque that comes slowly.

A damper that is many times too strong makes an arm late as a slow supply does, and takes away, in its place, what that does.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.crew import Crew
from hsr_pin.diagnosis.search import without
from hsr_pin.diagnosis.thresholds import left
from hsr_pin.identification.fit import Fit

#: A damping this many times the declared one is seldom damping alone.
MUCH = 5.0
DAMPING = "damping_scale"


@dataclass(frozen=True, eq=False)
class HeldDamping:
    """The best model with the damping as declared.

    Attributes:
        damping: what it came out otherwise, over the declared one: with stiffness alone beside it, and in the best model.
        slow, others: names of the laws that make the torque late, and of the other ones.
        shares: of the squared gap that stiffness alone leaves, held out, what the former take away, and what the latter then do.
        model: with all of them.
    """

    damping: tuple[float, float]
    slow: tuple[str, ...]
    others: tuple[str, ...]
    shares: tuple[float, float]
    model: Candidate


def with_damping_held(base: Candidate, best: Candidate, crew: Crew) -> HeldDamping | None:
    """That reading of the best model; None where the torque comes at once in it, or the damping is none to wonder at.

    Nor where there is a damping for each stiffness level, or where the slow torque takes nothing away.

    Args:
        base: stiffness and damping alone.
        best: the best model.
        crew: who does the fitting.
    """
    slow = tuple(part.name for part in best.fit.hypothesis.parts if part.kind == "actuation_time")
    damping = (base.fit.named.get(DAMPING, 1.0), best.fit.named.get(DAMPING, 1.0))
    if not slow or DAMPING not in best.fit.named or max(damping) <= MUCH:
        return None
    held = without(best.fit, DAMPING)
    others = tuple(name for name in best.names if name not in slow)
    late = _without_all(held, others)
    stiffness = _without_all(late, slow)
    alone, timed = crew.finish([stiffness, late])
    whole = crew.finish([_at(held, timed.fit)])[0] if others else timed
    gap = max(left(alone), 1e-300)
    shares = ((left(alone) - left(timed)) / gap, (left(timed) - left(whole)) / gap)
    return HeldDamping(damping, slow, others, shares, whole) if shares[0] > 0 else None


def _without_all(fit: Fit, names: Iterable[str]) -> Fit:
    for name in names:
        fit = without(fit, name)
    return fit


def _at(fit: Fit, found: Fit) -> Fit:
    """A place to start from with the values that a smaller model has found."""
    return replace(fit, values=np.array([found.named.get(name, value) for name, value in fit.named.items()]))

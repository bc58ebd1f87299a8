"""What is reported of an arm: the words of a verdict, and the plane in which the arm bends."""

from __future__ import annotations

from dataclasses import replace

from hsr_pin.effects.effect import KINDS
from hsr_pin.identification.part import SESSION
from hsr_pin.identification.plane import Plane
from hsr_pin.inference.verdict import Verdict, Vocabulary


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f} mm"


#: How verdicts on arms call what they speak of.
WORDS = Vocabulary(
    fitted="stiffness and damping",
    size=_mm,
    kinds=KINDS,
    numbers={
        "torque_gain": "another gain of the torque (torque_gain)",
        "mass_scale": "another mass (mass_scale)",
        "keq_drift": "a stiffness that changes over the session (keq_drift)",
        "gain_drift": "a gain of the torque that changes over the session (gain_drift)",
    },
    session=frozenset(SESSION),
)


def turned_plane(verdict: Verdict, plane: Plane | None) -> Verdict:
    """A verdict with the plane that was turned back before any model was fitted."""
    if plane is None or not plane.kind:
        return verdict
    nothing = verdict.status in ("no_gap", "parameters", "unexplained")
    return replace(
        verdict,
        status="partly_identified" if nothing else verdict.status,
        kinds=tuple(sorted({*verdict.kinds, plane.kind})),
        sentence=f"{verdict.sentence} Besides, of the kind {plane.kind}: {plane.sentence}.",
    )

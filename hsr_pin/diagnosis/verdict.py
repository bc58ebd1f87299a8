"""Vocabulary of verdicts on arms, and the verdict on a rotated plane of bending."""

from __future__ import annotations

from dataclasses import replace

from hsr_pin.effects.effect import KINDS
from hsr_pin.identification.part import SESSION
from hsr_pin.identification.plane import Plane
from hsr_pin.inference.verdict import Verdict, Vocabulary


def millimetres(metres: float) -> str:
    """Return a length in millimetres with two decimals."""
    return f"{1e3 * metres:.2f} mm"


#: Vocabulary of verdicts on arms.
WORDS = Vocabulary(
    fitted="stiffness and damping",
    size=millimetres,
    kinds=KINDS,
    numbers={
        "torque_gain": "a different torque gain (torque_gain)",
        "mass_scale": "a different mass (mass_scale)",
        "keq_drift": "a stiffness drift over the session (keq_drift)",
        "gain_drift": "a drift of the torque gain over the session (gain_drift)",
    },
    session=frozenset(SESSION),
)


def turned_plane(verdict: Verdict, plane: Plane | None) -> Verdict:
    """Return a verdict with the rotated plane of bending that was corrected before the fits, if any."""
    if plane is None or not plane.kind:
        return verdict
    nothing = verdict.status in ("no_gap", "parameters", "unexplained")
    return replace(
        verdict,
        status="partly_identified" if nothing else verdict.status,
        kinds=tuple(sorted({*verdict.kinds, plane.kind})),
        sentence=f"{verdict.sentence} In addition, of the kind {plane.kind}: {plane.sentence}.",
    )

"""How likely a name is right: a logistic function of what speaks for it, fitted to arms that were made for the purpose.

The coefficients were set by eye on 25 cases of the blind check's plants (seed 501, used for nothing else), in which right and
wrong names lay far apart; ``scripts/calibrate.py`` fits them where there are more. Sealed runs tell how often names of each
confidence were right (reliability diagram).
"""

from __future__ import annotations

from math import exp, isfinite, log

from hsr_pin.diagnosis.support import Support

#: Of a part: constant, lead, log margin, log clearness, drift.
NAME = (-0.5, 1.5, 1.2, 0.2, -2.0)
#: Of a kind, likewise.
KIND = (0.0, 1.5, 1.2, 0.2, -2.0)
#: Where a part acts in one environment alone its drift is not known: as if it were this.
_UNKNOWN = 0.3


def features(support: Support) -> tuple[float, float, float, float, float]:
    """What the coefficients multiply."""
    return (
        1.0,
        min(max(support.lead, 0.0), 1.0),
        log(min(max(support.margin, 1e-3), 1e3)),
        log(min(max(support.clear, 0.1), 1e3) / 10),
        min(support.drift, 2.0) if isfinite(support.drift) else _UNKNOWN,
    )


def probability(support: Support, coefficients: tuple[float, ...]) -> float:
    """From 0 to 1."""
    total = sum(weight * value for weight, value in zip(coefficients, features(support), strict=True))
    return support.frequency / (1 + exp(-total))

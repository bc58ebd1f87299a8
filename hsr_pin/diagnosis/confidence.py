"""How likely a name is right: a logistic function of what speaks for it, fitted to cases whose answers are known.

``scripts/calibrate.py`` fitted the coefficients to the 326 cases of the sixth sealed run (seed 527973) after it had been scored:
to its verdicts, those of 32 cases made anew after the mends that it led to. Later sealed runs tell how often names of each
confidence were right (reliability diagram).
"""

from __future__ import annotations

from math import exp, isfinite, log

from hsr_pin.diagnosis.support import Support

#: Of a part: constant, lead, log margin, log clearness, drift, rest.
NAME = (-0.92, 0.53, 0.24, 1.02, -0.51, -0.84)
#: Of a kind, likewise.
KIND = (-0.68, 0.70, 0.31, 0.87, -0.87, -0.73)
#: Where a part acts in one environment alone its drift is not known: as if it were this.
_UNKNOWN = 0.3


def features(support: Support) -> tuple[float, ...]:
    """What the coefficients multiply."""
    return (
        1.0,
        min(max(support.lead, 0.0), 1.0),
        log(min(max(support.margin, 1e-3), 1e3)),
        log(min(max(support.clear, 0.1), 1e3) / 10),
        min(support.drift, 2.0) if isfinite(support.drift) else _UNKNOWN,
        min(max(support.rest, 0.0), 1.0),
    )


def probability(support: Support, coefficients: tuple[float, ...]) -> float:
    """From 0 to 1; half of it only where the best model is never better than the best without the part."""
    total = sum(weight * value for weight, value in zip(coefficients, features(support), strict=True))
    return (1 + support.frequency) / 2 / (1 + exp(-total))

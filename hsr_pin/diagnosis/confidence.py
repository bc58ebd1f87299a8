"""How likely a name is right: a logistic function of what speaks for it, fitted to cases whose answers are known.

``scripts/calibrate.py`` fitted the coefficients: of names to the 326 cases of the fifth sealed run (seed 561364), after it had
been scored; of kinds to those of the third (762929), for the fifth found these as often right as they say. Later sealed runs tell
how often names of each confidence were right (reliability diagram).
"""

from __future__ import annotations

from math import exp, isfinite, log

from hsr_pin.diagnosis.support import Support

#: Of a part: constant, lead, log margin, log clearness, drift, rest.
NAME = (-0.40, 1.04, 0.26, 0.90, -0.81, -0.86)
#: Of a kind, likewise.
KIND = (0.28, 0.49, 0.34, 0.47, -0.17, -1.06)
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

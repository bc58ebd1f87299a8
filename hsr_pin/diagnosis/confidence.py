"""How likely a name is right: a logistic function of what speaks for it, fitted to cases whose answers are known.

``scripts/calibrate.py`` fitted coefficients to the 326 cases of the sixth sealed run (seed 527973) after it had been scored,
those of 32 cases made anew after the mends that it led to. These are the means of them and of those before (names: of the fifth
run, 561364; kinds: of the third, 762929), as if fitted to both. The last coefficient, of what recordings show without a model,
was fitted beside them to the sixth and the seventh run (928745), those cases made anew that they had led to mend: 0.64 for
kinds, 0.32 for names; two thirds of that are taken, for the two runs differ.

Names were right more often than this says, in the seventh and in the eighth run (350227) alike, the more so the less likely it
holds them: what is stated is scaled by that (J. Platt, Probabilistic Outputs for Support Vector Machines, 1999), as
``scripts/scale_confidence.py`` fits it to both. Scaled by the seventh alone the eighth's calibration error goes from 0.070 to
0.046. Later sealed runs tell how often names of each confidence were right (reliability diagram).

Kinds are scaled as that script fits them to the seventh to tenth run (928745, 350227, 425658, 80977). Of the further shifts that
it finds for each kind two are taken: of claims of 0.5 to 0.8 damping was right in 15 of 16, friction in all 10, the others in 93
of 132. That of a torque that comes late, -0.47, is of the seventh run alone (-1.02; 0.18, 0.13 and -0.06 in the others), and
measurement is not scaled, though such claims of it were right in 6 of 37: most of those were below 0.75, from where on it was
right in 146 of 168.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import exp, isfinite, log
from types import MappingProxyType
from typing import NamedTuple

from hsr_pin.diagnosis.support import Support


class Coefficients(NamedTuple):
    """Of one sort of claim.

    Attributes:
        weights: of the constant, lead, log margin, log clearness, drift, rest, shown.
        shift, power: what is stated has the odds exp(shift) o^power, o those that the weights give.
        of_kind: a further shift, of claims of a kind of physics.
    """

    weights: tuple[float, ...]
    shift: float = 0.0
    power: float = 1.0
    of_kind: Mapping[str, float] = MappingProxyType({})


#: Of a part.
NAME = Coefficients((-0.66, 0.79, 0.25, 0.96, -0.66, -0.85, 0.2), shift=1.07, power=0.62)
#: Of a kind.
KIND = Coefficients(
    (-0.20, 0.59, 0.33, 0.67, -0.52, -0.90, 0.4),
    shift=0.22,
    power=1.02,
    of_kind=MappingProxyType({"damping": 0.63, "friction": 0.85, "measurement": -0.22}),
)
#: No claim is stated as less likely than this before it is scaled, nor as closer to certain.
_SURELY = 1e-3
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
        support.shown,
    )


def probability(support: Support, coefficients: Coefficients) -> float:
    """From 0 to 1; before it is scaled, half of it only where the best model is never better than the best without the part."""
    total = sum(weight * value for weight, value in zip(coefficients.weights, features(support), strict=True))
    shift = coefficients.shift + coefficients.of_kind.get(support.kind, 0.0)
    return scaled((1 + support.frequency) / 2 / (1 + exp(-total)), shift, coefficients.power)


def scaled(stated: float, shift: float, power: float) -> float:
    """A probability scaled as :class:`Coefficients` say."""
    return 1 / (1 + exp(-shift - power * odds(stated)))


def odds(probability: float) -> float:
    """Their logarithm, of a probability that is neither nearer to impossible nor to certain than :data:`_SURELY`."""
    inside = min(max(probability, _SURELY), 1 - _SURELY)
    return log(inside / (1 - inside))

"""The appearance of the arm: three muscles around a backbone, coloured from base to tip."""

from __future__ import annotations

import math
from typing import Any

from hsr_pin.robot.specification import ArmSpecification

#: Colours from base to tip: matplotlib's "viridis" at even steps from 0.1 to 1, perceptually uniform and safe for colour-blind
#: readers.
_RAMP = ((0.283, 0.141, 0.458), (0.194, 0.399, 0.556), (0.119, 0.611, 0.539), (0.422, 0.806, 0.352), (0.993, 0.906, 0.144))

#: Largest number of links that are drawn with muscles; more and shorter links are plain discs, which are faster to display.
_DETAILED_LINKS = 64


def colour(place: float) -> tuple[float, float, float]:
    """Return the colour (r, g, b), from 0 to 1, at ``place``, from 0 (base) to 1 (tip)."""
    i = min(int(place * (len(_RAMP) - 1)), len(_RAMP) - 2)
    share = place * (len(_RAMP) - 1) - i
    red, green, blue = (round((1 - share) * a + share * b, 4) for a, b in zip(_RAMP[i], _RAMP[i + 1], strict=True))
    return red, green, blue


def shape(spec: ArmSpecification) -> dict[str, Any]:
    """Return the dimensions of the drawing [m]: a backbone between three muscles, and a disc on each link."""
    diameter, ring, third = spec.diameter, 0.26 * spec.diameter, 2 * math.pi / 3
    detailed = spec.links <= _DETAILED_LINKS
    return {
        "outer": diameter / 2,
        "backbone": 0.12 * diameter,
        "marker": 0.12 * diameter,
        "disc_share": 0.3 if detailed else 1.0,
        "disc": 0.2 * diameter,
        "muscle": 0.2 * diameter,
        "muscles": [(ring * math.cos(turn), ring * math.sin(turn)) for turn in (0.0, third, -third)] if detailed else [],
    }

"""Whether declared numbers can be those of an arm: masses and diameters off by a thousand and angles in degrees are refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from operator import mul
from typing import Any

#: No arm is denser than osmium, or lighter than the air that it displaces [kg/m3].
DENSEST, LIGHTEST = 22_600.0, 1.2
#: No arm is thicker than this times its length: a length and a diameter in different units are apart by a thousand.
THICKEST = 2.0
#: No arm carries more than this times its own mass.
HEAVIEST = 30.0
#: An arm whose farthest marker is this share of its arc length behind the base in every trial points another way.
BACK = 0.5
_ALONG = {"hanging": (0.0, 0.0, -1.0), "upright": (0.0, 0.0, 1.0), "horizontal": (1.0, 0.0, 0.0)}
_WAYS = {"hanging": "down", "upright": "up", "horizontal": "along +x"}
#: A direction is said within a turn either way [rad].
TURN = 2 * math.pi
#: What units of length and mass differ by.
THOUSAND = 1000.0


@dataclass(frozen=True)
class Doubt:
    """Why a declared number cannot be meant: the facts of an error, and the key that it is of."""

    key: str
    expected: str
    received: str
    hint: str

    @property
    def facts(self) -> dict[str, Any]:
        """All but the key."""
        return {"expected": self.expected, "received": self.received, "hint": self.hint}


def size_doubt(length: float, mass: float, diameter: float) -> Doubt | None:
    """What is wrong with the size [m, kg, m] of an arm; None: nothing."""
    if diameter > THICKEST * length:
        hint = f"diameters are in metres: is it in mm? then {diameter / THOUSAND:g}"
        return Doubt("diameter", f"at most {THICKEST * length:g} m for an arm of {length:g} m", f"{diameter:g} m", hint)
    volume = math.pi / 4 * diameter**2 * length
    low, high = LIGHTEST * volume, DENSEST * volume
    if low <= mass <= high:
        return None
    size = f"{low:.2g} to {high:.2g} kg for an arm of {length:g} m and {diameter:g} m diameter (between air and osmium)"
    if low <= mass / THOUSAND <= high:
        hint = f"masses are in kg: is it in grams? then {mass / THOUSAND:g}"
    elif low <= mass * THOUSAND <= high:
        hint = f"masses are in kg: is it in tonnes? then {mass * THOUSAND:g}"
    else:
        hint = "is the mass in kg, and the outer diameter in m?"
    return Doubt("mass", size, f"{mass:g} kg", hint)


def payload_doubt(mass: float, tip_mass: float) -> Doubt | None:
    """What is wrong with a mass at the tip of an arm [kg]; None: nothing."""
    if tip_mass <= HEAVIEST * mass:
        return None
    hint = f"masses are in kg: is it in grams? then {tip_mass / THOUSAND:g}"
    return Doubt("tip_mass", f"at most {HEAVIEST * mass:g} kg on an arm of {mass:g} kg", f"{tip_mass:g} kg", hint)


def mount_doubt(mount: str, places: Sequence[tuple[float, float, float]], reach: float) -> Doubt | None:
    """What is wrong with where the straight arm is said to point; None: nothing.

    Args:
        mount: "hanging", "upright" or "horizontal".
        places: [m] of the farthest marker from the base, in the middle of each trial's samples.
        reach: [m] its arc length.
    """
    along = {name: [sum(map(mul, place, way)) for place in places] for name, way in _ALONG.items()}
    if not places or max(along[mount]) > -BACK * reach:
        return None
    fits = max(along, key=lambda name: min(along[name]))
    where = f"{-max(along[mount]):.3g} m the other way in every trial"
    return Doubt("mount", f"an arm that points {_WAYS[mount]}", where, f'is it mount = "{fits}"? z is up')


def exchanged(arc_lengths: Sequence[float], distances: Sequence[float]) -> tuple[int, int] | None:
    """Two markers of which the nearer one is where only the farther one can be; None: there are none.

    The backbone does not stretch: no marker is farther from the base than its arc length.

    Args:
        arc_lengths: [m] of each marker.
        distances: [m] of each from the base, in most samples; NaN where it was not seen.
    """
    for near, far in permutations(range(len(arc_lengths)), 2):
        half = (arc_lengths[far] - arc_lengths[near]) / 2
        if half > 0 and distances[near] > arc_lengths[near] + half and distances[far] < distances[near] - half:
            return near, far
    return None


def angle_doubt(angle: float) -> Doubt | None:
    """What is wrong with a direction [rad]; None: nothing."""
    if abs(angle) <= TURN:
        return None
    hint = f"is it in degrees? then {math.radians(angle):.4g}"
    return Doubt("angle", f"-{TURN:.4g} to {TURN:.4g} rad", f"{angle:g}", hint)

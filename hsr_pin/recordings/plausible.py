"""Plausibility checks of the declared numbers of an arm: values in the wrong unit (grams, mm, degrees) are refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from operator import mul
from typing import Any

#: Largest and smallest density of an arm: that of osmium, and that of air [kg/m3].
DENSEST, LIGHTEST = 22_600.0, 1.2
#: Largest ratio of diameter to length; in different units, the two differ by a factor of a thousand.
THICKEST = 2.0
#: Largest ratio of payload to mass of the arm.
HEAVIEST = 30.0
#: The mount is wrong if the outermost marker is this share of its arc length behind the base in every trial.
BACK = 0.5
_DIRECTIONS = {"hanging": (0.0, 0.0, -1.0), "upright": (0.0, 0.0, 1.0), "horizontal": (1.0, 0.0, 0.0)}
_DIRECTIONS["flat"] = _DIRECTIONS["horizontal"]
_DIRECTION_NAMES = {"hanging": "down", "upright": "up", "horizontal": "along +x", "flat": "along +x"}
#: Largest absolute value of an angle: one turn [rad].
TURN = 2 * math.pi
#: Ratio of neighbouring units of length and of mass.
THOUSAND = 1000.0


@dataclass(frozen=True)
class ImplausibleValue:
    """Reason why a declared number is implausible: its key, and the parts of an error message."""

    key: str
    expected: str
    received: str
    hint: str

    @property
    def facts(self) -> dict[str, Any]:
        """Parts of the error message, by name."""
        return {"expected": self.expected, "received": self.received, "hint": self.hint}


def implausible_size(length: float, mass: float, diameter: float) -> ImplausibleValue | None:
    """Return why length [m], mass [kg] or diameter [m] of an arm are implausible; None if they are plausible."""
    if diameter > THICKEST * length:
        hint = f"the diameter is in metres; if this is mm, write {diameter / THOUSAND:g}"
        return ImplausibleValue(
            "diameter", f"at most {THICKEST * length:g} m for an arm of {length:g} m", f"{diameter:g} m", hint
        )
    volume = math.pi / 4 * diameter**2 * length
    low, high = LIGHTEST * volume, DENSEST * volume
    if low <= mass <= high:
        return None
    size = f"{low:.2g} to {high:.2g} kg for an arm of {length:g} m and {diameter:g} m diameter (between air and osmium)"
    if low <= mass / THOUSAND <= high:
        hint = f"the mass is in kg; if this is grams, write {mass / THOUSAND:g}"
    elif low <= mass * THOUSAND <= high:
        hint = f"the mass is in kg; if this is tonnes, write {mass * THOUSAND:g}"
    else:
        hint = "check that the mass is in kg and the outer diameter in m"
    return ImplausibleValue("mass", size, f"{mass:g} kg", hint)


def implausible_payload(mass: float, tip_mass: float) -> ImplausibleValue | None:
    """Return why the payload at the tip [kg] is implausible for the mass of the arm [kg]; None if it is plausible."""
    if tip_mass <= HEAVIEST * mass:
        return None
    hint = f"the mass is in kg; if this is grams, write {tip_mass / THOUSAND:g}"
    return ImplausibleValue("tip_mass", f"at most {HEAVIEST * mass:g} kg on an arm of {mass:g} kg", f"{tip_mass:g} kg", hint)


def implausible_mount(mount: str, places: Sequence[tuple[float, float, float]], reach: float) -> ImplausibleValue | None:
    """Return why the declared mount contradicts the marker positions; None if it does not.

    Args:
        mount: mount of the arm.
        places: position [m] of the outermost marker relative to the base, the median over each trial.
        reach: arc length of that marker [m].
    """
    along = {name: [sum(map(mul, place, direction)) for place in places] for name, direction in _DIRECTIONS.items()}
    if not places or max(along[mount]) > -BACK * reach:
        return None
    fits = max(along, key=lambda name: min(along[name]))
    where = f"{-max(along[mount]):.3g} m in the opposite direction in every trial"
    return ImplausibleValue(
        "mount", f"an arm that points {_DIRECTION_NAMES[mount]}", where, f'z is up; mount = "{fits}" fits the recordings'
    )


def exchanged(arc_lengths: Sequence[float], distances: Sequence[float]) -> tuple[int, int] | None:
    """Return the indices of two markers whose distances show that their names are exchanged; None if there are none.

    The backbone does not stretch, so that no marker is farther from the base than its arc length.

    Args:
        arc_lengths: arc length of each marker [m].
        distances: median distance of each marker from the base [m]; NaN for a marker that was not seen.
    """
    for near, far in permutations(range(len(arc_lengths)), 2):
        half = (arc_lengths[far] - arc_lengths[near]) / 2
        if half > 0 and distances[near] > arc_lengths[near] + half and distances[far] < distances[near] - half:
            return near, far
    return None


def implausible_angle(angle: float) -> ImplausibleValue | None:
    """Return why an angle [rad] is implausible; None if it is plausible."""
    if abs(angle) <= TURN:
        return None
    hint = f"the angle is in rad; if this is degrees, write {math.radians(angle):.4g}"
    return ImplausibleValue("angle", f"-{TURN:.4g} to {TURN:.4g} rad", f"{angle:g}", hint)

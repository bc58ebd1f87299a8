"""Recipes of cases from recordings of hardware: recording, trials, edit and truth.

A case is fair because the edit is known, and because it causes at least half of the squared distance that stiffness and damping
leave. The chain plant shows this, refitted with and without the edit. (For commands instead of measured pressures, damping
absorbs most of the effect; a lag that differs between filling and venting removes half of what remains.) Two edits fail this test
and were left out: an undeclared payload of real-trunk, because the mass of the trunk is itself a guess that absorbs it; and an
input of real-pneumatic shifted by less than two seconds, because the arm's own time constant, C over K, is about one second and
absorbs it.

A real arm has model discrepancies of its own, whose truth is unknown. Therefore a verdict on a real case is right if it names the
withheld cause, alone or among the alternatives, or reports its kind; further names do not count as mistakes. It is wrong only if
it names neither the cause nor its kind, but something of a kind that this arm is not known to have (`OTHER_KINDS`): for example,
an arm whose motor stands still has no actuator lag. To name nothing, or only what the arm may have, is a miss.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from hsr_pin.blind.real import edits
from hsr_pin.trajectory import Dataset

#: Recording -> kinds of physics that this arm may have in addition to the withheld cause.
OTHER_KINDS: dict[str, tuple[str, ...]] = {
    # Silicone, clamped, no actuator (M. Dubied et al., IEEE RA-L 2022).
    "real-beam": ("elastic", "damping", "creep", "friction"),
    # Tendons through discs; mass and stiffness guessed; manual releases; scattered rest poses (its SOURCE).
    "real-trunk": ("elastic", "damping", "creep", "friction", "mass_gravity", "contact"),
    # Two segments with one torque of guessed scale; idle pressures; fabric and rubber (its SOURCE).
    "real-pneumatic": ("elastic", "damping", "creep", "friction", "actuation_map"),
}


#: Recording -> time after the declared release from which its samples are used [s]; before, a hand may still touch the arm.
START_DELAY: dict[str, float] = {"real-trunk": 0.1}


class Truth(NamedTuple):
    """Right answers of a recipe: names, the catalogue's first, and kinds."""

    names: tuple[str, ...]
    kinds: tuple[str, ...]


@dataclass(frozen=True)
class Recipe:
    """Recipe of one case.

    Attributes:
        recording: folder among the recordings.
        trials: numbers of its trials, from 1.
        edit: edit of the recording.
        amount: amount of the edit, in the unit of the edit; the drawn amount is up to a tenth smaller or a fifth larger,
            and has a random sign if both signs are possible.
        truth: right answers.
    """

    recording: str
    trials: tuple[int, ...]
    edit: Callable[[Dataset, float], Dataset]
    amount: float
    truth: Truth

    @property
    def either_way(self) -> bool:
        """Whether the edit may also have a negative amount, towards negative bending."""
        return self.edit in (edits.turn_frame, edits.move_markers)

    @property
    def measured(self) -> bool:
        """Whether the input closest to the truth is the torque of measured pressures."""
        return self.recording == "real-pneumatic" and self.edit is not edits.leave_commanded


_TIP = Truth(("tip_mass",), ("mass_gravity",))
_MASS = Truth(("added_mass", "mass_scale"), ("mass_gravity",))
_TILT = Truth(("gravity_tilt",), ("mass_gravity", "measurement"))
_MARKERS = Truth(("marker_offset",), ("measurement",))
_PLACES = Truth(("marker_slip", "length_change"), ("measurement",))
_TIME = Truth(("actuator_lag", "unequal_lag", "dead_time"), ("actuation_time",))
_LATE = Truth(("dead_time", "actuator_lag", "unequal_lag"), ("actuation_time",))

_BEAM = (1, 2, 3, 4)
_TRUNK = {k: tuple(range(k, 33, 5)) for k in range(1, 6)}  # each selection contains both payloads

#: All recipes by name.
RECIPES: dict[str, Recipe] = {
    "beam-frame-a": Recipe("real-beam", _BEAM, edits.turn_frame, 0.07, _TILT),
    "beam-frame-b": Recipe("real-beam", _BEAM, edits.turn_frame, 0.1, _TILT),
    "beam-markers-a": Recipe("real-beam", _BEAM, edits.move_markers, 0.005, _MARKERS),
    "beam-markers-b": Recipe("real-beam", _BEAM, edits.move_markers, 0.007, _MARKERS),
    "beam-mass-a": Recipe("real-beam", _BEAM, edits.declare_mass, 0.4, _MASS),
    "beam-mass-b": Recipe("real-beam", _BEAM, edits.declare_mass, 0.55, _MASS),
    "beam-payload": Recipe("real-beam", (3, 4), edits.declare_payload, 0.043, _TIP),
    "beam-places": Recipe("real-beam", _BEAM, edits.declare_middle, 0.15, _PLACES),
    "pneumatic-command-a": Recipe("real-pneumatic", (1, 2, 3), edits.leave_commanded, 0.0, _TIME),
    "pneumatic-command-b": Recipe("real-pneumatic", (4, 5, 6), edits.leave_commanded, 0.0, _TIME),
    "pneumatic-command-c": Recipe("real-pneumatic", (7, 8, 9), edits.leave_commanded, 0.0, _TIME),
    "pneumatic-command-d": Recipe("real-pneumatic", (1, 4, 7), edits.leave_commanded, 0.0, _TIME),
    "pneumatic-frame-a": Recipe("real-pneumatic", (4, 5, 6), edits.turn_frame, 0.08, _TILT),
    "pneumatic-frame-b": Recipe("real-pneumatic", (7, 8, 9), edits.turn_frame, 0.1, _TILT),
    "pneumatic-frame-c": Recipe("real-pneumatic", (4, 6, 8), edits.turn_frame, 0.14, _TILT),
    "pneumatic-late-a": Recipe("real-pneumatic", (4, 5, 6), edits.delay_motion, 2.5, _LATE),
    "pneumatic-late-b": Recipe("real-pneumatic", (7, 8, 9), edits.delay_motion, 3.0, _LATE),
    "pneumatic-markers-a": Recipe("real-pneumatic", (4, 5, 6), edits.move_markers, 0.015, _MARKERS),
    "pneumatic-markers-b": Recipe("real-pneumatic", (7, 8, 9), edits.move_markers, 0.02, _MARKERS),
    "pneumatic-places": Recipe("real-pneumatic", (5, 7, 9), edits.declare_middle, 0.3, _PLACES),
    "trunk-frame-a": Recipe("real-trunk", _TRUNK[1], edits.turn_frame, 0.1, _TILT),
    "trunk-frame-b": Recipe("real-trunk", _TRUNK[2], edits.turn_frame, 0.14, _TILT),
    "trunk-frame-c": Recipe("real-trunk", _TRUNK[3], edits.turn_frame, 0.18, _TILT),
    "trunk-markers-a": Recipe("real-trunk", _TRUNK[4], edits.move_markers, 0.02, _MARKERS),
    "trunk-markers-b": Recipe("real-trunk", _TRUNK[5], edits.move_markers, 0.03, _MARKERS),
    "trunk-places": Recipe("real-trunk", _TRUNK[1], edits.declare_middle, 0.3, _PLACES),
}

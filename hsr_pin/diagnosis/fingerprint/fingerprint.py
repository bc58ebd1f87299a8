"""The fingerprint of an arm: everything that its recordings show before any model is asked.

Of an arm in space it is that of the trials which stay on one line (:mod:`~hsr_pin.diagnosis.fingerprint.lines`), and how its
swings differ by the side.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from hsr_pin.diagnosis.fingerprint.creep import creep
from hsr_pin.diagnosis.fingerprint.decay import decay
from hsr_pin.diagnosis.fingerprint.length import length
from hsr_pin.diagnosis.fingerprint.lines import lines
from hsr_pin.diagnosis.fingerprint.loops import loops
from hsr_pin.diagnosis.fingerprint.out_of_plane import out_of_plane
from hsr_pin.diagnosis.fingerprint.prints import KINDS, Print, plain
from hsr_pin.diagnosis.fingerprint.rests import rests
from hsr_pin.diagnosis.fingerprint.sides import sides
from hsr_pin.diagnosis.fingerprint.start import Stretch, start_stretch
from hsr_pin.diagnosis.fingerprint.timing import timing
from hsr_pin.identification.experiment import Experiment

#: In the order of a report.
_PRINTS = (timing, loops, decay, creep, rests, out_of_plane, length)
#: Of an arm in space, from commands that stay on a line.
_ON_LINES = (timing, loops, creep)


@dataclass(frozen=True, eq=False)
class Fingerprint:
    """What recordings show without a model.

    Attributes:
        prints: those that the recordings can show, in the order of a report.
        starts: for every run, in their order, how long something else acts at its start.
        notes: what they are of, where that is not everything.
    """

    prints: tuple[Print, ...]
    starts: tuple[Stretch, ...]
    notes: tuple[str, ...] = ()

    @property
    def kinds(self) -> tuple[str, ...]:
        """What any print points to, each once, in the order of the list of kinds."""
        found = {kind for each in self.prints for kind in each.kinds}
        return tuple(kind for kind in KINDS if kind in found)

    def named(self, name: str) -> Print | None:
        """The print of that name; None where the recordings cannot show it."""
        return next((each for each in self.prints if each.name == name), None)

    def with_print(self, other: Print) -> Fingerprint:
        """With another print in place of the one of its name."""
        return replace(self, prints=tuple(other if each.name == other.name else each for each in self.prints))

    def to_json(self) -> dict[str, Any]:
        """Plain numbers and texts, as ``json.dumps(..., allow_nan=False)`` takes them."""
        return {
            "kinds": list(self.kinds),
            "prints": [each.to_json() for each in self.prints],
            "starts": [plain({"seconds": each.seconds, "told": each.told, "word": each.word}) for each in self.starts],
        }


def fingerprint(experiment: Experiment) -> Fingerprint:
    """Everything that the recordings of an experiment show before any model is asked."""
    starts = tuple(start_stretch(run) for run in experiment.runs)
    if len(experiment.directions) > 1:
        straight = lines(experiment)
        driven = [take(straight.driven) for take in _ON_LINES if straight.driven.runs]
        swinging = [decay(straight.swinging), sides(straight)] if straight.swinging.runs else []
        return Fingerprint(tuple(made for made in (*driven, *swinging) if made is not None), starts, (straight.note,))
    return Fingerprint(tuple(made for take in _PRINTS if (made := take(experiment)) is not None), starts)

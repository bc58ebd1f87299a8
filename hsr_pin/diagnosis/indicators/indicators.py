"""All model-free indicators of an experiment.

For an arm in space they use the trials that stay on one line (:mod:`~hsr_pin.diagnosis.indicators.lines`), together with the
dependence of its oscillations on the direction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from hsr_pin.diagnosis.indicators.creep import creep
from hsr_pin.diagnosis.indicators.decay import decay
from hsr_pin.diagnosis.indicators.indicator import Indicator, jsonable
from hsr_pin.diagnosis.indicators.length import length
from hsr_pin.diagnosis.indicators.lines import lines
from hsr_pin.diagnosis.indicators.loops import loops
from hsr_pin.diagnosis.indicators.out_of_plane import out_of_plane
from hsr_pin.diagnosis.indicators.rests import rests
from hsr_pin.diagnosis.indicators.sides import sides
from hsr_pin.diagnosis.indicators.start import Stretch, start_stretch
from hsr_pin.diagnosis.indicators.timing import timing
from hsr_pin.effects.effect import KINDS
from hsr_pin.identification.experiment import Experiment

#: Indicators of a planar arm, in the order of a report.
_IN_PLANE = (timing, loops, decay, creep, rests, out_of_plane, length)
#: Indicators of an arm in space that use commands on a line.
_ON_LINES = (timing, loops, creep)


@dataclass(frozen=True, eq=False)
class Indicators:
    """Model-free indicators of some recordings.

    Attributes:
        items: the indicators that the recordings permit, in the order of a report.
        starts: for every run in order, how long a disturbance acts at its start.
        notes: which recordings were used, if not all of them.
    """

    items: tuple[Indicator, ...]
    starts: tuple[Stretch, ...]
    notes: tuple[str, ...] = ()

    @property
    def kinds(self) -> tuple[str, ...]:
        """Kinds of physics that any indicator points to, in the order of the list of kinds."""
        found = {kind for each in self.items for kind in each.kinds}
        return tuple(kind for kind in KINDS if kind in found)

    def named(self, name: str) -> Indicator | None:
        """Return the indicator of a name; None if the recordings do not permit it."""
        return next((each for each in self.items if each.name == name), None)

    def with_indicator(self, other: Indicator) -> Indicators:
        """Return the indicators with one of them replaced by another one of the same name."""
        return replace(self, items=tuple(other if each.name == other.name else each for each in self.items))

    def to_json(self) -> dict[str, Any]:
        """Return plain numbers and texts for ``json.dumps(..., allow_nan=False)``."""
        return {
            "kinds": list(self.kinds),
            "prints": [each.to_json() for each in self.items],
            "starts": [jsonable({"seconds": each.seconds, "told": each.known, "word": each.message}) for each in self.starts],
        }


def indicators(experiment: Experiment) -> Indicators:
    """Return all model-free indicators of an experiment."""
    starts = tuple(start_stretch(run) for run in experiment.runs)
    if len(experiment.directions) > 1:
        straight = lines(experiment)
        driven = [take(straight.driven) for take in _ON_LINES if straight.driven.runs]
        swinging = [decay(straight.swinging), sides(straight)] if straight.swinging.runs else []
        return Indicators(tuple(made for made in (*driven, *swinging) if made is not None), starts, (straight.note,))
    return Indicators(tuple(made for take in _IN_PLANE if (made := take(experiment)) is not None), starts)

"""Maps of the gap: by channel, by time, by trial, and by every label of the trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.explain.recordings import Recordings
from hsr_pin.trajectory import Array

#: Number of parts into which the time of a trial is divided.
_QUARTERS = 4


@dataclass(frozen=True)
class Part:
    """One part of a map.

    Attributes:
        label: name of the part.
        rms: RMS gap in this part [floors].
        share: share of the whole squared gap.
    """

    label: str
    rms: float
    share: float


@dataclass(frozen=True)
class Map:
    """The gap resolved by one quantity.

    Attributes:
        quantity: "channel", "time", "trial", or the name of a label.
        parts: the parts in order.
    """

    quantity: str
    parts: tuple[Part, ...]

    @property
    def largest(self) -> Part:
        """The part with the largest share."""
        return max(self.parts, key=lambda part: part.share)


def locate(recordings: Recordings, heldout: Sequence[Array]) -> tuple[Map, ...]:
    """Return maps of the residuals of a model, (T, M, 1) for each run, in floors."""
    squares = [np.nan_to_num(each[..., 0]) ** 2 for each in heldout]
    seen = [np.isfinite(each[..., 0]) for each in heldout]
    whole = sum(float(each.sum()) for each in squares) or 1.0

    def part(label: str, some: Sequence[tuple[Array, Array]]) -> Part:
        total, count = (sum(float(each[k].sum()) for each in some) for k in (0, 1))
        return Part(label, float(np.sqrt(total / max(count, 1.0))), total / whole)

    pairs = list(zip(squares, seen, strict=True))
    channels = [part(name, [(s[:, m], k[:, m]) for s, k in pairs]) for m, name in enumerate(recordings.channels)]
    cuts = [list(zip(np.array_split(s, _QUARTERS), np.array_split(k, _QUARTERS), strict=True)) for s, k in pairs]
    times = [part(f"quarter {n + 1}", [cut[n] for cut in cuts]) for n in range(_QUARTERS)]
    trials = [part(run.name, [pair]) for run, pair in zip(recordings.runs, pairs, strict=True)]
    maps = [Map("channel", tuple(channels)), Map("time", tuple(times)), Map("trial", tuple(trials))]
    for name in dict.fromkeys(label for run in recordings.runs for label in run.trial.labels):
        groups: dict[str, list[tuple[Array, Array]]] = {}
        for run, pair in zip(recordings.runs, pairs, strict=True):
            groups.setdefault(str(run.trial.labels.get(name, "none")), []).append(pair)
        maps.append(Map(name, tuple(part(label, own) for label, own in groups.items())))
    return tuple(maps)


def sentence(maps: Sequence[Map]) -> str:
    """Return one sentence that says where most of the gap lies."""
    said = [
        f"{each.largest.label} ({100 * each.largest.share:.0f} %)"
        for each in maps
        if len(each.parts) > 1 and each.quantity != "trial" and each.largest.share > 1.5 / len(each.parts)
    ]
    return f"Most of the squared gap lies in {' and in '.join(said)}." if said else "The gap is distributed evenly."

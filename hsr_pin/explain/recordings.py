"""Trials beside a model of your own, as fits and the search over causes ask for them.

What is measured is divided by its floor: what noise, and the truest of models, leave of a channel. So channels of any unit count
alike, and a distance of 1 is one floor.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError
from hsr_pin.explain.model import Cause, Model, Trial
from hsr_pin.inference.problem import ALWAYS, Prediction
from hsr_pin.parameters import Parameter
from hsr_pin.recordings.noise import white_noise
from hsr_pin.trajectory import Array

#: Difference for derivatives, over a parameter's scale, and over a number's standard deviation.
_FRACTION, _OWN = 0.02, 0.5
#: What a simulation that failed counts as, over what was measured moves, or should.
_FAILED = 3.0
#: A prediction larger than this many times that is a failure too.
_LOST = 100.0
#: Numbers of predictions that are kept: 80 MB.
_KEPT = 10_000_000
#: Factors on the amplitudes of an initial estimate at which it is tried too.
_SIZES = (1.0, 0.5, 2.0, 6.0)


@dataclass(frozen=True)
class Missing:
    """A cause with all of its parameters open, or some of them.

    Attributes:
        cause: what may be missing.
        opens: names of the parameters that are open.
    """

    cause: Cause
    opens: tuple[str, ...]

    @classmethod
    def variants(cls, cause: Cause) -> list[Missing]:
        """All open, and each group that may be open alone."""
        every = tuple(fact.name for fact in cause.parameters)
        return [cls(cause, opens) for opens in dict.fromkeys((every, *cause.apart))]

    @property
    def name(self) -> str:
        """Of the cause."""
        return self.cause.name

    @property
    def kind(self) -> str:
        """Of physics."""
        return self.cause.kind

    @property
    def flexible(self) -> bool:
        """Whether it stands for its kind only."""
        return self.cause.flexible

    @property
    def reading(self) -> tuple[object, ...]:
        """What tells this variant from others."""
        return self.cause.name, self.opens

    @property
    def plain(self) -> Missing:
        """Itself: each variant is probed."""
        return self

    @property
    def special_cases(self) -> tuple[str, ...]:
        """Names of simpler causes that this one contains."""
        return self.cause.contains

    def contains(self, other: Missing) -> bool:
        """Whether the other is a special case."""
        if self.name == other.name:
            return set(other.opens) < set(self.opens)
        return other.name in self.cause.contains or (self.flexible and not other.flexible and self.kind == other.kind)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those that are open, named as in the values."""
        return tuple(replace(f, name=f"{self.name}.{f.name}") for f in self.cause.parameters if f.name in self.opens)


@dataclass(frozen=True, eq=False)
class Variant:
    """The model with some causes, and what is open in it.

    Attributes:
        model: your own.
        parts: the causes.
    """

    model: Model
    parts: tuple[Missing, ...] = ()

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The model's own, then those of each cause."""
        return (*self.model.parameters, *(fact for part in self.parts for fact in part.parameters))

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the open parameters."""
        return tuple(fact.name for fact in self.parameters)

    @property
    def start(self) -> Array:
        """(P,) values to start from."""
        return np.array([fact.neutral for fact in self.parameters])

    @property
    def key(self) -> tuple[object, ...]:
        """What tells it from other variants."""
        return tuple(sorted((part.reading for part in self.parts), key=repr))

    @property
    def labour(self) -> tuple[()]:
        """Nothing is known of what a function costs."""
        return ()

    @property
    def rough(self) -> Variant:
        """The same: a function is what it is."""
        return self

    def with_part(self, part: Missing) -> Variant:
        """With one cause more."""
        return replace(self, parts=(*self.parts, part))

    def without_part(self, name: str) -> tuple[Variant, list[int]]:
        """With one cause less, and which of the open parameters are left."""
        kept = [k for k, free in enumerate(self.free) if not free.startswith(f"{name}.")]
        return replace(self, parts=tuple(part for part in self.parts if part.name != name)), kept

    def tried_from(self, starts: Sequence[Array]) -> list[tuple[int, Array]]:
        """The proposed values, these with other sizes of the last cause, and with the declared numbers of the model."""
        last, own = len(self.parts[-1].parameters), len(self.model.parameters)
        found = [(k, self._sized(start, last, size)) for k, start in enumerate(starts) for size in _SIZES]
        declared = [(ALWAYS, np.concatenate([self.start[:own], values[own:]])) for _, values in found[: len(_SIZES)]]
        return found + (declared if own else [])

    def _sized(self, values: Array, last: int, size: float) -> Array:
        """Values (P,) with the amplitudes of the last cause times a factor."""
        facts, moved = self.parameters[-last:], values.copy()
        for k, fact in enumerate(facts, len(values) - last):
            away = size if fact.amplitude else 1.0
            moved[k] = np.clip(fact.neutral + away * (values[k] - fact.neutral), fact.lower, fact.upper)
        return moved

    def named(self, values: Array) -> dict[str, float]:
        """All values by name; those that are not open are neutral."""
        return self.model.neutral | dict(zip(self.free, map(float, values), strict=True))


@dataclass(frozen=True, eq=False)
class Recording:
    """A trial as the model must reproduce it.

    Attributes:
        trial: where it comes from.
        scaled: (N, M, 1) measured over the floors; NaN in gaps.
        every: one in so many samples is looked at.
    """

    trial: Trial
    scaled: Array
    every: int = 1

    @property
    def name(self) -> str:
        """Of the trial."""
        return self.trial.name

    @property
    def time(self) -> Array:
        """(N,) [s]."""
        return np.asarray(self.trial.time)

    @property
    def compared(self) -> Array:
        """(T, M, 1) what was measured, of the samples that are looked at."""
        return self.scaled[:: self.every]

    @cached_property
    def moved(self) -> float:
        """Root mean square about the mean, of the channel that goes farthest."""
        return float(np.nanmax(np.nanstd(self.scaled, axis=0), initial=0.0))


class _Known(OrderedDict[object, Array]):
    """Predictions that were made, the latest of them."""

    size = 0

    def keep(self, new: Mapping[object, Array]) -> None:
        """Add some, and forget the oldest."""
        self.update(new)
        self.size += sum(each.size for each in new.values())
        while self.size > _KEPT:
            self.size -= self.popitem(last=False)[1].size


class Recordings:
    """Trials, and the model that is to reproduce them.

    Args:
        model: your own.
        trials: at least one.

    Raises:
        InputError: no trials, two of one name, or trials of other channels than the first.
    """

    lasting = 0

    def __init__(self, model: Model, trials: Sequence[Trial]) -> None:
        names = [trial.name for trial in trials]
        if not names or len(set(names)) < len(names):
            twice = next((name for name in names if names.count(name) > 1), "none")
            raise InputError("trials", expected="at least one, each with a name of its own", received=twice)
        self.model, self.channels = model, tuple(trials[0].measured)
        for trial in trials:
            if tuple(trial.measured) != self.channels:
                expected, received = ", ".join(self.channels), ", ".join(trial.measured)
                raise InputError(f"channels of {trial.name}", expected=f"{expected}, as in {names[0]}", received=received)
        self.units = np.array([self._floor(channel, trials) for channel in self.channels])
        rms = np.array([self._noise(channel, trials) for channel in self.channels])
        self.noise, self.floor = rms / self.units, np.ones(len(self.units))
        self.runs = tuple(Recording(trial, _stacked(trial.measured, self.channels) / self.units[:, None]) for trial in trials)
        self.worst = _FAILED * max(1 / self.model.truest, *(run.moved for run in self.runs))
        self._known = _Known()

    def _noise(self, channel: str, trials: Sequence[Trial]) -> float:
        if channel in self.model.noise:
            return self.model.noise[channel]
        found = [white_noise(np.asarray(trial.measured[channel])) for trial in trials]
        return float(np.nanmedian(found)) if np.isfinite(found).any() else 0.0

    def _floor(self, channel: str, trials: Sequence[Trial]) -> float:
        """What noise and the truest of models leave of a channel, in its unit."""
        spread = float(np.nanstd(np.concatenate([np.asarray(trial.measured[channel]) for trial in trials])))
        least = self.model.least.get(channel, self.model.truest * spread)
        return math.hypot(self._noise(channel, trials), least) or 1.0

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_known": _Known()}

    @property
    def seen(self) -> int:
        """How many numbers of its own a run has at most."""
        return max((self.own(run) for run in self.runs), default=0)

    @property
    def doubted(self) -> NDArray[np.bool_]:
        """(K,) none: how a trial started is seen in it."""
        return np.zeros(self.seen, dtype=bool)

    def own(self, run: Recording) -> int:
        """How many numbers belong to a run."""
        return len(run.trial.own)

    def shown(self, run: Recording) -> bool:
        """Never: all numbers of a trial are declared."""
        return False

    def of_runs(self, runs: Sequence[Recording]) -> Recordings:
        """These runs alone; what is known of them is shared."""
        other: Recordings = object.__new__(type(self))
        other.__dict__ |= self.__dict__ | {"runs": tuple(runs)}
        return other

    def some(self, kept: Sequence[int], samples: int) -> Recordings:
        """These runs alone, with hardly more than so many samples of each."""
        runs = (self.runs[k] for k in kept)
        return self.of_runs([replace(run, every=max(1, len(run.time) // samples)) for run in runs])

    def predict(self, hypothesis: Variant, cases: Sequence[tuple[Recording, Array]]) -> list[Prediction]:
        """For each run with its own values (P,)."""
        answers = self._outputs([(run, hypothesis.named(values)) for run, values in cases])
        return [Prediction(answer) for answer in answers]

    def predict_with_slopes(
        self,
        hypothesis: Variant,
        values: Array,
        *,
        central: bool = False,
        shown: Sequence[bool] | None = None,
        own: bool = True,
    ) -> list[Prediction]:
        """For every run at values (P,), with derivatives and what belongs to the trials."""
        sides = _steps(hypothesis.parameters, values, central)
        here = hypothesis.named(values)
        points = [hypothesis.named(values + side) for side in sides]
        cases = []
        for run in self.runs:
            cases += [(run, here), *((run, point) for point in points)]
            cases += [(run, here | {name: _OWN * size}) for name, size in run.trial.own.items() if own]
        answers, predictions = iter(self._outputs(cases)), []
        for run in self.runs:
            centre, ahead = next(answers), [next(answers) for _ in sides]
            slopes = _slopes(centre, ahead, sides, len(values))
            for name, known in self._known_slopes(here, run, hypothesis.free).items():
                slopes[..., hypothesis.free.index(name)] = known
            nuisance = np.zeros((*centre.shape, len(run.trial.own)))
            for k in range(len(run.trial.own) if own else 0):
                nuisance[..., k] = (next(answers) - centre) / _OWN
            predictions.append(Prediction(centre, np.nan_to_num(slopes), np.nan_to_num(nuisance) if own else None))
        return predictions

    def probe(self, hypothesis: Variant, points: Array) -> list[Array]:
        """For each run (T, C, M, 1) what is predicted at each of the points (C, P)."""
        named = [hypothesis.named(point) for point in points]
        answers = iter(self._outputs([(run, values) for run in self.runs for values in named]))
        return [np.stack([next(answers) for _ in named], axis=1) for _ in self.runs]

    def as_read(self, hypothesis: Variant, new: Sequence[Parameter], run: Recording, changes: Array) -> Array:
        """The changes as they are: each variant is probed."""
        return changes

    def _known_slopes(self, values: Mapping[str, float], run: Recording, free: Sequence[str]) -> dict[str, Array]:
        """(T, M, 1) derivatives that the model knows, by the names of those of its open parameters."""
        if self.model.slopes is None:
            return {}
        found = self.model.slopes(values, run.trial)
        names = [name for name in free if all(name in found.get(channel, {}) for channel in self.channels)]
        shown = {name: {channel: found[channel][name] for channel in self.channels} for name in names}
        return {name: self._scaled(each)[:: run.every] for name, each in shown.items()}

    def _outputs(self, cases: Sequence[tuple[Recording, Mapping[str, float]]]) -> list[Array]:
        """(T, M, 1) what is predicted over the floors; none is asked for twice."""
        keys = [(run.name, tuple(values.items())) for run, values in cases]
        new = {key: case for key, case in zip(keys, cases, strict=True) if key not in self._known}
        found = self.model.outputs([(values, run.trial) for run, values in new.values()])
        here: dict[object, Array] = dict(zip(new, map(self._scaled, found), strict=True))
        answers = [here[key] if key in here else self._known[key] for key in keys]
        self._known.keep(here)
        return [answer[:: run.every] for answer, (run, _) in zip(answers, cases, strict=True)]

    def _scaled(self, outputs: Mapping[str, Any]) -> Array:
        """(N, M, 1) over the floors; NaN for what is far from anything that was measured."""
        scaled = _stacked(outputs, self.channels) / self.units[:, None]
        return np.where(np.abs(scaled) < _LOST * self.worst, scaled, np.nan)


def _stacked(outputs: Mapping[str, Any], channels: Sequence[str]) -> Array:
    """(N, M, 1) of the channels."""
    return np.stack([np.asarray(outputs[channel], dtype=float) for channel in channels], axis=1)[..., None]


def _steps(facts: Sequence[Parameter], values: Array, central: bool) -> list[Array]:
    """(P,) each: the differences for derivatives; one for each parameter, or two."""
    steps = []
    for k, (fact, value) in enumerate(zip(facts, values, strict=True)):
        width = _FRACTION * (min(fact.scale, value) if fact.ratio_width is not None else fact.scale)
        ahead = width if value + width <= fact.upper else -width
        back = -ahead if fact.lower <= value - ahead <= fact.upper else 2 * ahead
        steps += [side * np.eye(len(values))[k] for side in ((ahead, back) if central else (ahead,))]
    return steps


def _slopes(centre: Array, ahead: Sequence[Array], sides: Sequence[Array], count: int) -> Array:
    """(T, M, 1, P) derivatives from what is predicted a step aside, or two."""
    slopes, per = np.zeros((*centre.shape, count)), len(sides) // max(count, 1)
    for k in range(count):
        steps = [float(side[k]) for side in sides[per * k : per * k + per]]
        chords = [(each - centre) / step for each, step in zip(ahead[per * k : per * k + per], steps, strict=True)]
        slopes[..., k] = chords[0] if per == 1 else (steps[0] * chords[1] - steps[1] * chords[0]) / (steps[0] - steps[1])
    return slopes

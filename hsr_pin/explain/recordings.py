"""Trials together with a user-defined model, in the form that fits and the search over causes need.

Measured values are divided by the floor of their channel, which combines its noise with the accuracy of the best possible model.
Channels of different units thus have equal weights, and a distance of 1 is one floor.
"""

from __future__ import annotations

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

#: Finite-difference steps: in scales of a parameter, and in prior standard deviations of a trial parameter.
_FRACTION, _OWN = 0.02, 0.5
#: Residual of a failed simulation, as a multiple of the typical motion.
_FAILED = 3.0
#: A prediction above this multiple of that residual counts as a failure too.
_LOST = 100.0
#: Capacity of the cache of predictions, in numbers (80 MB).
_KEPT = 10_000_000
#: Factors on the amplitudes of an initial estimate that are tried as start points.
_SIZES = (1.0, 0.5, 2.0, 6.0)


@dataclass(frozen=True)
class CauseVariant:
    """A cause with all of its parameters free, or with some of them.

    Attributes:
        cause: the cause that may be missing.
        opens: names of the free parameters.
    """

    cause: Cause
    opens: tuple[str, ...]

    @classmethod
    def variants(cls, cause: Cause) -> list[CauseVariant]:
        """Return the variant with all parameters free, and one for each group that may be free alone."""
        every = tuple(fact.name for fact in cause.parameters)
        return [cls(cause, opens) for opens in dict.fromkeys((every, *cause.apart))]

    @property
    def name(self) -> str:
        """Name of the cause."""
        return self.cause.name

    @property
    def kind(self) -> str:
        """Kind of physics."""
        return self.cause.kind

    @property
    def flexible(self) -> bool:
        """Whether the cause only stands for its kind of physics."""
        return self.cause.flexible

    @property
    def variant(self) -> tuple[object, ...]:
        """Key that distinguishes this variant from others."""
        return self.cause.name, self.opens

    @property
    def base_variant(self) -> CauseVariant:
        """The variant itself, because each variant has probe simulations of its own."""
        return self

    @property
    def special_cases(self) -> tuple[str, ...]:
        """Names of simpler causes that this cause contains."""
        return self.cause.contains

    def contains(self, other: CauseVariant) -> bool:
        """Return whether another variant is a special case of this one."""
        if self.name == other.name:
            return set(other.opens) < set(self.opens)
        return other.name in self.cause.contains or (self.flexible and not other.flexible and self.kind == other.kind)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The free parameters, with their names in the values of the model."""
        return tuple(replace(f, name=f"{self.name}.{f.name}") for f in self.cause.parameters if f.name in self.opens)


@dataclass(frozen=True, eq=False)
class ExtendedModel:
    """The user's model with some of its causes, as a hypothesis with free parameters.

    Attributes:
        model: the user's model.
        parts: the added causes.
    """

    model: Model
    parts: tuple[CauseVariant, ...] = ()

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The model's own free parameters, then those of each cause."""
        return (*self.model.parameters, *(fact for part in self.parts for fact in part.parameters))

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the free parameters."""
        return tuple(fact.name for fact in self.parameters)

    @property
    def start(self) -> Array:
        """Initial values (P,) of the free parameters."""
        return np.array([fact.neutral for fact in self.parameters])

    @property
    def key(self) -> tuple[object, ...]:
        """Key that distinguishes this model from others."""
        return tuple(sorted((part.variant for part in self.parts), key=repr))

    @property
    def cost(self) -> tuple[()]:
        """Empty, because the cost of a user's function is unknown."""
        return ()

    @property
    def rough(self) -> ExtendedModel:
        """The model itself, because a user's function has no coarser simulation."""
        return self

    def with_part(self, part: CauseVariant) -> ExtendedModel:
        """Return the model with one more cause."""
        return replace(self, parts=(*self.parts, part))

    def without_part(self, name: str) -> tuple[ExtendedModel, list[int]]:
        """Return the model without one cause, and the indices of the free parameters that remain."""
        kept = [k for k, free in enumerate(self.free) if not free.startswith(f"{name}.")]
        return replace(self, parts=tuple(part for part in self.parts if part.name != name)), kept

    def start_points(self, starts: Sequence[Array]) -> list[tuple[int, Array]]:
        """Return the proposed points, variations with other amplitudes of the last cause, and points with the declared values."""
        last, own = len(self.parts[-1].parameters), len(self.model.parameters)
        found = [(k, self._sized(start, last, size)) for k, start in enumerate(starts) for size in _SIZES]
        declared = [(ALWAYS, np.concatenate([self.start[:own], values[own:]])) for _, values in found[: len(_SIZES)]]
        return found + (declared if own else [])

    def _sized(self, values: Array, last: int, size: float) -> Array:
        """Return the values (P,) with the amplitudes of the last cause multiplied by a factor."""
        facts, moved = self.parameters[-last:], values.copy()
        for k, fact in enumerate(facts, len(values) - last):
            away = size if fact.amplitude else 1.0
            moved[k] = np.clip(fact.neutral + away * (values[k] - fact.neutral), fact.lower, fact.upper)
        return moved

    def named(self, values: Array) -> dict[str, float]:
        """Return all parameter values by name; parameters that are not free are neutral."""
        return self.model.neutral | dict(zip(self.free, map(float, values), strict=True))


@dataclass(frozen=True, eq=False)
class Recording:
    """A trial in scaled form.

    Attributes:
        trial: the recorded trial.
        scaled: (N, M, 1) measured values in floors; NaN in gaps.
        every: sampling ratio: one in this many samples is used.
    """

    trial: Trial
    scaled: Array
    every: int = 1

    @property
    def name(self) -> str:
        """Name of the trial."""
        return self.trial.name

    @property
    def time(self) -> Array:
        """Sampling times (N,) [s]."""
        return np.asarray(self.trial.time)

    @property
    def compared(self) -> Array:
        """Measured values (T, M, 1) of the samples that are used, in floors."""
        return self.scaled[:: self.every]

    @cached_property
    def moved(self) -> float:
        """Largest standard deviation of any channel, in floors."""
        return float(np.nanmax(np.nanstd(self.scaled, axis=0), initial=0.0))


class _Known(OrderedDict[object, Array]):
    """Cache of the latest predictions."""

    size = 0

    def keep(self, new: Mapping[object, Array]) -> None:
        """Add predictions, and remove the oldest ones beyond the size limit."""
        self.update(new)
        self.size += sum(each.size for each in new.values())
        while self.size > _KEPT:
            self.size -= self.popitem(last=False)[1].size


class Recordings:
    """Trials together with the model that predicts them.

    Args:
        model: the user's model.
        trials: at least one trial.

    Raises:
        InputError: there are no trials, two trials have the same name, or a trial has other channels than the first one.
    """

    systematic = 0

    def __init__(self, model: Model, trials: Sequence[Trial]) -> None:
        names = [trial.name for trial in trials]
        if not names or len(set(names)) < len(names):
            twice = next((name for name in names if names.count(name) > 1), "none")
            raise InputError("trials", expected="at least one, each with a different name", received=twice)
        self.model, self.channels = model, tuple(trials[0].measured)
        for trial in trials:
            if tuple(trial.measured) != self.channels:
                expected, received = ", ".join(self.channels), ", ".join(trial.measured)
                raise InputError(f"channels of {trial.name}", expected=f"{expected}, as in {names[0]}", received=received)
        rms, least = (np.array([of(channel, trials) for channel in self.channels]) for of in (self._noise, self._inaccuracy))
        self.units = np.where((both := np.hypot(rms, least)) > 0, both, 1.0)
        self.noise, self.floor = rms / self.units, np.ones(len(self.units))
        self.groups = tuple((k,) for k in range(len(self.units)))
        self.discrepancy = least / self.units
        self.runs = tuple(Recording(trial, _stacked(trial.measured, self.channels) / self.units[:, None]) for trial in trials)
        self.worst = _FAILED * max(1 / self.model.truest, *(run.moved for run in self.runs))
        self._known, self._tolerances = _Known(), dict[str, Array]()

    def tolerances(self, run: Recording) -> Array:
        """Return the change of a run's prediction for one standard deviation of each error of a declared number, (T, M, 1, K)."""
        names = self.model.tolerances
        if not names:
            return np.zeros((*run.compared.shape, 0))
        if run.name not in self._tolerances:
            runs = [each for each in self.runs if each.name not in self._tolerances]
            values = [self.model.neutral, *(self.model.neutral | {name: 1.0} for name in names)]
            answers = iter(self.model.outputs([(point, each.trial) for each in runs for point in values]))
            for each in runs:
                centre, *changed = (self._scaled(next(answers)) for _ in values)
                columns = [np.nan_to_num(one - centre) for one in changed]
                self._tolerances[each.name] = np.stack(columns, axis=-1)
        return self._tolerances[run.name][:: run.every]

    def _noise(self, channel: str, trials: Sequence[Trial]) -> float:
        """Return the standard deviation of a channel's noise, in its unit."""
        if channel in self.model.noise:
            return self.model.noise[channel]
        found = [white_noise(np.asarray(trial.measured[channel])) for trial in trials]
        return float(np.nanmedian(found)) if np.isfinite(found).any() else 0.0

    def _inaccuracy(self, channel: str, trials: Sequence[Trial]) -> float:
        """Return the accuracy of the best possible model for a channel, in its unit."""
        spread = float(np.nanstd(np.concatenate([np.asarray(trial.measured[channel]) for trial in trials])))
        return self.model.least.get(channel, self.model.truest * spread)

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_known": _Known()}

    @property
    def unconditional(self) -> int:
        """Largest number of trial parameters of any run."""
        return max((self.own(run) for run in self.runs), default=0)

    @property
    def confounded(self) -> NDArray[np.bool_]:
        """All true (K,): a discrepancy of the model can look like an error of the initial state of a trial."""
        return np.ones(self.unconditional, dtype=bool)

    def own(self, run: Recording) -> int:
        """Return the number of trial parameters of a run."""
        return len(run.trial.own)

    def has_conditional(self, run: Recording) -> bool:
        """Return False: all trial parameters are declared."""
        return False

    def of_runs(self, runs: Sequence[Recording]) -> Recordings:
        """Return the recordings with some of the runs; caches are shared."""
        other: Recordings = object.__new__(type(self))
        other.__dict__ |= self.__dict__ | {"runs": tuple(runs)}
        return other

    def some(self, kept: Sequence[int], samples: int) -> Recordings:
        """Return the recordings with some of the runs, and with about ``samples`` samples of each."""
        runs = (self.runs[k] for k in kept)
        return self.of_runs([replace(run, every=max(1, len(run.time) // samples)) for run in runs])

    def predict(self, hypothesis: ExtendedModel, cases: Sequence[tuple[Recording, Array]]) -> list[Prediction]:
        """Return the prediction for each pair of a run and parameter values (P,)."""
        answers = self._outputs([(run, hypothesis.named(values)) for run, values in cases])
        return [Prediction(answer) for answer in answers]

    def predict_with_slopes(
        self,
        hypothesis: ExtendedModel,
        values: Array,
        *,
        central: bool = False,
        conditional: Sequence[bool] | None = None,
        own: bool = True,
    ) -> list[Prediction]:
        """Return the prediction of every run at values (P,), with derivatives and the effect of trial parameters."""
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

    def probe(self, hypothesis: ExtendedModel, points: Array) -> list[Array]:
        """Return for each run the prediction (T, C, M, 1) at each of the points (C, P)."""
        named = [hypothesis.named(point) for point in points]
        answers = iter(self._outputs([(run, values) for run in self.runs for values in named]))
        return [np.stack([next(answers) for _ in named], axis=1) for _ in self.runs]

    def changes_of_variant(self, hypothesis: ExtendedModel, new: Sequence[Parameter], run: Recording, changes: Array) -> Array:
        """Return the changes unchanged, because each variant has probe simulations of its own."""
        return changes

    def _known_slopes(self, values: Mapping[str, float], run: Recording, free: Sequence[str]) -> dict[str, Array]:
        """Return the derivatives (T, M, 1) that the model provides, by the names of its free parameters."""
        if self.model.slopes is None:
            return {}
        found = self.model.slopes(values, run.trial)
        names = [name for name in free if all(name in found.get(channel, {}) for channel in self.channels)]
        shown = {name: {channel: found[channel][name] for channel in self.channels} for name in names}
        return {name: self._scaled(each)[:: run.every] for name, each in shown.items()}

    def _outputs(self, cases: Sequence[tuple[Recording, Mapping[str, float]]]) -> list[Array]:
        """Return the predictions (T, M, 1) in floors; nothing is simulated twice."""
        keys = [(run.name, tuple(values.items())) for run, values in cases]
        new = {key: case for key, case in zip(keys, cases, strict=True) if key not in self._known}
        found = self.model.outputs([(values, run.trial) for run, values in new.values()])
        here: dict[object, Array] = dict(zip(new, map(self._scaled, found), strict=True))
        answers = [here[key] if key in here else self._known[key] for key in keys]
        self._known.keep(here)
        return [answer[:: run.every] for answer, (run, _) in zip(answers, cases, strict=True)]

    def _scaled(self, outputs: Mapping[str, Any]) -> Array:
        """Return predictions (N, M, 1) in floors; NaN for values far from all measured ones."""
        scaled = _stacked(outputs, self.channels) / self.units[:, None]
        return np.where(np.abs(scaled) < _LOST * self.worst, scaled, np.nan)


def _stacked(outputs: Mapping[str, Any], channels: Sequence[str]) -> Array:
    """Return the channels as one array (N, M, 1)."""
    return np.stack([np.asarray(outputs[channel], dtype=float) for channel in channels], axis=1)[..., None]


def _steps(facts: Sequence[Parameter], values: Array, central: bool) -> list[Array]:
    """Return the finite-difference steps (P,): one for each parameter, or two."""
    steps = []
    for k, (fact, value) in enumerate(zip(facts, values, strict=True)):
        width = _FRACTION * (min(fact.scale, value) if fact.ratio_width is not None else fact.scale)
        ahead = width if value + width <= fact.upper else -width
        back = -ahead if fact.lower <= value - ahead <= fact.upper else 2 * ahead
        steps += [side * np.eye(len(values))[k] for side in ((ahead, back) if central else (ahead,))]
    return steps


def _slopes(centre: Array, ahead: Sequence[Array], sides: Sequence[Array], count: int) -> Array:
    """Return the derivatives (T, M, 1, P) from predictions at one or two steps for each parameter."""
    slopes, per = np.zeros((*centre.shape, count)), len(sides) // max(count, 1)
    for k in range(count):
        steps = [float(side[k]) for side in sides[per * k : per * k + per]]
        chords = [(each - centre) / step for each, step in zip(ahead[per * k : per * k + per], steps, strict=True)]
        slopes[..., k] = chords[0] if per == 1 else (steps[0] * chords[1] - steps[1] * chords[0]) / (steps[0] - steps[1])
    return slopes

"""By how much two sessions differ, as a model of its own: its causes are changes of the numbers of another model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.explain.model import Cause, Model, Trial
from hsr_pin.explain.recordings import Recordings
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: What the cause is called that a number of the model differs, and the kind of it.
_CHANGED, _KIND = "_changed", "parameter"


@dataclass(frozen=True, eq=False)
class Change:
    """Predicts by how much trials of a later session differ from those of an earlier one.

    Attributes:
        model: of both sessions.
        known: values of all its parameters in the earlier one.
        early: that one, which tells what noise and the truest of models leave of a difference.
    """

    model: Model
    known: Mapping[str, float]
    early: Recordings

    @property
    def as_model(self) -> Model:
        """It as a model: the inputs of each of its trials are the later and the earlier trial."""
        return replace(
            self.model,
            predict=self.predict,
            predict_many=self.predict_many,
            slopes=None,
            parameters=(),
            causes=(*map(self._of_number, self.model.parameters), *self.model.causes),
            noise=self._of_two(self.early.noise),
            least=self._of_two(np.sqrt(np.maximum(1 - self.early.noise**2, 0.0))),
            name=f"{self.model.name}, the later session beside the earlier",
        )

    def _of_two(self, floors: Array) -> dict[str, float]:
        """In the unit of each channel, for the difference of two recordings."""
        both = 2**0.5 * floors * self.early.units
        return {channel: float(each) for channel, each in zip(self.early.channels, both, strict=True)}

    def predict(self, values: Mapping[str, float], trial: Trial) -> Mapping[str, Array]:
        """The difference that some changes make in one pair of trials."""
        return self.predict_many([(values, trial)])[0]

    def predict_many(self, cases: Sequence[tuple[Mapping[str, float], Trial]]) -> list[Mapping[str, Array]]:
        """Likewise for many at once."""
        own = [{name: values.get(name, 0.0) for name in trial.own} for values, trial in cases]
        later = [(self.changed(values) | more, trial.inputs[0]) for (values, trial), more in zip(cases, own, strict=True)]
        earlier = [(self.known, trial.inputs[1]) for _, trial in cases]
        answers = self.model.outputs([*later, *earlier])
        halves = zip(answers[: len(cases)], answers[len(cases) :], strict=True)
        return [{channel: one[channel] - other[channel] for channel in one} for one, other in halves]

    def changed(self, values: Mapping[str, float]) -> dict[str, float]:
        """The model's values in the later session: sizes of causes are added, and the shapes of those that are there stay."""
        new = dict(self.known)
        for fact in self.model.parameters:
            change = values.get(f"{fact.name}{_CHANGED}.{fact.name}", _neutral(fact))
            new[fact.name] = new[fact.name] * change if fact.ratio_width is not None else new[fact.name] + change
        for cause in self.model.causes:
            names = [(f"{cause.name}.{fact.name}", fact) for fact in cause.parameters]
            there = any(self.known[name] != fact.neutral for name, fact in names if fact.amplitude)
            for name, fact in names:
                if fact.amplitude:
                    changed = new[name] + values.get(name, fact.neutral) - fact.neutral
                    new[name] = min(max(changed, fact.lower), fact.upper)
                elif not there:
                    new[name] = values.get(name, fact.neutral)
        return new

    def _of_number(self, fact: Parameter) -> Cause:
        """That a number of the model differs, as a cause: by a factor, or by so much."""
        changed = (
            fact
            if fact.ratio_width is not None
            else replace(fact, neutral=0.0, amplitude=True, lower=-_span(fact), upper=_span(fact))
        )
        return Cause(f"{fact.name}{_CHANGED}", _KIND, (changed,), f"another {fact.name.replace('_', ' ')}")


def _neutral(fact: Parameter) -> float:
    return 1.0 if fact.ratio_width is not None else 0.0


def _span(fact: Parameter) -> float:
    return fact.upper - fact.lower

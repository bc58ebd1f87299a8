"""The difference between two sessions as a model, whose causes are changes of the parameters of another model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.explain.model import Cause, Model, Trial
from hsr_pin.explain.recordings import Recordings
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Suffix of the name of a cause that is a changed parameter, and its kind.
_CHANGED, _KIND = "_changed", "parameter"


@dataclass(frozen=True, eq=False)
class Change:
    """Model of the difference between the trials of a later session and those of an earlier one.

    Attributes:
        model: the model of both sessions.
        known: values of all its parameters in the earlier session.
        early: recordings of the earlier session, which determine the floors of the difference.
    """

    model: Model
    known: Mapping[str, float]
    early: Recordings

    @property
    def as_model(self) -> Model:
        """The difference as a :class:`Model`; the inputs of each of its trials are the later and the earlier trial."""
        return replace(
            self.model,
            predict=self.predict,
            predict_many=self.predict_many,
            slopes=None,
            tolerances=(),
            parameters=(),
            causes=(*map(self._of_number, self.model.parameters), *self.model.causes),
            noise=self._of_two(self.early.noise),
            least=self._of_two(np.sqrt(np.maximum(1 - self.early.noise**2, 0.0))),
            name=f"{self.model.name}, later session compared with the earlier one",
        )

    def _of_two(self, floors: Array) -> dict[str, float]:
        """Return the floor of the difference of two recordings for each channel, in its unit."""
        both = 2**0.5 * floors * self.early.units
        return {channel: float(each) for channel, each in zip(self.early.channels, both, strict=True)}

    def predict(self, values: Mapping[str, float], trial: Trial) -> Mapping[str, Array]:
        """Return the predicted difference of one pair of trials for the given changes."""
        return self.predict_many([(values, trial)])[0]

    def predict_many(self, cases: Sequence[tuple[Mapping[str, float], Trial]]) -> list[Mapping[str, Array]]:
        """Return the predicted differences of many pairs of trials."""
        own = [{name: values.get(name, 0.0) for name in trial.own} for values, trial in cases]
        later = [(self.changed(values) | more, trial.inputs[0]) for (values, trial), more in zip(cases, own, strict=True)]
        earlier = [(self.known, trial.inputs[1]) for _, trial in cases]
        answers = self.model.outputs([*later, *earlier])
        halves = zip(answers[: len(cases)], answers[len(cases) :], strict=True)
        return [{channel: one[channel] - other[channel] for channel in one} for one, other in halves]

    def changed(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the parameter values of the later session: amplitudes are added, and shapes of present causes stay unchanged."""
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
        """Return the change of a parameter as a cause: by a factor or by an amount."""
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

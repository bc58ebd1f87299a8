"""A model of your own: a function, the numbers that are open in it, and the causes that it may lack."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.errors import InputError, quoted
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: Bounds of a factor on a declared number, unless others are given.
_FACTOR = (0.1, 10.0)
#: Amplitudes are looked for within so many of their scales, unless bounds are given.
_REACH = 20.0
#: What is predicted: an array (N,) for each channel.
Outputs = Mapping[str, ArrayLike]


def factor(
    name: str, width: float = 0.3, *, lower: float = _FACTOR[0], upper: float = _FACTOR[1], description: str = ""
) -> Parameter:
    """A factor on a number that was declared; 1 leaves it as it is.

    Args:
        name: of the parameter.
        width: standard deviation of its logarithm beforehand: 0.3 for what was measured, 1 for what was guessed.
        lower: bound.
        upper: bound.
        description: one line.
    """
    return Parameter(name, "1", 1.0, lower, upper, 0.1, False, description, ratio_width=width)


def amplitude(
    name: str, scale: float, unit: str = "1", *, lower: float = -math.inf, upper: float = math.inf, description: str = ""
) -> Parameter:
    """The size of a cause; 0 switches it off.

    Args:
        name: of the parameter.
        scale: a change of practical size [unit]; sizes up to some five of them are expected.
        unit: of the value.
        lower: bound; default: twenty scales below 0. A size that cannot be negative has 0.
        upper: bound; default: twenty scales above 0.
        description: one line.
    """
    reach = _REACH * scale
    return Parameter(name, unit, 0.0, max(lower, -reach), min(upper, reach), scale, True, description)


def shape(
    name: str, start: float, lower: float, upper: float, unit: str = "1", *, scale: float = 0.0, description: str = ""
) -> Parameter:
    """A number that shapes a cause (a time constant, a threshold), and means nothing while the cause has no size.

    Args:
        name: of the parameter.
        start: where a fit begins.
        lower: bound.
        upper: bound.
        unit: of the value.
        scale: a change of practical size; default: a tenth of the way between the bounds.
        description: one line.
    """
    return Parameter(name, unit, start, lower, upper, scale or (upper - lower) / 10, False, description)


@dataclass(frozen=True)
class Cause:
    """Something that the model may lack.

    Attributes:
        name: as it is reported.
        kind: of physics, in a word; causes of one kind are told together where they cannot be told apart.
        parameters: its numbers. The model's function gets each as ``values["name.parameter"]``.
        description: one line.
        apart: groups of names of parameters that may be open alone, as where a joint has friction and others have none; the
            others then stay neutral. All of them open is always among the variants.
        contains: names of causes that are special cases of this one.
        flexible: whether it stands for its kind only, and is never named.
    """

    name: str
    kind: str
    parameters: tuple[Parameter, ...]
    description: str = ""
    apart: tuple[tuple[str, ...], ...] = ()
    contains: tuple[str, ...] = ()
    flexible: bool = False


@dataclass(frozen=True, eq=False)
class Trial:
    """One recording.

    Attributes:
        name: of the trial.
        time: (N,) [s], rising; anything that becomes an array.
        measured: for each channel (N,) what was measured; NaN in gaps.
        inputs: whatever the model's function needs to know of the trial; it must be possible to pickle it.
        labels: of the trial (a payload, an operator, a day), by which the gap is shown too.
        own: numbers that belong to this trial alone, with their standard deviation beforehand, as where it started; they are
            about 0, and the function gets each as ``values[name]``.
    """

    name: str
    time: Array
    measured: Mapping[str, Array]
    inputs: Any = None
    labels: Mapping[str, str | float] = field(default_factory=dict)
    own: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        time = np.asarray(self.time, dtype=float)
        if time.ndim != 1 or len(time) < 2 or not (np.isfinite(time).all() and (np.diff(time) > 0).all()):
            raise InputError(f"time of {self.name}", expected="at least two rising numbers", received=f"shape {time.shape}")
        if not self.measured:
            raise InputError(f"channels of {self.name}", expected="at least one", received="none")
        for channel, values in self.measured.items():
            if np.shape(values) != time.shape:
                expected, received = f"{len(time)} values, one for each time", f"shape {np.shape(values)}"
                raise InputError(f"channel {channel} of {self.name}", expected=expected, received=received)
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "measured", {name: np.asarray(each, dtype=float) for name, each in self.measured.items()})


@dataclass(frozen=True, eq=False)
class Model:
    """A model of your own.

    Attributes:
        predict: from values of all parameters and a trial to what is measured: ``predict(values, trial)`` gives an array (N,) for
            each channel. Where a simulation fails, it gives NaN. It must be importable by name to be used in several processes.
        parameters: the numbers that are fitted in any case; all causes absent.
        causes: what the model may lack. Their values are neutral, unless the cause is tried.
        name: of what is modelled.
        units: of the channels; default: none is shown.
        noise: standard deviation of each channel's noise; default: as the recordings show it.
        truest: no model is truer than this share of what a channel moves: what is seen with less noise counts no more.
        least: the same for single channels, in their units.
        predict_many: the same for many at once, where that is quicker: from a list of pairs (values, trial) to a list of
            predictions.
        slopes: derivatives, where they are known: ``slopes(values, trial)`` gives for each channel and name of a parameter an
            array (N,). What is not among them is found by differences.
    """

    predict: Callable[[Mapping[str, float], Trial], Outputs]
    parameters: tuple[Parameter, ...] = ()
    causes: tuple[Cause, ...] = ()
    name: str = "model"
    units: Mapping[str, str] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    truest: float = 1e-3
    least: Mapping[str, float] = field(default_factory=dict)
    predict_many: Callable[[Sequence[tuple[Mapping[str, float], Trial]]], Sequence[Outputs]] | None = None
    slopes: Callable[[Mapping[str, float], Trial], Mapping[str, Mapping[str, ArrayLike]]] | None = None

    def __post_init__(self) -> None:
        names = [*(fact.name for fact in self.parameters), *(cause.name for cause in self.causes)]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise InputError("model", expected="parameters and causes with names of their own", received=f"{twice[0]} twice")
        if wrong := [name for name in names if "." in name]:
            raise InputError("model", expected="names without a dot", received=quoted(wrong[0]))
        if empty := [cause.name for cause in self.causes if not cause.parameters]:
            raise InputError(f"cause {empty[0]}", expected="at least one parameter", received="none")

    @property
    def neutral(self) -> dict[str, float]:
        """Values of all parameters that leave the model as it is."""
        own = ((fact.name, fact.neutral) for fact in self.parameters)
        others = ((f"{cause.name}.{fact.name}", fact.neutral) for cause in self.causes for fact in cause.parameters)
        return dict(chain(own, others))

    def cause(self, name: str) -> Cause:
        """The cause of that name.

        Raises:
            InputError: there is none.
        """
        for cause in self.causes:
            if cause.name == name:
                return cause
        known = ", ".join(cause.name for cause in self.causes)
        raise InputError("cause", expected=f"one of {known}", received=quoted(name))

    def outputs(self, cases: Sequence[tuple[Mapping[str, float], Trial]]) -> list[dict[str, Array]]:
        """What is predicted for each of some values and trials.

        Raises:
            InputError: a channel is missing, or has another length than the trial.
        """
        with np.errstate(all="ignore"):  # a fit may ask for what cannot be simulated
            many = self.predict_many(cases) if self.predict_many else [self.predict(values, trial) for values, trial in cases]
        return [_checked(found, trial) for found, (_, trial) in zip(many, cases, strict=True)]


def _checked(found: Outputs, trial: Trial) -> dict[str, Array]:
    """What was predicted for a trial, as arrays."""
    shown = {}
    for channel, measured in trial.measured.items():
        if channel not in found:
            raise InputError(
                f"prediction for {trial.name}", expected=f"channel {channel}", received=", ".join(found) or "nothing"
            )
        values = np.asarray(found[channel], dtype=float)
        if values.shape != np.shape(measured):
            expected, received = f"{len(np.asarray(trial.time))} values", f"shape {values.shape}"
            raise InputError(f"prediction of {channel} for {trial.name}", expected=expected, received=received)
        shown[channel] = values
    return shown

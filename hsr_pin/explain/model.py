"""A user-defined model: a prediction function, its free parameters and the causes that it may lack."""

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

#: Default bounds of a factor on a declared number.
_FACTOR = (0.1, 10.0)
#: Default bound of an amplitude, in its scales.
_REACH = 20.0
#: A prediction: an array (N,) for each channel.
Outputs = Mapping[str, ArrayLike]


def factor(
    name: str, width: float = 0.3, *, lower: float = _FACTOR[0], upper: float = _FACTOR[1], description: str = ""
) -> Parameter:
    """Return a factor on a declared number; 1 leaves the number unchanged.

    Args:
        name: name of the parameter.
        width: prior standard deviation of its logarithm: 0.3 for a measured number, 1 for a guess.
        lower: lower bound.
        upper: upper bound.
        description: one line.
    """
    return Parameter(name, "1", 1.0, lower, upper, 0.1, False, description, ratio_width=width)


def amplitude(
    name: str, scale: float, unit: str = "1", *, lower: float = -math.inf, upper: float = math.inf, description: str = ""
) -> Parameter:
    """Return the amplitude of a cause; 0 switches the cause off.

    Args:
        name: name of the parameter.
        scale: a change of practical size [unit]; the prior standard deviation is five of these.
        unit: unit of the value.
        lower: lower bound; default: twenty scales below 0; use 0 for an amplitude that cannot be negative.
        upper: upper bound; default: twenty scales above 0.
        description: one line.
    """
    reach = _REACH * scale
    return Parameter(name, unit, 0.0, max(lower, -reach), min(upper, reach), scale, True, description)


def shape(
    name: str,
    start: float,
    lower: float,
    upper: float,
    unit: str = "1",
    *,
    scale: float = 0.0,
    start_count: int = 3,
    description: str = "",
) -> Parameter:
    """Return a shape parameter of a cause (a time constant, a threshold), which has no influence while the amplitude is 0.

    Args:
        name: name of the parameter.
        start: initial value of a fit.
        lower: lower bound.
        upper: upper bound.
        unit: unit of the value.
        scale: a change of practical size; default: a tenth of the range between the bounds.
        start_count: number of initial values between the bounds that a search tries.
        description: one line.
    """
    width = scale or (upper - lower) / 10
    return Parameter(name, unit, start, lower, upper, width, False, description, start_count=start_count)


@dataclass(frozen=True)
class Cause:
    """A physical cause that the model may lack.

    Attributes:
        name: name in reports.
        kind: kind of physics, in one word; causes of one kind are reported together if the data cannot distinguish them.
        parameters: its parameters; the model's function receives each of them as ``values["name.parameter"]``.
        description: one line.
        apart: groups of parameter names that may be free alone while the others stay neutral, for instance if only one joint has
            friction; the variant with all parameters free is always included.
        contains: names of causes that are special cases of this one.
        flexible: whether the cause only stands for its kind of physics, and is never named.
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
    """One recorded trial.

    Attributes:
        name: name of the trial.
        time: (N,) increasing sampling times [s]; anything that can be converted to an array.
        measured: for each channel the measured values (N,); NaN in gaps.
        inputs: any picklable data about the trial that the model's function needs.
        labels: labels of the trial (a payload, an operator, a day), by which the gap is shown too.
        own: prior standard deviations of parameters of this trial alone, such as an error of the initial state; they have mean 0,
            and the function receives each of them as ``values[name]``.
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
            raise InputError(f"time of {self.name}", expected="at least two increasing numbers", received=f"shape {time.shape}")
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
    """A user-defined model.

    Attributes:
        predict: ``predict(values, trial)`` returns an array (N,) for each channel, from the values of all parameters and a trial.
            It returns NaN where a simulation fails. To be used in several processes, it must be importable by name.
        parameters: parameters that are always fitted, also without any cause.
        causes: causes that the model may lack; their values are neutral unless the cause is tried.
        name: name of the modelled system.
        units: units of the channels; default: no unit is shown.
        noise: standard deviation of the noise of each channel; default: estimated from the recordings.
        truest: relative accuracy of the best possible model, as a share of the standard deviation of a channel; a smaller noise
            is not weighted more.
        least: absolute accuracy of the best possible model for single channels, in their units.
        tolerances: names of errors of declared numbers that are known with a standard deviation only; the function receives each
            error, in standard deviations, as ``values[name]``; a missing error is 0.
        predict_many: function for many predictions at once, if that is faster: from a list of pairs (values, trial) to a list of
            predictions.
        slopes: known derivatives: ``slopes(values, trial)`` returns for each channel and parameter name an array (N,); missing
            derivatives are computed by finite differences.
    """

    predict: Callable[[Mapping[str, float], Trial], Outputs]
    parameters: tuple[Parameter, ...] = ()
    causes: tuple[Cause, ...] = ()
    name: str = "model"
    units: Mapping[str, str] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    truest: float = 1e-3
    least: Mapping[str, float] = field(default_factory=dict)
    tolerances: tuple[str, ...] = ()
    predict_many: Callable[[Sequence[tuple[Mapping[str, float], Trial]]], Sequence[Outputs]] | None = None
    slopes: Callable[[Mapping[str, float], Trial], Mapping[str, Mapping[str, ArrayLike]]] | None = None

    def __post_init__(self) -> None:
        names = [*(fact.name for fact in self.parameters), *(cause.name for cause in self.causes)]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise InputError("model", expected="parameters and causes with different names", received=f"{twice[0]} twice")
        if wrong := [name for name in names if "." in name]:
            raise InputError("model", expected="names without a dot", received=quoted(wrong[0]))
        if empty := [cause.name for cause in self.causes if not cause.parameters]:
            raise InputError(f"cause {empty[0]}", expected="at least one parameter", received="none")

    @property
    def neutral(self) -> dict[str, float]:
        """Neutral values of all parameters, which leave the model unchanged."""
        own = ((fact.name, fact.neutral) for fact in self.parameters)
        others = ((f"{cause.name}.{fact.name}", fact.neutral) for cause in self.causes for fact in cause.parameters)
        return dict(chain(own, others))

    def cause(self, name: str) -> Cause:
        """Return the cause with a name.

        Raises:
            InputError: there is no such cause.
        """
        for cause in self.causes:
            if cause.name == name:
                return cause
        known = ", ".join(cause.name for cause in self.causes)
        raise InputError("cause", expected=f"one of {known}", received=quoted(name))

    def outputs(self, cases: Sequence[tuple[Mapping[str, float], Trial]]) -> list[dict[str, Array]]:
        """Return the prediction for each pair of values and trial.

        Raises:
            InputError: a channel is missing, or its length differs from that of the trial.
        """
        with np.errstate(all="ignore"):  # a fit may try values that cannot be simulated
            many = self.predict_many(cases) if self.predict_many else [self.predict(values, trial) for values, trial in cases]
        return [_checked(found, trial) for found, (_, trial) in zip(many, cases, strict=True)]


def _checked(found: Outputs, trial: Trial) -> dict[str, Array]:
    """Return the prediction for a trial as arrays, after checking channels and lengths."""
    arrays = {}
    for channel, measured in trial.measured.items():
        if channel not in found:
            raise InputError(
                f"prediction for {trial.name}", expected=f"channel {channel}", received=", ".join(found) or "nothing"
            )
        values = np.asarray(found[channel], dtype=float)
        if values.shape != np.shape(measured):
            expected, received = f"{len(np.asarray(trial.time))} values", f"shape {values.shape}"
            raise InputError(f"prediction of {channel} for {trial.name}", expected=expected, received=received)
        arrays[channel] = values
    return arrays

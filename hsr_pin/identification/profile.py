"""Profile likelihood: the quality of the fit with one parameter fixed at other values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.optimize import least_squares

from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.misfit import Misfit
from hsr_pin.inference.uncertainty import uncertainty
from hsr_pin.trajectory import Array

#: Distances at which a parameter is fixed, in standard errors on both sides of its best value.
_AWAY = (1.0, 2.0, 3.0)
_TOLERANCE, _EVALUATIONS = 1e-3, 6


@dataclass(frozen=True, eq=False)
class Profile:
    """The profile likelihood of one parameter.

    Attributes:
        name: name of the parameter.
        values: (n,) values at which it was fixed, increasing.
        deviance: (n,) increase of -2 log likelihood above its minimum, with the other parameters refitted.
        interval: 95 % interval: where the deviance is below 3.84, or up to the last tried value if it does not reach that.
    """

    name: str
    values: Array
    deviance: Array
    interval: tuple[float, float]


def profile_likelihood(experiment: Experiment, fit: Fit, name: str) -> Profile:
    """Return the profile likelihood of one parameter around a fit (A. Raue et al., Bioinformatics 25, 2009).

    The likelihood is that of residuals with the weights of the fit; the effective number of independent observations follows from
    the parameter's variance, which is estimated with autocorrelation. For a nearly linear model this gives the same interval as
    :func:`~hsr_pin.inference.uncertainty.uncertainty`; for a nonlinear one it is more accurate.

    Raises:
        IdentificationError: the parameter was not fitted.
    """
    if name not in fit.hypothesis.free:
        raise IdentificationError("parameter", expected=", ".join(fit.hypothesis.free), received=repr(name))
    held, uncertainties = fit.hypothesis.free.index(name), uncertainty(fit)
    misfit = Misfit(experiment, fit.hypothesis, fit.weights)
    best, error = fit.values / misfit.scale, uncertainties.standard_error[held] / misfit.scale[held]
    misfit.hold(best)
    least = misfit.residual(best)
    spread = float(least @ least) / max(len(least) - len(best), 1) * float(uncertainties.inflation[held])
    values, deviance = [best[held]], [0.0]
    for side in (-1.0, 1.0):
        x = best
        for steps in _AWAY:
            value = float(np.clip(best[held] + side * steps * error, misfit.lower[held], misfit.upper[held]))
            if value in values:
                break
            x = _refitted(misfit, x, held, value)
            rest = misfit.residual(x)
            values.append(value)
            deviance.append(max(0.0, float(rest @ rest - least @ least) / spread))
    order = np.argsort(values)
    v, d = np.array(values)[order], np.array(deviance)[order]
    return Profile(name, v * misfit.scale[held], d, _interval(v * misfit.scale[held], d))


def _refitted(misfit: Misfit, x: Array, held: int, value: float) -> Array:
    """Return the best parameter values (P,) with one of them fixed, starting from ``x``."""
    others = np.arange(len(x)) != held

    def whole(rest: Array) -> Array:
        full = np.array(x)
        full[held], full[others] = value, rest
        return full

    if not others.any():
        return whole(np.empty(0))
    lower, upper = misfit.lower[others], misfit.upper[others]
    answer = least_squares(
        lambda rest: misfit.residual(whole(rest)),
        np.clip(x[others], lower + 1e-9 * (upper - lower), upper - 1e-9 * (upper - lower)),
        jac=lambda rest: misfit.jacobian(whole(rest))[:, others],
        bounds=(lower, upper),
        ftol=_TOLERANCE,
        xtol=_TOLERANCE,
        max_nfev=_EVALUATIONS,
    )
    return whole(answer.x)


def _interval(values: Array, deviance: Array) -> tuple[float, float]:
    """Return where the root of the deviance, which is nearly straight on both sides of its zero, crosses that of 3.84."""
    root, wanted = np.sqrt(deviance), float(np.sqrt(stats.chi2.ppf(0.95, 1)))
    best = int(np.argmin(deviance))
    ends = []
    for side in (slice(best, None, -1), slice(best, None)):
        v, r = values[side], np.maximum.accumulate(root[side])
        ends.append(float(np.interp(wanted, r, v)) if r[-1] > wanted else float(v[-1]))
    return ends[0], ends[1]

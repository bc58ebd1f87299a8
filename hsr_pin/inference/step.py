"""One damped Gauss-Newton step, which is stable even if the data do not determine a parameter."""

from __future__ import annotations

import numpy as np

from hsr_pin.trajectory import Array

#: A parameter whose influence on the residuals is below this share of the strongest one stays nearly unchanged.
_LEAST, _NOTHING = 1e-6, 1e-100


def damped_inverse(slopes: Array, damping: float) -> Array:
    """Return the inverse (P, P) of the normal matrix of derivatives (n, P), with a share of its diagonal added.

    The entry of a parameter without influence is large and finite (D. W. Marquardt, SIAM J. Appl. Math. 11, 1963).
    """
    normal = slopes.T @ slopes
    size = np.sqrt(np.diag(normal))
    size = np.maximum(size, max(_LEAST * float(size.max(initial=0.0)), _NOTHING))
    return np.asarray(np.linalg.inv(normal / size / size[:, None] + damping * np.eye(len(size))) / size / size[:, None])


def damped_step(slopes: Array, residual: Array, damping: float) -> Array:
    """Return the change (P,) of the parameters that removes most of a residual (n,), for derivatives (n, P)."""
    return np.asarray(-damped_inverse(slopes, damping) @ (slopes.T @ residual))

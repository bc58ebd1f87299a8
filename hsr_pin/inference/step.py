"""One Gauss-Newton step, damped so that it holds where the data do not move a parameter."""

from __future__ import annotations

import numpy as np

from hsr_pin.trajectory import Array

#: A parameter that moves the residuals less than this share of what the most telling one does stays about where it is.
_LEAST, _NOTHING = 1e-6, 1e-100


def damped_inverse(slopes: Array, damping: float) -> Array:
    """(P, P) inverse of the normal matrix of derivatives (n, P), with a share of its diagonal added.

    For a parameter that moves nothing its entry is large, and finite (D. W. Marquardt, SIAM J. Appl. Math. 11, 1963).
    """
    normal = slopes.T @ slopes
    size = np.sqrt(np.diag(normal))
    size = np.maximum(size, max(_LEAST * float(size.max(initial=0.0)), _NOTHING))
    return np.asarray(np.linalg.inv(normal / size / size[:, None] + damping * np.eye(len(size))) / size / size[:, None])


def damped_step(slopes: Array, residual: Array, damping: float) -> Array:
    """(P,) the change of the parameters that takes most of a residual (n,) away, for derivatives (n, P)."""
    return np.asarray(-damped_inverse(slopes, damping) @ (slopes.T @ residual))

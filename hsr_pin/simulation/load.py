"""Loads on an arm in space: a force and a moment at a point of the backbone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.errors import InputError
from hsr_pin.parameters import finite
from hsr_pin.trajectory import Array, read_only


@dataclass(frozen=True, eq=False)
class Load:
    """A force and a moment at one point of the backbone that keep their directions in the world frame.

    Attributes:
        arc_length: arc length of the point, from the base [m].
        force: (3,) or (T, 3) force in the world frame [N]; the value of each sample of a scenario is held until the next.
        moment: (3,) or (T, 3) moment in the world frame [N m]; the value of each sample is held until the next.
        before: (6,) force [N] and moment [N m] at which an initial equilibrium is computed; default: those of the first sample.
    """

    arc_length: float
    force: ArrayLike = (0.0, 0.0, 0.0)
    moment: ArrayLike = (0.0, 0.0, 0.0)
    before: ArrayLike | None = None

    def __post_init__(self) -> None:
        finite("arc length of a load", self.arc_length, "a finite number [m]")
        for name in ("force", "moment", "before"):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            if values is None:
                continue
            fits = values.shape == (6,) if name == "before" else values.ndim in (1, 2) and values.shape[-1] == 3
            if not fits or not np.all(np.isfinite(values)):
                expected = "six finite numbers" if name == "before" else "finite numbers (3,) or (T, 3)"
                raise InputError(f"{name} of a load", expected=expected, received=f"shape {values.shape}")

    def wrenches(self, samples: int) -> Array:
        """Return the forces [N] and moments [N m] at the samples, (T, 6).

        Raises:
            InputError: the load is given for another number of samples.
        """
        found = np.empty((samples, 6))
        for place, name in ((slice(0, 3), "force"), (slice(3, 6), "moment")):
            values = np.asarray(getattr(self, name))
            if values.ndim == 2 and len(values) != samples:
                raise InputError(f"{name} of a load", expected=f"{samples} samples", received=str(len(values)))
            found[:, place] = values
        return found

"""Where the markers of arms are seen."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import View
from hsr_pin.robot.kinematics import MarkerMap, marker_map
from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array


class Cameras:
    """Marker positions with what the effects make of them.

    Args:
        columns: the arms.
        arc_lengths: (M,) or (B, M) [m] of the markers, from the base.
    """

    def __init__(self, columns: Columns, arc_lengths: ArrayLike) -> None:
        self._reach = np.asarray(arc_lengths, dtype=float)
        self._places: MarkerMap = marker_map(columns.arms, self._reach)
        self._effects = tuple(effect for effect in columns.effects if effect.acts_through("observe"))

    def positions(self, q: Array) -> Array:
        """(T, B, M, 3) [m] in the world frame, for joint angles q (T, B, N) [rad]."""
        seen = self._places.positions(q)
        for effect in self._effects:
            seen = effect.observe(View(seen, self._places.normals(q), self._places.turned(q), self._reach, self._places.axis))
        return seen

"""Where the markers of arms are seen."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import View
from hsr_pin.robot.kinematics import MarkerMap, marker_map
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.compiled import see
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from hsr_pin.robot.space_kinematics import SpaceMarkerMap


#: [s] Difference for velocities where effects change what is seen.
_INSTANT = 1e-3


class Cameras:
    """Marker positions with what the effects make of them.

    Args:
        columns: the arms.
        arc_lengths: (M,) or (B, M) [m] of the markers, from the base.
        beside: (M,) or (B, M) complex [m] from the backbone, towards x and towards y of the link; in space alone.
        fast: by machine code, for very many poses; in a plane.
    """

    def __init__(self, columns: Columns, arc_lengths: ArrayLike, beside: ArrayLike = 0.0, *, fast: bool = False) -> None:
        self._columns, self._reach, self._beside = columns, np.asarray(arc_lengths, dtype=float), np.asarray(beside)
        self._fast = fast
        self._places = _places(columns, self._reach, self._beside)
        self._effects = tuple(effect for effect in columns.effects if effect.acts_through("observe"))

    @cached_property
    def first(self) -> Cameras:
        """What is seen of the first arm alone."""
        reach, beside = (values[:1] if values.ndim == 2 else values for values in (self._reach, self._beside))
        return Cameras(self._columns.members(slice(0, 1)), reach, beside, fast=self._fast)

    @property
    def places(self) -> MarkerMap | SpaceMarkerMap:
        """Where the markers are, without what effects make of it."""
        return self._places

    def positions(self, q: Array) -> Array:
        """(T, B, M, 3) [m] in the world frame, for joint angles q (T, B, N) [rad], in space (T, B, 3 N)."""
        seen = _seen(self._places, q) if self._fast and isinstance(self._places, MarkerMap) else self._places.positions(q)
        for effect in self._effects:
            seen = effect.observe(View(seen, self._reach, self._places, q))
        return seen

    def velocities(self, q: Array, v: Array) -> Array:
        """(T, B, M, 3) [m/s] how fast they are seen to move, for joint angles q and rates v (T, B, N), in space (T, B, 3 N)."""
        if not self._effects:
            return self._places.velocities(q, v)
        return (self.positions(q + _INSTANT * v) - self.positions(q)) / _INSTANT


def _seen(places: MarkerMap, q: Array) -> Array:
    """As :meth:`hsr_pin.robot.kinematics.MarkerMap.positions`, (T, B, M, 3) [m] for (T, B, N)."""
    seen = np.empty((*q.shape[:2], places.fixed.shape[1], 3))
    see()(np.ascontiguousarray(q), places.fixed, places.spans, places.direction, places.normal, seen)
    return seen


def _places(columns: Columns, reach: Array, beside: ArrayLike) -> MarkerMap | SpaceMarkerMap:
    if not columns.space:
        return marker_map(columns.arms, reach)
    from hsr_pin.robot.space_kinematics import space_marker_map

    return space_marker_map(columns.arms, reach, beside)

"""Marker positions of arms as the cameras measure them, including the effects on the measurement."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from hsr_pin.effects.effect import View
from hsr_pin.robot.kinematics import MarkerMap, marker_map
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.compiled import marker_projector
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from hsr_pin.robot.space_kinematics import SpaceMarkerMap


#: Time step of the finite differences for velocities if effects change the measurement [s].
_INSTANT = 1e-3


class Cameras:
    """Compute measured marker positions and velocities of a batch of arms.

    Args:
        batch: the arms.
        arc_lengths: (M,) or (B, M) arc lengths of the markers, from the base [m].
        beside: (M,) or (B, M) complex offsets from the backbone, towards x and y of the link [m]; used for arms in space only.
        fast: use machine code, for very many poses; planar arms only.
    """

    def __init__(self, batch: ArmBatch, arc_lengths: ArrayLike, beside: ArrayLike = 0.0, *, fast: bool = False) -> None:
        self._columns, self._reach, self._beside = batch, np.asarray(arc_lengths, dtype=float), np.asarray(beside)
        self._fast = fast
        self._places = _places(batch, self._reach, self._beside)
        self._effects = tuple(effect for effect in batch.effects if effect.acts_through("observe"))

    @cached_property
    def first(self) -> Cameras:
        """The cameras of the first arm alone."""
        reach, beside = (values[:1] if values.ndim == 2 else values for values in (self._reach, self._beside))
        return Cameras(self._columns.members(slice(0, 1)), reach, beside, fast=self._fast)

    @property
    def places(self) -> MarkerMap | SpaceMarkerMap:
        """The geometric marker positions, without the effects on the measurement."""
        return self._places

    def positions(self, q: Array) -> Array:
        """Return the measured marker positions (T, B, M, 3) in the world frame [m].

        The joint angles q are (T, B, N) [rad], of arms in space (T, B, 3 N).
        """
        seen = _seen(self._places, q) if self._fast and isinstance(self._places, MarkerMap) else self._places.positions(q)
        for effect in self._effects:
            seen = effect.observe(View(seen, self._reach, self._places, q))
        return seen

    def velocities(self, q: Array, v: Array) -> Array:
        """Return the velocities (T, B, M, 3) of the measured marker positions [m/s].

        The joint angles q [rad] and rates v [rad/s] are (T, B, N), of arms in space (T, B, 3 N).
        """
        if not self._effects:
            return self._places.velocities(q, v)
        return (self.positions(q + _INSTANT * v) - self.positions(q)) / _INSTANT


def _seen(places: MarkerMap, q: Array) -> Array:
    """Return marker positions (T, B, M, 3) [m] for joint angles (T, B, N) [rad], by machine code."""
    seen = np.empty((*q.shape[:2], places.fixed.shape[1], 3))
    marker_projector()(np.ascontiguousarray(q), places.fixed, places.spans, places.direction, places.normal, seen)
    return seen


def _places(batch: ArmBatch, reach: Array, beside: ArrayLike) -> MarkerMap | SpaceMarkerMap:
    """Return the marker map of a planar or spatial batch for markers at the arc lengths ``reach`` [m]."""
    if not batch.space:
        return marker_map(batch.arms, reach)
    from hsr_pin.robot.space_kinematics import space_marker_map

    return space_marker_map(batch.arms, reach, beside)

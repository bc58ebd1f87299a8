"""Where the markers of arms with the same rigid bodies are seen."""

from __future__ import annotations

import numpy as np

from hsr_pin.effects.effect import Effect, View
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import ArmModel
from hsr_pin.trajectory import Array, Marker


class Cameras:
    """Marker positions with what the effects make of them.

    Args:
        model: of the arms.
        markers: (M,) to follow.
        effects: of the arms, stacked or of one arm.
    """

    def __init__(self, model: ArmModel, markers: tuple[Marker, ...], effects: tuple[Effect, ...]) -> None:
        self._reach = np.array([marker.arc_length for marker in markers])
        self._places = marker_map(model, self._reach)
        self._axis = model.joint_axis
        self._effects = tuple(effect for effect in effects if effect.acts_through("observe"))

    def positions(self, q: Array) -> Array:
        """(T, B, M, 3) [m] in the world frame, for joint angles q (T, B, N) [rad]."""
        seen = self._places.positions(q)
        for effect in self._effects:
            seen = effect.observe(View(seen, self._places.normals(q), self._reach, self._axis))
        return seen

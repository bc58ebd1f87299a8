"""Three-dimensional view of the simulated arm, the declared arm and the measured markers."""

from __future__ import annotations

from typing import Any

import numpy as np

from hsr_pin.trajectory import Array

#: RGB colours of simulated, declared and measured motion (Okabe and Ito's colours for colour-blind readers).
BLUE, GREY, ORANGE = (0, 114, 178), (170, 170, 175), (213, 94, 0)
#: Radii as shares of the arm's length.
_TUBE, _THIN, _BALL = 0.022, 0.014, 0.018


class Scene:
    """Three-dimensional objects of the page.

    Args:
        server: server of viser.
        length: length of the arm [m].
        along: (3,) unit vector along the straight arm.
        markers: number of markers.
        space: whether the arm bends in space; it is then shown from above over a floor instead of before a wall.
    """

    def __init__(self, server: Any, length: float, along: Array, markers: int, *, space: bool = False) -> None:
        scene = server.scene
        scene.set_up_direction("+z")
        middle = along * length / 2  # middle of the straight arm
        aside = np.array([1.1, -1.9, 0.9]) if space else np.array([0.0, -2.2, 0.3])
        server.initial_camera.position = middle + length * aside
        server.initial_camera.look_at = middle
        server.initial_camera.fov = np.deg2rad(45)
        lines = {"cell_color": (225, 225, 230), "section_color": (225, 225, 230), "cell_size": 0.05, "section_size": 0.05}
        if space:
            floor = (0.0, 0.0, length * (min(0.0, float(along[2])) - (0.7 if along[2] == 0 else 0.1)))
            scene.add_grid("/floor", 2.4 * length, 2.4 * length, plane="xy", position=floor, shadow_opacity=0.0, **lines)
        else:
            wall = (0.0, 0.1 * length, 0.0)
            scene.add_grid("/wall", 4 * length, 4 * length, plane="xz", position=wall, shadow_opacity=0.0, **lines)
        straight = np.linspace(np.zeros(3), length * along, 3)
        behind = (0.0, 0.0 if space else 2 * _TUBE * length, 0.0)  # so that coincident curves do not flicker
        thin = _THIN * length
        self.declared = scene.add_spline_catmull_rom(
            "/declared", straight, thickness=thin, color=GREY, segments=48, position=behind
        )
        self.simulated = scene.add_spline_catmull_rom("/simulated", straight, thickness=_TUBE * length, color=BLUE, segments=48)
        self._balls = [
            [scene.add_icosphere(f"/{name}/{i}", size * _BALL * length, colour, cast_shadow=False) for i in range(markers)]
            for name, colour, size in (("measured", ORANGE, 1.4), ("simulated_markers", BLUE, 1.0))
        ]
        self._rods = scene.add_line_segments("/gap", np.zeros((markers, 2, 3)), ORANGE, thickness=2.0, thickness_units="screen")

    def show(self, backbone: Array, declared: Array, simulated: Array, measured: Array) -> None:
        """Show backbones (POINTS, 3) [m] and markers (M, 3) [m] at one instant; NaN is not shown."""
        for curve, points in ((self.simulated, backbone), (self.declared, declared)):
            curve.visible = bool(np.isfinite(points).all())
            if curve.visible:
                curve.points = np.ascontiguousarray(points[::2], dtype=np.float32)
        for balls, places in zip(self._balls, (measured, simulated), strict=True):
            for ball, place in zip(balls, places, strict=True):
                ball.visible = bool(np.isfinite(place).all())
                if ball.visible:
                    ball.position = place
        both = np.isfinite(measured + simulated).all(axis=1, keepdims=True)
        rods = np.stack([measured, np.where(both, simulated, measured)], axis=1)
        self._rods.points = np.nan_to_num(rods).astype(np.float32)

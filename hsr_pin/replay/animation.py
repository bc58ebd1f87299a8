"""Animation of arms in a meshcat scene, for a live viewer or a page.

The camera is at negative y and faces the plane of bending. Several arms are placed side by side. Trails, measured markers and the
gaps to them are drawn just in front of the arm, so that it does not hide them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from hsr_pin.replay.bodies import Body, bodies, poses
from hsr_pin.replay.drawn import Drawn
from hsr_pin.replay.labels import label
from hsr_pin.replay.obstacles import COLOUR, FORCE, arrows, shape
from hsr_pin.replay.viewer import Path, Visualizer
from hsr_pin.replay.viewer import animation as ma
from hsr_pin.replay.viewer import geometry as mg
from hsr_pin.replay.viewer import transformations as mt
from hsr_pin.robot.specification import mount_frame
from hsr_pin.trajectory import Array

#: Frames per second, and largest number of frames; longer runs have fewer frames per second.
RATE, MOST_FRAMES = 50.0, 2000
#: Largest change of a property from frame to frame that counts as no change.
STILL = 1e-6
#: Side of the squares of the grid behind the arms [m].
GRID = 0.05
#: Colours of simulated and measured motion (Okabe and Ito's blue and vermilion).
SIMULATED, MEASURED = 0x0072B2, 0xD55E00
#: Colours of the trails of several simulated runs.
TRAILS = (0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0x56B4E9, 0xE69F00)

#: Aspect ratio (width to height) of the window for which the scene is arranged.
ASPECT = 1.5
_FIELD_OF_VIEW = 30.0
_HALF_VIEW = math.tan(math.radians(_FIELD_OF_VIEW / 2))
_VIEW = np.array([0.16, -1.0, 0.13]) / np.linalg.norm([0.16, -1.0, 0.13])
_VIEW_IN_SPACE = np.array([0.55, -1.0, 0.4]) / np.linalg.norm([0.55, -1.0, 0.4])


@dataclass(frozen=True, eq=False)
class Clip:
    """Common frames of several runs: times ``time`` (F,) [s] on the clock of the recordings, and frames per second."""

    time: Array
    rate: float


def draw(viewer: Visualizer, runs: Sequence[Drawn]) -> Clip:
    """Draw arms, markers, trails and their motion in a viewer, and place its camera so that everything is visible.

    Args:
        viewer: a live viewer, or one that records its commands.
        runs: runs to draw side by side.

    Returns:
        The frames of the animation that the viewer now plays.
    """
    clip = _clip(runs)
    low, high = _reach(runs)
    shift = _arrangement(high - low)
    animation = ma.Animation(default_framerate=clip.rate)
    scene = viewer["arms"]
    for number, run in enumerate(runs):
        place = scene[f"arm_{number + 1}"]
        place.set_transform(mt.translation_matrix(number * shift))
        colour = trail_colour(run, number)
        _draw_arm(place, run, clip, animation)
        _draw_trail(place["simulated_trail"], run.tip_path + _front(run), colour, 0.06 * run.arm.diameter)
        if run.measured is not None:
            _draw_measured(place, run, clip, animation)
        if run.arm.obstacles:
            _draw_obstacles(place, run, clip, animation, float(np.linalg.norm(high - low)))
        if len(runs) > 1:
            height = 0.1 * run.arm.length
            place["label"].set_object(*label(run.label.split(" (")[0], f"#{colour:06x}", height))
            place["label"].set_transform(_upright_at(_label_place(run, low, high, height)))
    whole = np.array([low + np.minimum(0, (len(runs) - 1) * shift), high + np.maximum(0, (len(runs) - 1) * shift)])
    space = any(run.arm.bending == "space" for run in runs)
    _draw_wall(scene["grid"], whole, max(1.5 * runs[0].arm.diameter, whole[1, 1] if space else 0.0))
    _set_stage(viewer, scene, whole, _VIEW_IN_SPACE if space else _VIEW)
    viewer.set_animation(animation, play=True, repetitions=math.inf)
    return clip


def trail_colour(run: Drawn, number: int) -> int:
    """Return the colour 0xRRGGBB of the simulated trail of a run with a given number."""
    return SIMULATED if run.measured is not None else TRAILS[number % len(TRAILS)]


def _clip(runs: Sequence[Drawn]) -> Clip:
    start = min(run.simulated.time[0] for run in runs)
    span = max(run.simulated.time[-1] for run in runs) - start
    rate = min(RATE, MOST_FRAMES / span)
    return Clip(start + np.arange(int(span * rate) + 1) / rate, rate)


def _reach(runs: Sequence[Drawn]) -> tuple[Array, Array]:
    """Return the corners (3,) [m] of the bounding box of the motion of all runs, relative to their bases."""
    points = [np.zeros((1, 3))]
    for run in runs:
        points.append(run.simulated.positions.reshape(-1, 3))
        if run.measured is not None:
            points.append(run.measured.positions.reshape(-1, 3))
    every = np.concatenate(points)
    margin = 0.8 * max(run.arm.diameter for run in runs)
    return np.nanmin(every, axis=0) - margin, np.nanmax(every, axis=0) + margin


def _arrangement(extent: Array) -> Array:
    """Return the offset (3,) [m] from one arm to the next, sideways or, for wide motions, downwards."""
    if extent[0] > 1.3 * extent[2]:
        return np.array([0.0, 0.0, -1.2 * extent[2]])
    return np.array([1.1 * extent[0], 0.0, 0.0])


def _draw_arm(place: Visualizer, run: Drawn, clip: Clip, animation: ma.Animation) -> None:
    for body in bodies(run.arm):
        if run.measured is not None and body.height is None:
            continue  # the markers of the URDF could be mistaken for measured ones
        node = place[f"joint_{body.joint}"][body.name]
        node.set_object(_geometry(body), mg.MeshLambertMaterial(color=body.colour))
        node.set_transform(body.placement)
    radius = run.arm.diameter
    plate = place["mount"]
    plate.set_object(mg.Cylinder(0.1 * radius, 0.9 * radius), mg.MeshLambertMaterial(color=0x9AA0A8))
    translation, quaternion = (part[:, 0] for part in poses(run.arm, np.zeros_like(run.angles[:1])))
    base = _matrix(translation[0], quaternion[0])
    plate.set_transform(base @ mt.translation_matrix([0, 0, -0.05 * radius]) @ mt.rotation_matrix(math.pi / 2, [1, 0, 0]))
    angles = _at_frames(clip.time, run.simulated.time, run.angles.reshape(len(run.angles), -1))
    angles = angles.reshape(-1, *run.angles.shape[1:])
    translations, quaternions = poses(run.arm, angles)
    for joint in range(1, run.arm.links + 1):
        path = place.path.append(f"joint_{joint}")
        _animate(animation, path, clip, position=translations[:, joint], quaternion=quaternions[:, joint])


def _draw_measured(place: Visualizer, run: Drawn, clip: Clip, animation: ma.Animation) -> None:
    assert run.measured is not None
    radius, front = 0.13 * run.arm.diameter, _front(run)
    for marker in run.moving:
        seen = _at_frames(clip.time, run.measured.time, run.measured.marker(marker.name)) + front
        simulated = _at_frames(clip.time, run.simulated.time, run.simulated.marker(marker.name)) + front
        visible = np.asarray(np.isfinite(seen).all(axis=1))
        seen = np.where(visible[:, None], seen, simulated)
        for kind, path, colour in (("measured", seen, MEASURED), ("simulated", simulated, SIMULATED)):
            node = place[f"{kind}_markers"][marker.name]
            node.set_object(mg.Sphere(radius), mg.MeshLambertMaterial(color=colour))
            shown = visible if kind == "measured" else np.ones_like(visible)
            _animate(animation, node.path, clip, position=path, visible=shown)
        gap = place["gaps"][marker.name]
        gap.set_object(mg.Cylinder(1.0, 1.0), mg.MeshLambertMaterial(color=0x333333))
        _animate(animation, gap.path, clip, visible=visible, **_rod(simulated, seen, 0.3 * radius))
    if run.tip in run.common:
        trail = run.measured.marker(run.tip.name) + front
        _draw_trail(place["measured_trail"], trail, MEASURED, 0.08 * run.arm.diameter, between=False)


def _draw_obstacles(place: Visualizer, run: Drawn, clip: Clip, animation: ma.Animation, extent: float) -> None:
    for number, obstacle in enumerate(run.arm.obstacles, 1):
        node = place[f"obstacle_{number}"]
        geometry, placement = shape(obstacle, extent)
        node.set_object(geometry, mg.MeshLambertMaterial(color=COLOUR))
        node.set_transform(placement)
    if run.forces is None:
        return
    starts, ends = arrows(run.forces[0], run.forces[1], extent)
    front = _front(run)
    for o in range(starts.shape[1]):
        node = place[f"force_{o + 1}"]
        node.set_object(mg.Cylinder(1.0, 1.0), mg.MeshBasicMaterial(color=FORCE))
        start, end = (_at_frames(clip.time, run.simulated.time, points[:, o]) for points in (starts, ends))
        seen = np.isfinite(np.concatenate([start, end], axis=1)).all(axis=1)
        rod = _rod(np.nan_to_num(start) + front, np.nan_to_num(end) + front, 0.05 * run.arm.diameter)
        _animate(animation, node.path, clip, visible=seen, **rod)


def _draw_trail(node: Visualizer, path: Array, colour: int, size: float, *, between: bool = True) -> None:
    """Draw a path (T, 3) as dots of a size [m], either so dense that they form a line or at the samples only; NaN is skipped."""
    points = path[np.isfinite(path).all(axis=1)]
    if between:
        length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        even = np.linspace(0.0, length[-1], min(5000, int(2 * length[-1] / size) + 2))
        points = np.stack([np.interp(even, length, axis) for axis in points.T], axis=-1)
    shade = np.array([colour >> 16 & 255, colour >> 8 & 255, colour & 255]) / 255
    geometry = mg.PointsGeometry(points.T, np.tile(shade[:, None], len(points)))
    node.set_object(mg.Points(geometry, mg.PointsMaterial(size=size / _HALF_VIEW)))


def _draw_wall(node: Visualizer, corners: Array, behind: float) -> None:
    """Draw a grid in the plane of bending, behind the arms."""
    low, high = np.floor(corners[0] / GRID) * GRID, np.ceil(corners[1] / GRID) * GRID
    lines = [[[x, behind, low[2]], [x, behind, high[2]]] for x in np.arange(low[0], high[0] + GRID / 2, GRID)] + [
        [[low[0], behind, z], [high[0], behind, z]] for z in np.arange(low[2], high[2] + GRID / 2, GRID)
    ]
    points = np.array(lines).reshape(-1, 3).T
    node.set_object(mg.LineSegments(mg.PointsGeometry(points), mg.LineBasicMaterial(color=0xC4CAD3)))


def _set_stage(viewer: Visualizer, scene: Visualizer, corners: Array, view: Array) -> None:
    """Set the background and a camera that sees all between two corners (2, 3) [m], by moving the scene to the origin.

    The camera is in the direction ``view`` (3,) from the scene.
    """
    scene.set_transform(mt.translation_matrix(-corners.mean(axis=0)))
    width, depth, height = corners[1] - corners[0]
    nearer = depth / 2 if view is _VIEW_IN_SPACE else 0.0
    distance = 1.25 * max(height, width / ASPECT) / 2 / _HALF_VIEW + nearer
    x, y, z = distance * view
    camera = viewer["/Cameras/default/rotated/<object>"]
    camera.set_property("fov", _FIELD_OF_VIEW)
    camera.set_property("position", [x, z, -y])  # the frame of the camera has y up
    viewer["/Grid"].set_property("visible", False)
    viewer["/Axes"].set_property("visible", False)
    viewer["/Background"].set_property("top_color", [0.97, 0.98, 1.0])
    viewer["/Background"].set_property("bottom_color", [0.88, 0.90, 0.93])


def _animate(animation: ma.Animation, path: Path, clip: Clip, **tracks: NDArray[Any]) -> None:
    """Set key frames of properties: position and scale (F, 3), quaternion (F, 4) as x, y, z, w, visible (F,)."""
    kinds = {"position": "vector3", "scale": "vector3", "quaternion": "quaternion", "visible": "boolean"}
    animation.clips[path] = ma.AnimationClip({}, fps=clip.rate)
    for name, values in tracks.items():
        keys = _key_frames(values)
        animation.clips[path].tracks[name] = ma.AnimationTrack(name, kinds[name], keys.tolist(), values[keys].tolist())


def _key_frames(values: NDArray[Any]) -> NDArray[np.intp]:
    """Return the frames that must be given, as the viewer interpolates linearly: both ends, and frames with changes."""
    changes = np.abs(np.diff(values.reshape(len(values), -1).astype(float), axis=0)).max(axis=1) > STILL
    return np.flatnonzero(np.append(True, changes) | np.append(changes, True))


def _rod(start: Array, end: Array, radius: float) -> dict[str, Array]:
    """Return position, quaternion and scale that place a unit cylinder along y between points (F, 3)."""
    way = end - start
    length = np.maximum(np.linalg.norm(way, axis=1), 1e-9)
    x, y, z = (way / length[:, None]).T
    quaternion = np.stack([z, 0 * x, -x, 1 + y], axis=1)  # rotates y onto the axis; undefined for exactly -y
    quaternion[y < -1 + 1e-9] = [1.0, 0.0, 0.0, 0.0]
    quaternion /= np.linalg.norm(quaternion, axis=1)[:, None]
    thin = np.full_like(length, radius)
    return {"position": (start + end) / 2, "quaternion": quaternion, "scale": np.stack([thin, length, thin], axis=1)}


def _at_frames(frames: Array, time: Array, values: Array) -> Array:
    """Return values (F, n) of (T, n), interpolated linearly at the frames; NaN next to NaN."""
    return np.stack([np.interp(frames, time, column) for column in values.T], axis=-1)


def _front(run: Drawn) -> Array:
    if run.arm.bending == "space":
        return np.zeros(3)  # no offset, as the view may be from any side
    return np.array([0.0, -0.65 * run.arm.diameter, 0.0])


def _label_place(run: Drawn, low: Array, high: Array, height: float) -> Array:
    """Return a position for a label outside the motion of the arm: above it, or below an upright arm."""
    along = 0.5 * run.arm.length * mount_frame(run.arm.mount)[0][0]
    return np.array([along, 0.0, low[2] - 0.1 * height if run.arm.mount == "upright" else high[2] + 0.1 * height])


def _geometry(body: Body) -> Any:
    return mg.Sphere(body.radius) if body.height is None else mg.Cylinder(body.height, body.radius)


def _matrix(translation: Array, quaternion: Array) -> Array:
    matrix = mt.quaternion_matrix(np.roll(quaternion, 1))
    matrix[:3, 3] = translation
    return np.asarray(matrix)


def _upright_at(place: Array) -> Array:
    return np.asarray(mt.translation_matrix(place) @ mt.rotation_matrix(math.pi / 2, [1, 0, 0]))

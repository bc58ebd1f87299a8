"""Obstacles beside an arm: rigid bodies with a surface, fixed in the world."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from math import inf, pi
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from hsr_pin.errors import InputError, quoted
from hsr_pin.parameters import finite

#: Young's modulus [Pa], Hunt and Crossley's dissipation [s/m] and coefficient of friction of the softer of two surfaces, by
#: material; the arm is about twice as thick as its contact is wide. Typical values of data sheets, not of a particular product.
MATERIALS = {
    "foam": (1e5, 3.0, 0.6),
    "silicone": (1e6, 2.0, 0.8),
    "rubber": (5e6, 1.0, 0.9),
    "plastic": (1e9, 0.3, 0.3),
    "metal": (1e11, 0.1, 0.2),
}
#: Poisson's ratio of rubber, which hardly changes its volume.
_POISSON = 0.5


class Surface(NamedTuple):
    """The contact law of the arm with one obstacle.

    Attributes:
        stiffness: force per depth and per length of the arm in contact [N/m^2].
        dissipation: Hunt and Crossley's factor [s/m]: the force at a closing speed u is 1 + dissipation u times that at rest.
        friction: largest ratio of tangential and normal force.
    """

    stiffness: float
    dissipation: float
    friction: float

    @classmethod
    def of(cls, material: str) -> Surface:
        """Return the surface of a material in :data:`MATERIALS`, in contact with something harder.

        The stiffness is pi/4 E / (1 - nu^2): a cylinder that lies on a plane (V. L. Popov, Contact Mechanics and Friction,
        Springer 2010, chapter 5).

        Raises:
            InputError: the material is unknown; the message lists the known ones.
        """
        if material not in MATERIALS:
            raise InputError("material", expected=", ".join(MATERIALS), received=quoted(material))
        modulus, dissipation, friction = MATERIALS[material]
        return cls(pi / 4 * modulus / (1 - _POISSON**2), dissipation, friction)


#: The surface of a silicone arm on something hard.
SILICONE = Surface.of("silicone")
#: Number of entries of an obstacle in the arrays of the simulation; see :func:`row`.
ENTRIES = 19
#: Entries of the contact law.
STIFFNESS, DISSIPATION, FRICTION = 16, 17, 18
#: Kinds of shapes, as numbers in the arrays of the simulation.
HALF_SPACE, SPHERE, CYLINDER, BOX = range(4)


@dataclass(frozen=True)
class Obstacle(ABC):
    """A rigid body that an arm may touch; all positions and directions are in the world frame.

    Attributes:
        stiffness: force per depth and per length of the arm in contact [N/m^2].
        dissipation: Hunt and Crossley's factor [s/m].
        friction: largest ratio of tangential and normal force; 0: no friction.
    """

    stiffness: float = SILICONE.stiffness
    dissipation: float = SILICONE.dissipation
    friction: float = SILICONE.friction

    #: Word for this shape in a ``dataset.toml``.
    shape: ClassVar[str]

    def __post_init__(self) -> None:
        for name, expected in (("stiffness", "a number above zero [N/m^2]"), ("radius", "a number above zero [m]")):
            if hasattr(self, name) and finite(f"{name} of an obstacle", getattr(self, name), expected) <= 0:
                raise InputError(f"{name} of an obstacle", expected=expected, received=quoted(getattr(self, name)))
        for name in ("dissipation", "friction"):
            if finite(f"{name} of an obstacle", getattr(self, name), "zero or more") < 0:
                raise InputError(f"{name} of an obstacle", expected="zero or more", received=quoted(getattr(self, name)))
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type.startswith("tuple"):
                object.__setattr__(self, field.name, _vector(field.name, value))
        if hasattr(self, "length") and (not _is_number(self.length) or not self.length > 0):
            raise InputError("length of an obstacle", expected="a number above zero [m]", received=quoted(self.length))
        for name in ("normal", "axis"):
            if hasattr(self, name) and not np.any(getattr(self, name)):
                raise InputError(f"{name} of an obstacle", expected="a direction, not (0, 0, 0)", received="(0, 0, 0)")
        if hasattr(self, "size") and not min(self.size) > 0:
            raise InputError("size of an obstacle", expected="three numbers above zero [m]", received=quoted(self.size))

    @abstractmethod
    def row(self) -> NDArray[np.float64]:
        """Return this obstacle as a row (ENTRIES,) for the simulation."""

    def _row(self, kind: int, centre: Any, axes: Any, sizes: Any) -> NDArray[np.float64]:
        return row(kind, centre, axes, sizes, Surface(self.stiffness, self.dissipation, self.friction))


@dataclass(frozen=True)
class HalfSpace(Obstacle):
    """Everything behind a plane: a floor, a wall.

    Attributes:
        point: a point of the plane [m].
        normal: direction from the plane towards free space; its length does not matter.
    """

    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    normal: tuple[float, float, float] = (0.0, 0.0, 1.0)

    shape = "half_space"

    def row(self) -> NDArray[np.float64]:
        return self._row(HALF_SPACE, self.point, _axes(self.normal), (0.0, 0.0, 0.0))


@dataclass(frozen=True)
class Sphere(Obstacle):
    """A ball.

    Attributes:
        centre: its centre [m].
        radius: its radius [m].
    """

    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    radius: float = 0.01

    shape = "sphere"

    def row(self) -> NDArray[np.float64]:
        return self._row(SPHERE, self.centre, np.eye(3), (self.radius, 0.0, 0.0))


@dataclass(frozen=True)
class Cylinder(Obstacle):
    """A post or a rod, with flat ends.

    Attributes:
        centre: its centre [m].
        axis: its direction, across the plane of a planar arm by default; its length does not matter.
        radius: its radius [m].
        length: its length [m]; infinite by default.
    """

    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 1.0, 0.0)
    radius: float = 0.01
    length: float = inf

    shape = "cylinder"

    def row(self) -> NDArray[np.float64]:
        return self._row(CYLINDER, self.centre, _axes(self.axis), (self.radius, self.length / 2, 0.0))


@dataclass(frozen=True)
class Box(Obstacle):
    """A box.

    Attributes:
        centre: its centre [m].
        size: lengths of its edges [m].
        rotation: rotation vector from the axes of the world to its own [rad].
    """

    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)
    size: tuple[float, float, float] = (0.1, 0.1, 0.1)
    rotation: tuple[float, float, float] = (0.0, 0.0, 0.0)

    shape = "box"

    def row(self) -> NDArray[np.float64]:
        from scipy.spatial.transform import Rotation

        axes = Rotation.from_rotvec(self.rotation).as_matrix().T
        return self._row(BOX, self.centre, axes, np.array(self.size) / 2)


#: The shapes by their words in a ``dataset.toml``.
SHAPES: dict[str, type[Obstacle]] = {kind.shape: kind for kind in (HalfSpace, Sphere, Cylinder, Box)}


def to_dict(obstacle: Obstacle) -> dict[str, Any]:
    """Return an obstacle as the entries of a document; None for an infinite length."""
    values = {field.name: getattr(obstacle, field.name) for field in fields(obstacle)}
    plain = {name: list(v) if isinstance(v, tuple) else None if v == inf else float(v) for name, v in values.items()}
    return {"shape": obstacle.shape, **plain}


def from_dict(entries: Mapping[str, Any]) -> Obstacle:
    """Return the obstacle of :func:`to_dict`.

    Raises:
        InputError: the shape is unknown, an entry is none of the shape's, or a value is invalid.
    """
    values = {name: inf if value is None else value for name, value in entries.items() if name != "shape"}
    shape = entries.get("shape")
    if not isinstance(shape, str) or shape not in SHAPES:
        raise InputError("shape of an obstacle", expected=", ".join(SHAPES), received=quoted(shape))
    known = [field.name for field in fields(SHAPES[shape])]
    for name in values:
        if name not in known:
            raise InputError(f"obstacle of shape {shape}", expected=", ".join(known), received=quoted(name))
    return SHAPES[shape](**values)


def row(kind: int, centre: Any, axes: Any, sizes: Any, surface: Surface) -> NDArray[np.float64]:
    """Return an obstacle as a row (..., ENTRIES) for the simulation; the arguments broadcast.

    Args:
        kind: :data:`HALF_SPACE` (below the third axis), :data:`SPHERE`, :data:`CYLINDER` (along the third axis) or :data:`BOX`.
        centre: (..., 3) position [m].
        axes: (..., 3, 3) its axes, as rows.
        sizes: (..., 3) radius and half length, or half the edges [m].
        surface: the contact law.
    """
    axes = np.asarray(axes, dtype=float)
    parts = [np.asarray(centre, dtype=float), axes.reshape(*axes.shape[:-2], 9), np.asarray(sizes, dtype=float)]
    numbers = np.stack(np.broadcast_arrays(*surface), axis=-1).astype(float)
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in (*parts, numbers)))
    every = [np.full((*shape, 1), float(kind)), *(np.broadcast_to(p, (*shape, p.shape[-1])) for p in (*parts, numbers))]
    return np.concatenate(every, axis=-1)


def rows_in(frames: NDArray[np.float64], obstacles: Sequence[Obstacle]) -> NDArray[np.float64]:
    """Return obstacles (B, O, ENTRIES) in frames at the origin of the world, whose axes are the rows of ``frames`` (B, 3, 3)."""
    if not obstacles:
        return np.zeros((len(frames), 0, ENTRIES))
    every = np.array([obstacle.row() for obstacle in obstacles])
    out = np.repeat(every[None], len(frames), axis=0)
    out[..., 1:4] = np.einsum("bij,oj->boi", frames, every[:, 1:4])
    out[..., 4:13] = np.einsum("bij,okj->boki", frames, every[:, 4:13].reshape(-1, 3, 3)).reshape(*out.shape[:2], 9)
    return out


def _vector(name: str, value: Any) -> tuple[float, ...]:
    parts = list(value) if isinstance(value, list | tuple | np.ndarray) else []
    if len(parts) != 3 or not all(_is_number(part) and np.isfinite(part) for part in parts):
        raise InputError(f"{name} of an obstacle", expected="three finite numbers", received=quoted(value))
    return tuple(float(part) for part in parts)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)


def _axes(direction: Sequence[float]) -> NDArray[np.float64]:
    """Return orthonormal axes (3, 3), as rows, whose third one has the given direction."""
    third = np.array(direction) / np.linalg.norm(direction)
    first = np.cross(third, np.eye(3)[np.argmin(np.abs(third))])
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(third, first), third])

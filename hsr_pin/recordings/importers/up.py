"""Choice of the laboratory axis that points up, with the reason for the choice."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.trajectory import Array

#: Smallest cosine of the angle between the vertical and a hanging or upright arm at rest.
PLUMB = 0.9


@dataclass(frozen=True)
class Up:
    """Upward axis of the laboratory, and how it is known.

    Attributes:
        axis: axis that points up, such as ``"+z"``; None: unknown.
        reason: how the axis is known, or why it is unknown.
    """

    axis: str | None
    reason: str


def axis_vector(text: str, what: str = "axis") -> Array:
    """Return the unit vector (3,) of an axis such as ``"+z"``, ``"-y"`` or ``"x"``.

    Raises:
        InputError: the text does not name an axis.
    """
    sign, name = (text[0], text[1:]) if text[:1] in "+-" and text else ("+", text)
    if name.lower() not in ("x", "y", "z"):
        raise InputError(what, expected="an axis of the laboratory: +x, -x, +y, -y, +z or -z", received=repr(text))
    return np.asarray(np.eye(3)["xyz".index(name.lower())] * (-1.0 if sign == "-" else 1.0))


def choose_up(given: str | None, known: Up, direction: Callable[[], Array | None], mount: str | None) -> Up:
    """Return the axis that is up, and the reason.

    Args:
        given: axis given by the user, which takes precedence.
        known: axis according to the file.
        direction: function that returns the unit vector (3,) along the straight arm, or None.
        mount: mount given by the user; an arm that is "hanging" or "upright" at rest shows the vertical.

    Raises:
        InputError: the axis cannot be determined.
    """
    if given is not None:
        axis_vector(given, "up")
        return Up(given, "as given")
    if known.axis is not None:
        return known
    pointing = direction() if mount in ("hanging", "upright") else None
    if pointing is not None:
        upwards = pointing if mount == "upright" else -pointing
        index = int(np.argmax(np.abs(upwards)))
        if abs(upwards[index]) >= PLUMB:
            return Up(f"{'+' if upwards[index] > 0 else '-'}{'xyz'[index]}", f"from the arm, which is {mount} at rest")
    raise InputError(
        "up",
        expected="the axis of the laboratory that is up",
        received=f"none: {known.reason}",
        hint="give --up (+z, +y, ...), or --mount hanging or upright for an arm that is vertical at rest",
    )

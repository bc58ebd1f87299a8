"""Which axis of the laboratory points up: from what is certain, and never without a word."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hsr_pin.errors import InputError
from hsr_pin.trajectory import Array

#: An arm at rest that is said to hang or to stand is plumb within this angle's cosine.
PLUMB = 0.9


@dataclass(frozen=True)
class Up:
    """What a file tells about it.

    Attributes:
        axis: ``"+z"``; None: the file does not tell.
        why: how that is known, or why not.
    """

    axis: str | None
    why: str


def axis_vector(text: str, what: str = "axis") -> Array:
    """(3,) the unit vector of ``"+z"``, ``"-y"``, ``"x"``.

    Raises:
        InputError: anything else.
    """
    sign, name = (text[0], text[1:]) if text[:1] in "+-" and text else ("+", text)
    if name.lower() not in ("x", "y", "z"):
        raise InputError(what, expected="an axis of the laboratory: +x, -x, +y, -y, +z or -z", received=repr(text))
    return np.asarray(np.eye(3)["xyz".index(name.lower())] * (-1.0 if sign == "-" else 1.0))


def choose_up(told: str | None, known: Up, direction: Callable[[], Array | None], mount: str | None) -> Up:
    """The axis that is up, and why.

    Args:
        told: by the user, who is always right.
        known: by the file.
        direction: gives the (3,) unit vector in which the straight arm points, or None.
        mount: "hanging" or "upright", if the user says so: then gravity tells.

    Raises:
        InputError: none of them tells.
    """
    if told is not None:
        axis_vector(told, "up")
        return Up(told, "as told")
    if known.axis is not None:
        return known
    pointing = direction() if mount in ("hanging", "upright") else None
    if pointing is not None:
        upwards = pointing if mount == "upright" else -pointing
        index = int(np.argmax(np.abs(upwards)))
        if abs(upwards[index]) >= PLUMB:
            return Up(f"{'+' if upwards[index] > 0 else '-'}{'xyz'[index]}", f"as the arm is {mount} at rest")
    raise InputError(
        "up",
        expected="the axis of the laboratory that is up",
        received=f"none: {known.why}",
        hint="give --up (+z, +y, ...), or --mount hanging or upright for an arm that is plumb at rest",
    )

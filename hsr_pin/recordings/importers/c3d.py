"""C3D (https://www.c3d.org), the exchange format of motion capture, read with ezc3d."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.capture import Capture, capture, metres

#: Second byte of every file.
MAGIC = 0x50


def is_c3d(head: bytes) -> bool:
    """Whether the first bytes of a file look like this format."""
    return len(head) >= 2 and head[1] == MAGIC and 1 < head[0] < 128 and (b"\0" in head)


def read_c3d(path: Path, unit: str | None = None) -> Capture:
    """Read a file.

    Args:
        path: the file.
        unit: of length, in place of what the file says.

    Raises:
        RecordingError: the file cannot be read as C3D, holds no points, or gives no rate or unit.
    """
    import ezc3d

    try:
        content = ezc3d.c3d(str(path))
        points = np.array(content["data"]["points"][:3], dtype=float)  # (3, K, T)
        residuals = np.array(content["data"]["meta_points"]["residuals"], dtype=float).reshape(points.shape[1:])
        parameters = content["parameters"]["POINT"]
    except Exception as error:  # ezc3d raises whatever its C++ does
        raise RecordingError("not a C3D file that can be read", received=str(error)[:80], file=path) from error
    labels = [
        label for key in sorted(parameters, key=_order) if re.fullmatch(r"LABELS\d*", key) for label in parameters[key]["value"]
    ]
    labels += [f"point {index + 1}" for index in range(len(labels), points.shape[1])]
    rate = _first(parameters, "RATE")
    if not isinstance(rate, float) or not rate > 0:
        raise RecordingError("POINT:RATE", expected="a number of Hz", received=rate, file=path)
    said = unit or str(_first(parameters, "UNITS") or "")
    positions = points.transpose(2, 1, 0) * metres(said, None if unit else path)
    positions[(residuals.T < 0) | ~np.isfinite(positions).all(axis=2)] = np.nan
    screen = str(_first(parameters, "Y_SCREEN") or "").strip().lower()
    return capture(
        path,
        "C3D",
        np.arange(len(positions)) / rate,
        [str(label).strip() for label in labels[: points.shape[1]]],
        positions,
        up=screen if re.fullmatch(r"[+-][xyz]", screen) else "+z",
        notes=[f"imported from {path.name} (C3D, {said}, {rate:g} Hz)"],
    )


def _first(parameters: Any, key: str) -> Any:
    values = list(parameters[key]["value"]) if key in parameters else []
    return (values[0] if isinstance(values[0], str) else float(values[0])) if values else None


def _order(key: str) -> int:
    return int(re.sub(r"\D", "", key) or 0)

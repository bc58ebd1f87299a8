"""C3D (https://www.c3d.org), the exchange format of motion capture, read with ezc3d.

ezc3d is C++ and trusts its file: one with a broken byte can crash or hang it. It therefore runs in a process of its own.
"""

from __future__ import annotations

import io
import re
import subprocess
import sys
from pathlib import Path
from typing import Any, Literal

import numpy as np

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.capture import Capture, capture, metres

#: Second byte of every file.
MAGIC = 0x50
#: A file is made of blocks of so many bytes.
BLOCK = 512
#: What the fourth byte of the parameters says of a file whose numbers begin with their high byte.
BIG_ENDIAN = 86
#: Reading takes less than this, and this for each byte [s].
PATIENCE, PATIENCE_PER_BYTE = 30.0, 1e-6

_READER = """
import sys, numpy, ezc3d
content = ezc3d.c3d(sys.argv[1])
point = content["parameters"]["POINT"]
texts = {key: [str(value) for value in point[key]["value"]] for key in point
         if key.startswith("LABELS") or key in ("UNITS", "Y_SCREEN")}
numpy.savez(sys.stdout.buffer, points=content["data"]["points"][:3], rate=point["RATE"]["value"],
            residuals=content["data"]["meta_points"]["residuals"], **{key: numpy.array(texts[key], dtype=str) for key in texts})
"""


def is_c3d(head: bytes) -> bool:
    """Whether the first bytes of a file look like this format."""
    return len(head) >= 2 and head[1] == MAGIC and 1 < head[0] < 128 and b"\0" in head


def read_c3d(path: Path, unit: str | None = None) -> Capture:
    """Read a file.

    Args:
        path: the file.
        unit: of length, in place of what the file says.

    Raises:
        RecordingError: the file cannot be read as C3D, holds no points, or gives no rate or unit.
    """
    content = _content(path)
    points = content["points"].astype(float)  # (3, K, T)
    unseen = content["residuals"].reshape(points.shape[1:]).T < 0
    labels = [str(label) for key in sorted(content, key=_number) if key.startswith("LABELS") for label in content[key]]
    labels += [f"point {index + 1}" for index in range(len(labels), points.shape[1])]
    rate = float(content["rate"][0]) if len(content["rate"]) else 0.0
    if not (rate > 0 and np.isfinite(rate)):
        raise RecordingError("POINT:RATE", expected="a number of Hz", received=rate, file=path)
    said = unit or _text(content, "UNITS")
    positions = points.transpose(2, 1, 0) * metres(said, None if unit else path)
    positions[unseen | ~np.asarray(np.isfinite(positions).all(axis=2), dtype=bool)] = np.nan
    screen = _text(content, "Y_SCREEN").lower()
    return capture(
        path,
        "C3D",
        np.arange(len(positions)) / rate,
        [label.strip() for label in labels[: points.shape[1]]],
        positions,
        up=screen if re.fullmatch(r"[+-][xyz]", screen) else "+z",
        notes=[f"imported from {path.name} (C3D, {said}, {rate:g} Hz)"],
    )


def _content(path: Path) -> dict[str, Any]:
    """The points and their parameters, read in a process of its own."""
    data = path.read_bytes()
    parameters = (data[0] - 1) * BLOCK
    if len(data) < parameters + 4 or len(data) < parameters + data[parameters + 2] * BLOCK:
        raise RecordingError("not a C3D file that can be read", received="a file that is cut short", file=path)
    try:
        reader = subprocess.run(
            [sys.executable, "-c", _READER, str(path.resolve())],
            capture_output=True,
            timeout=PATIENCE + PATIENCE_PER_BYTE * len(data),
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise RecordingError("not a C3D file that can be read", received="no end to it", file=path) from None
    if reader.returncode != 0:
        said = reader.stderr.decode("utf-8", "replace").strip().split("\n")[-1][:120]
        raise RecordingError("not a C3D file that can be read", received=said or "a crash of the reader", file=path)
    with np.load(io.BytesIO(reader.stdout)) as archive:
        content = {key: archive[key] for key in archive.files}
    order: Literal["big", "little"] = "big" if data[parameters + 3] == BIG_ENDIAN else "little"
    first, last = (int.from_bytes(data[at : at + 2], order) for at in (6, 8))
    if content["points"].shape[2] < last - first + 1 and last < 0xFFFF:  # a longer recording says so elsewhere
        received = f"{content['points'].shape[2]} of {last - first + 1} frames"
        raise RecordingError("the file is cut short", expected="all frames", received=received, file=path)
    return content


def _text(content: dict[str, Any], key: str) -> str:
    return str(content[key][0]).strip() if key in content and len(content[key]) else ""


def _number(key: str) -> int:
    return int(re.sub(r"\D", "", key) or 0)

"""Which tracking system wrote a file, told from the file itself."""

from __future__ import annotations

from pathlib import Path

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.c3d import is_c3d, read_c3d
from hsr_pin.recordings.importers.capture import Capture
from hsr_pin.recordings.importers.optitrack import is_optitrack, read_optitrack
from hsr_pin.recordings.importers.vicon import is_vicon, read_vicon


def read_capture(path: str | Path, unit: str | None = None) -> Capture:
    """Read the file of any tracking system that is known.

    Args:
        path: the file.
        unit: of length, in place of what the file says.

    Raises:
        RecordingError: with file, line and column of the first fault.
        InputError: ``unit`` is not a unit of length.
    """
    path = Path(path)
    try:
        with path.open("rb") as file:
            head = file.read(4096)
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise RecordingError("cannot read the file", received=getattr(error, "strerror", None) or error, file=path) from error
    if is_c3d(head):
        return read_c3d(path, unit)
    text = head.decode("utf-8-sig", "replace")
    if is_optitrack(text):
        return read_optitrack(path, unit)
    if is_vicon(text):
        return read_vicon(path, unit)
    raise RecordingError(
        "format not recognised",
        expected="a CSV of Vicon Nexus or Tracker, a CSV of OptiTrack Motive, or C3D",
        received="an empty file" if not head.strip() else repr(text[:40]),
        file=path,
        line=1,
        column=1,
    )

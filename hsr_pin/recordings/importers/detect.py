"""Detection of the tracking system from the content of a file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.files import check_regular
from hsr_pin.recordings.importers.c3d import is_c3d, read_c3d
from hsr_pin.recordings.importers.capture import Capture
from hsr_pin.recordings.importers.command_rows import IN_PLANE, CommandRows, read_command_rows
from hsr_pin.recordings.importers.mapped import read_mapped, read_mapped_commands
from hsr_pin.recordings.importers.mapping import TableMapping
from hsr_pin.recordings.importers.optitrack import is_optitrack, read_optitrack
from hsr_pin.recordings.importers.optitrack_legacy import is_optitrack_legacy, read_optitrack_legacy
from hsr_pin.recordings.importers.plain import head_text
from hsr_pin.recordings.importers.qualisys import is_qualisys, read_qualisys
from hsr_pin.recordings.importers.rosbag import is_bag, read_bag
from hsr_pin.recordings.importers.rosbag_fields import read_bag_commands, read_mapped_bag
from hsr_pin.recordings.importers.trc import is_trc, read_trc
from hsr_pin.recordings.importers.vicon import is_vicon, read_vicon

#: Size of the beginning from which the format is determined [bytes].
HEAD = 8192
#: Given in place of a file of commands if there were none.
NOTHING = "-"

_TEXTS: tuple[tuple[Callable[[str], bool], Callable[[Path, str | None], Capture]], ...] = (
    (is_optitrack, read_optitrack),
    (is_optitrack_legacy, read_optitrack_legacy),
    (is_qualisys, read_qualisys),
    (is_trc, read_trc),
    (is_vicon, read_vicon),
)


def read_capture(path: str | Path, unit: str | None = None, mapping: TableMapping | None = None) -> Capture:
    """Read a capture of any known tracking system, or a table or bag with a mapping.

    Args:
        path: the file; a bag of ROS 2 may be a folder.
        unit: unit of length, in place of that in the file.
        mapping: meaning of the columns; a file is read as one of a known system if the mapping has no points.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
        InputError: ``unit`` is not a unit of length.
        MissingDependencyError: the file is a bag, and rosbags is not installed.
    """
    path = Path(path)
    head = _head(path)
    if mapping is not None and mapping.points:
        return read_mapped_bag(path, mapping, unit) if is_bag(path, head) else read_mapped(path, mapping, unit)
    if is_bag(path, head):
        return read_bag(path, unit)
    if path.is_dir():
        expected = "a file, or the folder of a ROS 2 bag with its metadata.yaml"
        raise RecordingError("cannot read the file", expected=expected, received="a folder", file=path)
    if is_c3d(head):
        return read_c3d(path, unit)
    text = head_text(head)
    for is_one, read in _TEXTS:
        if is_one(text):
            return read(path, unit)
    raise RecordingError(
        "format not recognised",
        expected="CSV of Vicon or OptiTrack, TSV of Qualisys, TRC, C3D, or a ROS bag",
        received="an empty file" if not head.strip() else repr(text[:40]) if text[:40].isascii() else "another file",
        hint="other tables need a mapping (--map); hsr-import --guess FILE writes a draft",
        file=path,
        line=1,
        column=1,
    )


def read_commands_of(
    recording: Capture, path: str | Path | None, mapping: TableMapping | None, inputs: Sequence[tuple[str, ...]] = IN_PLANE
) -> CommandRows | None:
    """Return the input of a recording from its own file or, by a mapping, from the recording's file; None without an input.

    Args:
        recording: recording whose clock the times refer to.
        path: file of the input; None: no separate file; ``-``: no input.
        mapping: columns of the input in a table or a bag.
        inputs: without a mapping, the accepted sets of columns in addition to ``t``; empty: any columns.

    Raises:
        RecordingError: the file is invalid; the error names file, line and column of the first fault.
        MissingDependencyError: the file is a bag, and rosbags is not installed.
    """
    wanted = None if mapping is None else mapping.input
    if mapping is None or wanted is None:
        return None if path in (None, NOTHING) else read_command_rows(path, inputs)
    if path == NOTHING:
        return None
    source = recording.path if path is None else Path(path)
    if path is None and not mapping.points and not is_bag(source, _head(source)):
        columns, hint = ", ".join(str(column) for _, column in wanted.columns), f"give --input {NOTHING} if there was none"
        raise RecordingError(
            "no commands", expected=f"--input FILE with {columns}", received="none", hint=hint, file=recording.path
        )
    if is_bag(source, _head(source)):
        return read_bag_commands(source, wanted, recording)
    return read_mapped_commands(source, mapping, wanted, recording)


def _head(path: Path) -> bytes:
    try:
        if path.is_dir():
            return b""
        check_regular(path, None)
        with path.open("rb") as file:
            return file.read(HEAD)
    except RecordingError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise RecordingError("cannot read the file", received=getattr(error, "strerror", None) or error, file=path) from error

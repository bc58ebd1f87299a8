"""Safe access to input files: only regular files of limited size, inside their folder."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from hsr_pin.errors import RecordingError

#: Largest table or capture that is read [bytes].
LARGEST = 2_000_000_000
#: Largest declaration or mapping [bytes], enough for 50,000 trials.
LARGEST_DOCUMENT = 8_000_000
#: Largest result, report or score of hsr_pin that is read back [bytes].
LARGEST_RESULT = 100_000_000

_KINDS = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))


def read_bytes(path: Path, largest: int = LARGEST) -> bytes:
    """Return the content of a regular file.

    Raises:
        RecordingError: the file does not exist, is a pipe or a device (which may be endless), or exceeds ``largest`` bytes.
    """
    try:
        size = check_regular(path, largest)
        with path.open("rb") as file:
            data = file.read(size + 1)
    except RecordingError:
        raise
    except (OSError, ValueError) as error:  # ValueError: a null byte in the name
        raise RecordingError("cannot read the file", received=getattr(error, "strerror", None) or error, file=path) from error
    if len(data) > size:
        raise RecordingError("the file grows while it is read", hint="wait until it is complete", file=path)
    return data


def check_regular(path: Path, largest: int | None = LARGEST) -> int:
    """Return the size of a regular file [bytes] without opening it; refuse other kinds of file and too large ones.

    Raises:
        RecordingError: the path is not a regular file, or the file is too large.
        OSError: the file does not exist or is not accessible.
    """
    found = path.stat()
    if not stat.S_ISREG(found.st_mode):
        kind = next((name for is_kind, name in _KINDS if is_kind(found.st_mode)), "a device")
        raise RecordingError("cannot read the file", expected="a regular file", received=kind, hint="copy the data", file=path)
    if largest is not None and found.st_size > largest:
        most, size = (f"{number / 1e6:,.0f} MB" for number in (largest, found.st_size))
        hint = "split it, or export fewer frames" if largest == LARGEST else "check that this is the intended file"
        raise RecordingError("the file is too large", expected=f"at most {most}", received=size, hint=hint, file=path)
    return found.st_size


def is_inside(path: Path, folder: Path) -> bool:
    """Return whether a path is inside a folder after all symbolic links are resolved."""
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))

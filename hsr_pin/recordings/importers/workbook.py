"""Reader of the worksheets of Excel workbooks (``.xlsx``, ``.xlsm``) with openpyxl (dependency group ``import``)."""

from __future__ import annotations

import contextlib
import datetime
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from hsr_pin.errors import HsrError, MissingDependencyError, RecordingError
from hsr_pin.recordings.files import check_regular
from hsr_pin.recordings.text import nearest

#: File inside the archive that makes it a workbook.
_WORKBOOK = "xl/workbook.xml"
_EPOCH = datetime.datetime(1970, 1, 1)


def is_workbook(path: Path) -> bool:
    """Return whether a file is an Excel workbook, by its content; the older ``.xls`` is one by its suffix."""
    if path.suffix.lower() == ".xls":
        return True
    try:
        check_regular(path)
        with zipfile.ZipFile(path) as archive:
            return _WORKBOOK in archive.namelist()
    except (OSError, ValueError, zipfile.BadZipFile, RecordingError):  # the reader of the text reports it
        return path.suffix.lower() in (".xlsx", ".xlsm") and path.is_file()


def read_workbook(path: Path, worksheet: str | None = None) -> Iterator[list[str]]:
    """Yield the rows of a worksheet as texts; a date becomes seconds since 1970, a time of day or a duration seconds.

    Args:
        path: the workbook.
        worksheet: name of the worksheet; None: the first one.

    Raises:
        RecordingError: the file is damaged, has no such worksheet, or contains formulas without their values.
        MissingDependencyError: openpyxl is not installed.
    """
    try:
        import openpyxl
    except ImportError as error:
        raise MissingDependencyError("openpyxl, which reads Excel workbooks,", "import") from error
    try:
        with contextlib.closing(openpyxl.load_workbook(path, read_only=True, data_only=True)) as book:
            names = [sheet.title for sheet in book.worksheets]
            if worksheet is not None and worksheet not in names:
                expected, hint = "a worksheet of the workbook", nearest(worksheet, names, "worksheets")
                raise RecordingError("[file] sheet", expected=expected, received=repr(worksheet), hint=hint, file=path)
            sheet = book[names[0] if worksheet is None else worksheet]
            sheet.reset_dimensions()  # some programs state wrong ones
            for row in sheet.iter_rows(min_row=1, min_col=1, values_only=True):
                yield [_text(value) for value in row]
    except HsrError:
        raise
    except Exception as error:  # openpyxl raises many kinds of errors for a damaged file
        received = f"{type(error).__name__}: {error}"[:160]
        hint = "save it as .xlsx, or as CSV"
        raise RecordingError("the workbook cannot be read", received=received, hint=hint, file=path) from error


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, datetime.datetime):
        return repr((value - _EPOCH).total_seconds())
    if isinstance(value, datetime.date):
        return repr((datetime.datetime(value.year, value.month, value.day) - _EPOCH).total_seconds())
    if isinstance(value, datetime.time):
        return repr((datetime.datetime.combine(_EPOCH, value) - _EPOCH).total_seconds())
    if isinstance(value, datetime.timedelta):
        return repr(value.total_seconds())
    return repr(value) if isinstance(value, float) else str(value)

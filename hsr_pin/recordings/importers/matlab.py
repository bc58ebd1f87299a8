"""Reader of MATLAB files (``.mat``): the numeric arrays in them as the columns of one table.

A column is named as in MATLAB: ``P`` is a vector, ``P(:,2)`` is the second column of a matrix, ``log.P(:,2)`` the same in a field
of a struct, ``run(3).t`` in an element of a struct array, and ``run{3}`` an element of a cell array. Time runs along the longest
side of an array. Shorter columns are followed by empty cells.

Files of versions 4 to 7 are read with SciPy, files of version 7.3, which are HDF5, with h5py (dependency group ``import``).
Objects, such as tables, timetables and time series, have no documented format and are not read.
"""

from __future__ import annotations

import itertools
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.errors import MissingDependencyError, RecordingError
from hsr_pin.recordings.files import check_regular
from hsr_pin.trajectory import Array

#: Beginnings of files that are HDF5, of other files with a header, and of a text file that Octave calls ``.mat`` too.
_HDF5, _HEADER, _OCTAVE = b"MATLAB 7.3 MAT-file", b"MATLAB 5.0 MAT-file", b"# Created by Octave"
#: Largest number of columns of one array; more are those of an image.
_MOST_COLUMNS = 1000
_SAVE = "in MATLAB or Octave: save -v7 FILE.mat"


def is_matlab(path: Path) -> bool:
    """Return whether a file is one of MATLAB, by its content or its suffix."""
    return (path.suffix.lower() == ".mat" and path.is_file()) or _head(path).startswith((_HDF5, _HEADER))


def read_matlab(path: Path) -> Iterator[list[str]]:
    """Yield the names of the columns in a MATLAB file, and then its rows.

    Raises:
        RecordingError: the file is damaged, or contains no numeric array.
        MissingDependencyError: the file is of version 7.3, and h5py is not installed.
    """
    head = _head(path)
    if head.startswith(_OCTAVE):
        raise RecordingError("MATLAB file", expected="a binary file", received="a text file of Octave", hint=_SAVE, file=path)
    variables, objects = _read_hdf5(path) if head.startswith(_HDF5) else _read_scipy(path)
    columns = dict(column for name, value in variables.items() for column in _columns(value, name))
    if not columns:
        hint = "in MATLAB write a table or timetable with writetable(T, 'log.csv') or writetimetable(T, 'log.csv')"
        received = f"objects ({', '.join(objects)})" if objects else ", ".join(variables) or "none"
        expected = "variables that are arrays of numbers, structs or cells"
        raise RecordingError("MATLAB file", expected=expected, received=received, hint=hint if objects else "", file=path)
    yield list(columns)
    for row in itertools.zip_longest(*(column.tolist() for column in columns.values())):
        yield ["" if value is None or value != value else repr(value) for value in row]


def _head(path: Path) -> bytes:
    try:
        check_regular(path)
        with path.open("rb") as file:
            return file.read(len(_HEADER))
    except (OSError, ValueError):  # the reader of the text reports it
        return b""


def _read_scipy(path: Path) -> tuple[dict[str, Any], list[str]]:
    """Return the variables of a file of version 4 to 7, and the names of those that are objects."""
    from scipy.io import loadmat, matlab

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of names that occur twice, which are those of objects
            found = loadmat(path, simplify_cells=True)
    except Exception as error:  # SciPy raises many kinds of errors for a damaged file
        raise _damaged(path, error) from error
    opaque = {name for name, value in found.items() if isinstance(value, matlab.MatlabOpaque)}
    names = {name: value for name, value in found.items() if not name.startswith("__") and name not in opaque}
    return names, sorted("a table, timetable or the like" if name == "None" else name for name in opaque)


def _read_hdf5(path: Path) -> tuple[dict[str, Any], list[str]]:
    """Return the variables of a file of version 7.3, and the names of those that are objects."""
    try:
        import h5py
    except ImportError as error:
        raise MissingDependencyError("h5py, which reads MATLAB files of version 7.3,", "import") from error
    objects: list[str] = []

    def value(node: Any) -> Any:
        kind = node.attrs.get("MATLAB_class", b"").decode()
        if "MATLAB_object_decode" in node.attrs or "MATLAB_empty" in node.attrs or kind in ("char", "function_handle"):
            if "MATLAB_object_decode" in node.attrs:
                objects.append(node.name.strip("/"))
            return None
        if not isinstance(node, h5py.Dataset):
            fields = {name: value(child) for name, child in node.items()}
            if any(isinstance(child, h5py.Dataset) and _is_element(child) for child in node.values()):  # of a struct array
                count = max(len(field) for field in fields.values() if isinstance(field, tuple))
                return [{name: field[i] for name, field in fields.items() if isinstance(field, tuple)} for i in range(count)]
            return fields
        if node.dtype == h5py.ref_dtype:
            return tuple(value(node.file[reference]) for reference in np.ravel(node[()], order="F"))
        return np.squeeze(np.asarray(node[()]).T)

    def _is_element(node: Any) -> bool:
        return bool(node.dtype == h5py.ref_dtype and "MATLAB_class" not in node.attrs)

    try:
        with h5py.File(path, "r") as file:
            return {name: value(node) for name, node in file.items() if not name.startswith("#")}, objects
    except Exception as error:  # h5py raises many kinds of errors for a damaged file
        raise _damaged(path, error) from error


def _damaged(path: Path, error: Exception) -> RecordingError:
    received = f"{type(error).__name__}: {error}"[:160]
    return RecordingError("the MATLAB file cannot be read", received=received, hint=f"save it again; {_SAVE}", file=path)


def _columns(value: Any, name: str) -> Iterator[tuple[str, Array]]:
    """Yield the name and numbers (T,) of each column in a variable: array, struct (dict), struct array (list) or cell array."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _columns(inner, f"{name}.{key}")
    elif isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.dtype == object):
        left, right = "()" if isinstance(value, list) else "{}"
        for number, inner in enumerate(np.ravel(value, order="F") if isinstance(value, np.ndarray) else value, start=1):
            yield from _columns(inner, f"{name}{left}{number}{right}")
    elif isinstance(value, np.ndarray) and value.dtype.kind in "biuf" and value.size > 1:
        along = int(np.argmax(value.shape))
        rows = np.moveaxis(value, along, 0)
        if rows[0].size > _MOST_COLUMNS:
            return
        for place in np.ndindex(rows.shape[1:]):
            index = [str(i + 1) for i in place]
            index.insert(along, ":")
            yield (f"{name}({','.join(index)})" if place else name), np.asarray(rows[(slice(None), *place)], dtype=float)

"""Reader of the parameter section of C3D files (https://www.c3d.org/HTML) in the byte order of any processor."""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Size of the blocks of a file [bytes].
BLOCK = 512
#: Processor types Intel, DEC and MIPS (SGI), the fourth byte of the parameter section.
INTEL, DEC, MIPS = 84, 85, 86

_TYPES = {-1: "S1", 1: "u1", 2: "i2", 4: "f4"}


@dataclass(frozen=True, eq=False)
class Parameters:
    """Parameters of a C3D file.

    Attributes:
        processor: type of the processor that wrote the file.
        groups: values by group and parameter, with names in capitals: texts as a list, numbers as an array.
    """

    processor: int
    groups: Mapping[str, Mapping[str, Any]]

    @property
    def order(self) -> str:
        """Byte order of the file: ``"<"`` or ``">"``."""
        return ">" if self.processor == MIPS else "<"

    def texts(self, group: str, name: str) -> list[str]:
        """Return a text parameter with its continuations (``LABELS``, ``LABELS2``, ...), stripped."""
        there = self.groups.get(group, {})
        keys = sorted((key for key in there if key.rstrip("0123456789") == name), key=lambda key: int(key[len(name) :] or 1))
        return [text for key in keys if isinstance(there[key], list) for text in there[key]]

    def number(self, group: str, name: str) -> float | None:
        """Return the first number of a parameter; None if there is none."""
        values = self.groups.get(group, {}).get(name)
        if isinstance(values, np.ndarray) and values.size:
            return float(values.flat[0])
        return None

    def words(self, group: str, name: str) -> list[int]:
        """Return a parameter of unsigned 16-bit words; empty if there is none."""
        values = self.groups.get(group, {}).get(name)
        return [int(value) & 0xFFFF for value in values.flat] if isinstance(values, np.ndarray) else []


def floats(data: bytes, processor: int) -> NDArray[np.float32]:
    """Return 32-bit floats as stored by a processor; DEC floats have swapped halves and four times the value of Intel floats."""
    with np.errstate(invalid="ignore"):  # damaged files may contain invalid numbers
        if processor == DEC:
            halves = np.frombuffer(data, "<u2").reshape(-1, 2)[:, ::-1]
            return np.asarray(np.ascontiguousarray(halves).view("<f4").ravel() / np.float32(4))
        return np.frombuffer(data, ">f4" if processor == MIPS else "<f4").astype(np.float32)


def read_parameters(data: bytes) -> Parameters:
    """Return the parameters in the bytes of a file.

    Raises:
        ValueError: the parameters are damaged or truncated; the message names the position.
    """
    start = (data[0] - 1) * BLOCK
    if len(data) < start + 4:
        raise ValueError("the file ends before its parameters")
    processor = data[start + 3]
    if processor not in (INTEL, DEC, MIPS):
        raise ValueError(f"unknown processor {processor} in byte {start + 4}")
    order = ">" if processor == MIPS else "<"
    named: dict[int, str] = {}
    values: dict[int, dict[str, Any]] = {}
    (first,) = struct.unpack_from(f"{order}H", data, 16)
    end = min(len(data), max(start + data[start + 2] * BLOCK, (first - 1) * BLOCK))
    at = start + 4
    while at + 2 <= end and data[at] != 0:
        length, group = abs(struct.unpack_from("b", data, at)[0]), struct.unpack_from("b", data, at + 1)[0]
        if group == 0:
            break
        name = data[at + 2 : at + 2 + length].decode("ascii", "replace").strip().upper()
        at += 2 + length
        if at + 2 > len(data):
            raise ValueError("the file ends within its parameters")
        (offset,) = struct.unpack_from(f"{order}H", data, at)
        if group < 0:
            named.setdefault(-group, name)
        else:
            values.setdefault(group, {}).setdefault(name, _value(data, at + 2, processor))
        if offset == 0:
            break
        at += offset
    return Parameters(processor, {name: values.get(number, {}) for number, name in named.items()})


def _value(data: bytes, at: int, processor: int) -> Any:
    """Return the value at a position, stored as type, number of dimensions, dimensions and data."""
    if at + 2 > len(data):
        raise ValueError("the file ends within its parameters")
    kind, dimensions = struct.unpack_from("b", data, at)[0], data[at + 1]
    sizes = list(data[at + 2 : at + 2 + dimensions])
    if kind not in _TYPES or len(sizes) != dimensions:
        raise ValueError(f"no parameter begins at byte {at + 1}")
    first, count = at + 2 + dimensions, int(np.prod(sizes, dtype=np.int64))
    raw = data[first : first + count * abs(kind)]
    if len(raw) != count * abs(kind):
        raise ValueError("the file ends within its parameters")
    if kind == -1:
        width = sizes[0] if sizes else 1
        pieces = [raw[start : start + width] for start in range(0, len(raw), width)] if width else []
        return [piece.split(b"\0", 1)[0].decode("utf-8", "replace").strip() for piece in pieces]
    if kind == 4:
        return floats(raw, processor)
    return np.frombuffer(raw, ("u1" if kind == 1 else f"{'>' if processor == MIPS else '<'}i2"))

"""Files of laboratories are read as an independent parse reads them, or refused with what to do.

They are those of the folder that the environment variable HSR_PIN_CAPTURES names. A table of no known system is read where a
mapping stands beside it (``run.csv`` and ``run.map.toml``).
"""

import csv
import os
import struct
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.errors import HsrError
from hsr_pin.recordings.importers.detect import read_capture
from hsr_pin.recordings.importers.mapping import read_mapping

VARIABLE = "HSR_PIN_CAPTURES"
KINDS = (".c3d", ".trc", ".tsv", ".csv", ".bag", ".mcap", ".db3")
METRES = {"m": 1.0, "mete": 1.0, "meters": 1.0, "mm": 1e-3, "millimeters": 1e-3, "cm": 1e-2, "centimeters": 1e-2}


def files():
    folder = os.environ.get(VARIABLE)
    return [] if folder is None else sorted(path for path in Path(folder).rglob("*") if path.suffix.lower() in KINDS)


def numbers(fields):
    out = []
    for field in fields:
        try:
            out.append(float(field))
        except ValueError:
            out.append(np.nan)
    return out


def padded(rows):
    width = max(map(len, rows))
    return np.array([row + [np.nan] * (width - len(row)) for row in rows])


def c3d(path):
    """By ezc3d; by the header alone where ezc3d fails, or reads garbage (steps ten times as long)."""
    data = path.read_bytes()
    processor = data[(data[0] - 1) * 512 + 3]
    order = ">" if processor == 86 else "<"
    points, analog, first, last = struct.unpack_from(f"{order}4H", data, 2)
    (scale,), (block,) = struct.unpack_from(f"{order}f", data, 12), struct.unpack_from(f"{order}H", data, 16)
    kind, count = f"{order}f4" if scale < 0 else f"{order}i2", last - first + 1
    plain, theirs = None, None
    if processor != 85:
        flat = np.frombuffer(data, kind, offset=(block - 1) * 512)[: count * (4 * points + analog)]
        quads = flat.reshape(-1, 4 * points + analog)[:, : 4 * points].reshape(-1, points, 4).astype(float)
        plain = np.where(quads[:, :, 3:] < 0, np.nan, quads[:, :, :3] * (1 if scale < 0 else scale))
    try:
        import ezc3d

        content = ezc3d.c3d(str(path))["data"]
        theirs = content["points"][:3].transpose(2, 1, 0)
        theirs = np.where((content["meta_points"]["residuals"][0].T < 0)[:, :, None], np.nan, theirs)
    except (OSError, ValueError, RuntimeError, IndexError):
        pass  # what it cannot read, the header tells
    if plain is not None and (theirs is None or theirs.size == 0 or typical(theirs) > 10 * typical(plain) > 0):
        return plain
    return theirs


def typical(positions):
    return np.nanmedian(np.linalg.norm(np.diff(positions, axis=0), axis=2))


def text(path):
    return path.read_bytes().decode("utf-8-sig", "replace").replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")


def trc(path):
    lines = text(path)
    top = next(n for n, line in enumerate(lines) if line.lower().startswith("frame"))
    names = [name for name in lines[top].split("\t")[2:] if name.strip()]
    body = padded([numbers(line.split("\t")) for line in lines[top + 1 :] if line.split("\t")[0].strip().isdigit()])
    return body[:, 2 : 2 + 3 * len(names)].reshape(len(body), len(names), 3)


def qualisys(path):
    lines = text(path)
    top = next(n for n, line in enumerate(lines) if line.startswith(("MARKER_NAMES", "BODY_NAMES")))
    names = [name for name in lines[top].split("\t")[1:] if name]
    width = 3 if lines[top].startswith("M") else 16
    body = padded([numbers(line.split("\t")) for line in lines[top + 1 :] if numbers(line.split("\t")[:1])[0] > -1e9])
    lead = 2 if any(line.startswith("Frame\tTime") for line in lines[top : top + 3]) else 0
    return np.stack([body[:, lead + width * n : lead + width * n + 3] for n in range(len(names))], axis=1)


def vicon(path):
    rows = list(csv.reader(text(path)))
    top = next(n for n, row in enumerate(rows) if row and row[0].strip().lower() in ("trajectories", "markers", "objects"))
    axes = next(n for n in range(top, len(rows)) if rows[n] and rows[n][0] in ("Frame", "Field #"))
    starts = [n for n, name in enumerate(rows[axes]) if name.upper() in ("X", "TX")]
    body = []
    for row in rows[axes + 1 :]:
        if row and row[0].isdigit():
            body.append(numbers(row))
        elif body:
            break
    body = padded(body)
    return np.stack([body[:, n : n + 3] for n in starts], axis=1)


def motive(path):
    rows = list(csv.reader(text(path)))
    top = next(n for n, row in enumerate(rows) if row and row[0] == "Frame")
    starts = [n for n, kind in enumerate(rows[top - 1]) if kind == "Position" and rows[top][n] == "X"]
    body = padded([numbers(row) for row in rows[top + 1 :] if row])
    return np.stack([body[:, n : n + 3] for n in starts], axis=1)


def legacy(path):
    """Of the first body of the file: where its frames have it."""
    rows = [row for row in csv.reader(text(path)) if row[0] == "frame"]
    found = np.full((len(rows), 1, 3), np.nan)
    wanted = next(row[4] for row in rows if int(row[3]))
    for n, row in enumerate(rows):
        for start in range(4, 4 + 11 * int(row[3]), 11):
            if row[start] == wanted:
                found[n, 0] = numbers(row[start + 1 : start + 4])
    return found


def mapped(path, mapping):
    lines = list(csv.reader(text(path)))
    names = [name.lstrip("# ").strip() for name in lines[0]]
    wanted = [
        [place.column - 1 if isinstance(place.column, int) else names.index(place.column) for place in triple]
        for _, triple in mapping.points
    ]
    body = padded([numbers(row) for row in lines if row and numbers(row[:1])[0] > -1e30])
    return np.stack([body[:, columns] for columns in wanted], axis=1)


def bag(path):
    """The topic of poses with the most messages."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_FOXY)) as reader:
        posed = [one for one in reader.connections if "Pose" in one.msgtype or "Odom" in one.msgtype]
        moving = posed or [one for one in reader.connections if "TFM" in one.msgtype and "static" not in one.topic]
        topic = max(moving, key=lambda one: one.msgcount)
        places = []
        for one, _, raw in reader.messages(connections=[topic]):
            message = reader.deserialize(raw, one.msgtype)
            if "TFM" in one.msgtype:
                place = message.transforms[0].transform.translation
            else:
                place = message.pose.position if hasattr(message.pose, "position") else message.pose.pose.position
            places.append((place.x, place.y, place.z))
    return np.array(places)[:, None]


def independent(path, capture, mapping):
    """(T, K, 3) [as the file has it]."""
    if mapping is not None:
        return mapped(path, mapping)
    for system, parse in (("C3D", c3d), ("TRC", trc), ("Qualisys", qualisys), ("Vicon", vicon), ("ROS", bag)):
        if capture.system.startswith(system):
            return parse(path)
    return motive(path) if text(path)[0].startswith("Format") else legacy(path)


@pytest.mark.parametrize("path", files() or [None], ids=lambda path: "none" if path is None else path.name)
def test_a_file_of_a_laboratory_is_read_right_or_refused_with_what_to_do(path):
    if path is None:
        pytest.skip(f"needs a folder of captures in the environment variable {VARIABLE}, which is not set")
    beside = path.with_suffix(".map.toml")
    mapping = read_mapping(beside) if beside.exists() else None
    for unit in (None, "mm"):
        try:
            capture = read_capture(path, unit, mapping)
            break
        except HsrError as error:
            assert getattr(error, "hint", "") or getattr(error, "expected", ""), f"says nothing of what to do: {error}"
            assert str(error).isprintable()
            if unit or "--unit" not in str(error):
                return
    theirs = independent(path, capture, mapping)
    theirs = np.where((theirs == 0).all(axis=2, keepdims=True), np.nan, theirs) * METRES[capture.unit.lower()]
    theirs = np.where(np.isnan(theirs).any(axis=2, keepdims=True), np.nan, theirs)
    assert len(theirs) == len(capture.positions) or capture.system == "ROS bag"
    matched = sum(any(agree(one, other) for other in capture.positions.swapaxes(0, 1)) for one in theirs.swapaxes(0, 1))
    lacking = sum("left out" in note for note in capture.notes) * (theirs.shape[1] - len(capture.names))
    assert matched >= theirs.shape[1] - lacking


def agree(one, other):
    """Whether two tracks are the same to a micrometre, with the same gaps (of a bag, to some samples in a hundred)."""
    if len(one) != len(other):
        return np.isin(np.round(one[np.isfinite(one)], 6), np.round(other[np.isfinite(other)], 6)).mean() > 0.97
    gaps = np.isnan(one) == np.isnan(other)
    return bool(gaps.all() and (np.nanmax(np.abs(one - other), initial=0) < 1e-6 or np.isnan(one).all()))

"""Files of laboratories are read as an independent parse reads them, or refused with what to do.

They are those of the folder that the environment variable HSR_PIN_CAPTURES names. A table or bag of no known system is read
where a mapping stands beside it (``run.csv`` and ``run.map.toml``). Refused ones are skipped, and ``pytest -rs`` says why.
"""

import os
import time
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.errors import HsrError
from hsr_pin.recordings.importers.detect import read_capture
from hsr_pin.recordings.importers.mapping import read_mapping

from . import independent as parse

VARIABLE = "HSR_PIN_CAPTURES"
KINDS = (".c3d", ".trc", ".tsv", ".csv", ".txt", ".bag", ".mcap", ".db3")
METRES = {"m": 1.0, "mete": 1.0, "meters": 1.0, "mm": 1e-3, "millimeters": 1e-3, "cm": 1e-2, "centimeters": 1e-2}
#: A reader may take so long for a megabyte, and for a file [s].
PATIENCE = 2.0
#: Times may be printed in milliseconds.
ROUNDED = 1.1e-3


def files():
    folder = os.environ.get(VARIABLE)
    return [] if folder is None else sorted(path for path in Path(folder).rglob("*") if path.suffix.lower() in KINDS)


def independent(path, capture, mapping):
    for system, read in (("C3D", parse.c3d), ("TRC", parse.trc), ("Qualisys", parse.qualisys), ("Vicon", parse.vicon)):
        if capture.system.startswith(system):
            return read(path)
    if capture.system == "ROS bag":
        return parse.bag(path, mapping, (round(capture.start * 1e9), capture.time))
    if mapping is not None:
        return parse.mapped(path, mapping)
    return parse.motive(path) if parse.text(path)[0].startswith("Format") else parse.legacy(path)


def compare(path, capture, mapping):
    """Whether an independent parse has the same names, positions to a micrometre, gaps and times."""
    names, theirs, stamps = independent(path, capture, mapping)
    factor = METRES.get(capture.unit.lower()) or float(capture.unit.split()[0])
    theirs = np.where((theirs == 0).all(axis=2, keepdims=True), np.nan, theirs) * factor
    theirs = np.where(np.isnan(theirs).any(axis=2, keepdims=True), np.nan, theirs)
    assert len(theirs) == len(capture.positions)
    tracks = list(zip(names or [None] * theirs.shape[1], theirs.swapaxes(0, 1), strict=True))
    ours = list(zip(capture.names, capture.positions.swapaxes(0, 1), strict=True))
    loose = capture.system == "ROS bag"
    for name, one in ours if names else ():
        assert any(same_name(name, other) and agree(one, track, loose) for other, track in tracks), name
    matched = sum(any(agree(one, track, loose) for _, one in ours) for _, track in tracks)
    lacking = sum("left out" in note for note in capture.notes) * (len(tracks) - len(ours))
    assert matched >= len(tracks) - lacking
    if stamps is not None:
        assert np.abs(capture.time - (stamps - stamps[0])).max() < ROUNDED


def same_name(name, other):
    return name == other or name.split(" #")[0].split(" (")[0] == other


def agree(one, other, loose):
    """Whether two tracks are the same to a micrometre, with the same gaps (of a bag: where ours has none)."""
    both = np.isfinite(one) & np.isfinite(other)
    gaps = both if loose else np.isnan(one) == np.isnan(other)
    return bool(both.any() or np.isnan(one).all()) and bool(gaps.any() if loose else gaps.all()) and close(one, other, both)


def close(one, other, both):
    return bool((np.abs(one[both] - other[both]) < 1e-6).all())


@pytest.mark.parametrize("path", files() or [None], ids=lambda path: "none" if path is None else path.name)
def test_a_file_of_a_laboratory_is_read_right_or_refused_with_what_to_do(path):
    if path is None:
        pytest.skip(f"needs a folder of captures in the environment variable {VARIABLE}, which is not set")
    beside = path.with_suffix(".map.toml")
    mapping = read_mapping(beside) if beside.exists() else None
    began = time.process_time()
    for unit in (None, "mm"):
        try:
            capture = read_capture(path, unit, mapping)
            break
        except HsrError as error:
            assert getattr(error, "hint", ""), f"says nothing of what to do: {error}"
            assert str(error).isprintable()
            if unit or "--unit" not in str(error):
                pytest.skip(f"refused: {error}")
    assert time.process_time() - began < PATIENCE * (1 + path.stat().st_size / 1e6)
    compare(path, capture, mapping)

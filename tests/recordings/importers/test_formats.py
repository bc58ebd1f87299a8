"""Each tracking system's file gives back the points that were written into it."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hsr_pin.errors import HsrError, InputError, RecordingError
from hsr_pin.recordings.importers.detect import read_capture

QUICK = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture
def points(laboratory):
    lab = laboratory(seconds=0.5)
    positions = lab.positions.copy()
    positions[20:25, 1] = np.nan
    return lab.names, positions


SYSTEMS = [
    ("nexus", {}, "Vicon CSV", "+z"),
    ("nexus", {"unit": "m"}, "Vicon CSV", "+z"),
    ("nexus", {"unit": "cm", "devices": False, "first_frame": 1}, "Vicon CSV", "+z"),
    ("nexus", {"title": "Markers"}, "Vicon CSV", "+z"),
    ("tracker", {}, "Vicon CSV", "+z"),
    ("motive", {}, "OptiTrack CSV", "+y"),
    ("motive", {"unit": "Millimeters", "version": "1.25"}, "OptiTrack CSV", "+y"),
    ("motive", {"unit": "Centimeters", "version": "1.20", "labelled": False}, "OptiTrack CSV", "+y"),
    ("motive", {"version": "1.0", "labelled": False}, "OptiTrack CSV", "+y"),
    ("old nexus", {}, "Vicon CSV", "+z"),
    ("legacy motive", {}, "OptiTrack CSV", "+y"),
    ("qualisys", {}, "Qualisys TSV 3D", "+z"),
    ("qualisys", {"columns": False, "version": "2.0.0"}, "Qualisys TSV 3D", "+z"),
    ("trc", {}, "TRC", None),
    ("trc", {"unit": "m"}, "TRC", None),
    ("c3d", {}, "C3D", "+z"),
    ("c3d", {"unit": "m", "up": "-Y"}, "C3D", None),
]


@pytest.mark.parametrize("system, options, told, up", SYSTEMS)
def test_points_come_back_in_metres_with_their_names_and_gaps(tmp_path, writers, points, system, options, told, up):
    names, positions = points
    writers[system](tmp_path / "take", names, positions, **options)
    capture = read_capture(tmp_path / "take")
    assert (capture.system, capture.up.axis) == (told, up)
    assert set(names) <= set(capture.names)
    found = capture.positions[:, [capture.names.index(name) for name in names]]
    if system == "motive":  # the rigid body has the name of its first marker; the marker goes first
        assert f"{names[0]} (Rigid Body)" in capture.names
    assert np.array_equal(np.isnan(found), np.isnan(positions))
    assert np.nanmax(np.abs(found - positions)) < 1e-6
    assert np.allclose(capture.time, np.arange(len(positions)) / 120, atol=1e-6)
    assert capture.rate == pytest.approx(120)


def test_a_unit_may_be_said_in_place_of_the_files(tmp_path, writers, points):
    writers["nexus"](tmp_path / "take", *points)
    assert np.allclose(
        read_capture(tmp_path / "take", "m").positions, 1e3 * read_capture(tmp_path / "take").positions, equal_nan=True
    )
    with pytest.raises(InputError, match="furlong"):
        read_capture(tmp_path / "take", "furlong")


def test_a_point_at_exactly_zero_was_not_seen(tmp_path, writers, points):
    names, positions = points
    positions[5, 2] = 0.0
    writers["tracker"](tmp_path / "take", names, positions)
    capture = read_capture(tmp_path / "take")
    assert np.isnan(capture.positions[5, 2]).all()
    assert any("(0, 0, 0)" in note for note in capture.notes)


def test_objects_and_trajectories_of_the_same_frames_are_read_together(tmp_path, writers, points):
    names, positions = points
    writers["tracker"](tmp_path / "a", ["Body"], positions[:, :1])
    writers["nexus"](tmp_path / "b", names, positions, devices=False, first_frame=1)
    text = (tmp_path / "a").read_text(encoding="utf-8") + "\n" + (tmp_path / "b").read_text(encoding="utf-8-sig")
    (tmp_path / "both").write_text(text, encoding="utf-8")
    assert read_capture(tmp_path / "both").names == ("Body", *names)


FAULTS = {
    "unit of no length": ("nexus", "mm,mm,mm", "deg,mm,mm", 13, "unit"),
    "no rate": ("nexus", "Trajectories\n120", "Trajectories\nfast", 10, "frame rate"),
    "no columns": ("nexus", "Frame,Sub Frame,X", "Picture,Sub Frame,X", 12, "columns"),
    "text among numbers": ("nexus", "\n9,0,", "\n9,0,x", 16, "a finite number"),
    "frame that is no number": ("nexus", "\n9,0,", "\nlast,0,", 16, "frame"),
    "version": ("motive", "1.23", "2.3", 1, "Format Version"),
    "unit unknown": ("motive", "Meters", "Furlongs", 1, "unit"),
    "no line of columns": ("motive", "Frame,Time", "Picture,Time", None, "columns"),
    "no time": ("motive", "Frame,Time", "Frame,Clock", 7, "Time (Seconds)"),
    "no number": ("motive", "\n2,3.016667,", "\n2,later,", 10, "a finite number"),
}


@pytest.mark.parametrize("system, old, new, line, said", FAULTS.values(), ids=FAULTS)
def test_a_fault_is_named_with_its_place(tmp_path, writers, points, system, old, new, line, said):
    path = tmp_path / "take"
    writers[system](path, *points)
    text = path.read_text(encoding="utf-8-sig")
    assert old in text
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(RecordingError) as caught:
        read_capture(path)
    assert said in str(caught.value)
    assert caught.value.file == path
    assert line is None or caught.value.line == line


@pytest.mark.parametrize(
    "content", [b"", b"t,x\n1,2\n", b"\x00\x50", b"\x02\x50" + b"\0" * 600, b"Trajectories", b"Format Version,1.23"]
)
def test_what_is_no_capture_is_refused(tmp_path, content):
    (tmp_path / "take").write_bytes(content)
    with pytest.raises(RecordingError):
        read_capture(tmp_path / "take")


def test_a_file_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="cannot read"):
        read_capture(tmp_path / "nowhere.csv")


@pytest.mark.parametrize("system", ["nexus", "tracker", "old nexus", "motive", "legacy motive", "qualisys", "trc"])
@QUICK
@given(cuts=st.lists(st.tuples(st.integers(0, 3000), st.integers(0, 12), st.binary(max_size=5)), min_size=1, max_size=3))
def test_a_csv_with_random_bytes_changed_is_read_or_refused(tmp_path, writers, points, system, cuts):
    names, positions = points
    path = tmp_path / system
    if not path.exists():
        writers[system](path, names, positions[:20])
    content = path.read_bytes()
    for start, length, insert in cuts:
        at = start % len(content)
        content = content[:at] + insert + content[at + length :]
    (tmp_path / "changed").write_bytes(content)
    try:
        capture = read_capture(tmp_path / "changed")
    except HsrError:
        return
    assert np.isfinite(capture.time).all()
    assert not np.isinf(capture.positions).any()

"""Text as laboratories have it: any encoding, separator and line end, cut files, rounded times."""

import numpy as np
import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.clock import frame_times
from hsr_pin.recordings.importers.detect import read_capture


@pytest.fixture
def points(laboratory):
    lab = laboratory(seconds=0.5)
    positions = lab.positions.copy()
    positions[20:25, 1] = np.nan
    return lab.names, positions


def semicolons(text):
    return text.replace(".", ",").replace(",", ";") if "," not in text else text.replace(",", ";").replace(".", ",")


FORMS = {
    "semicolons and decimal commas": lambda text: semicolons(text).encode(),
    "tabs": lambda text: text.replace(",", "\t").encode(),
    "tabs and decimal commas": lambda text: text.replace(",", "\t").replace(".", ",").encode(),
    "UTF-16 with a mark": lambda text: text.encode("utf-16"),
    "UTF-16 without a mark": lambda text: text.encode("utf-16-be"),
    "UTF-8 with a mark": lambda text: text.encode("utf-8-sig"),
    "Windows line ends": lambda text: text.replace("\n", "\r\n").encode(),
    "old Mac line ends": lambda text: text.replace("\n", "\r").encode(),
    "an umlaut of Windows": lambda text: text.replace("Arm:mid", "Ärmel:mid").encode("cp1252"),
    "an umlaut of UTF-8": lambda text: text.replace("Arm:mid", "Ärmel:mid").encode(),
    "every field quoted": lambda text: "\n".join(
        ",".join(f'"{f}"' for f in line.split(",")) for line in text.split("\n")
    ).encode(),
}


@pytest.mark.parametrize("form", FORMS.values(), ids=list(FORMS))
@pytest.mark.parametrize("system", ["nexus", "tracker", "old nexus", "motive", "legacy motive"])
def test_the_form_of_a_text_does_not_matter(tmp_path, writers, points, system, form):
    names, positions = points
    writers[system](tmp_path / "plain", names, positions)
    text = (tmp_path / "plain").read_text(encoding="utf-8-sig")
    if '"' in text and form is FORMS["every field quoted"]:
        pytest.skip("some fields of it are quoted already")
    (tmp_path / "take").write_bytes(form(text))
    plain, capture = read_capture(tmp_path / "plain"), read_capture(tmp_path / "take")
    assert np.array_equal(capture.positions, plain.positions, equal_nan=True)
    assert np.allclose(capture.time, plain.time, rtol=0, atol=1e-12)
    assert capture.names in (plain.names, tuple(name.replace("Arm:mid", "Ärmel:mid") for name in plain.names))


def test_what_was_no_utf_8_is_said(tmp_path, writers, points):
    writers["nexus"](tmp_path / "plain", *points)
    text = (tmp_path / "plain").read_text(encoding="utf-8-sig").replace("Arm:mid", "Ärmel:mid")
    for encoding, said in (("cp1252", "read as Windows-1252"), ("utf-16", "read as UTF-16")):
        (tmp_path / "take").write_bytes(text.encode(encoding))
        assert said in read_capture(tmp_path / "take").notes


def test_control_characters_in_names_do_not_get_through(tmp_path, writers, points):
    _, positions = points
    writers["nexus"](tmp_path / "take", ("Arm:base", "Arm:\x1b[31mmid", "Arm:tip"), positions)
    assert "Arm:?[31mmid" in read_capture(tmp_path / "take").names


@pytest.mark.parametrize("system", ["motive", "legacy motive", "qualisys", "trc"])
@pytest.mark.parametrize("lines", [1, 7])
def test_fewer_frames_than_the_file_says_it_has_are_refused(tmp_path, writers, points, system, lines):
    writers[system](tmp_path / "take", *points)
    text = (tmp_path / "take").read_bytes().splitlines(keepends=True)
    (tmp_path / "take").write_bytes(b"".join(text[:-lines]))
    with pytest.raises(RecordingError, match=rf"truncated: expected 60 frames, .* got {60 - lines};"):
        read_capture(tmp_path / "take")


@pytest.mark.parametrize("system", ["nexus", "tracker", "motive", "trc"])
@pytest.mark.parametrize("less", range(1, 30, 4))
def test_a_last_line_that_is_cut_is_no_position(tmp_path, writers, points, system, less):
    names, positions = points
    writers[system](tmp_path / "take", names, positions)
    text = (tmp_path / "take").read_bytes().rstrip()
    text = text.replace(b",Total Exported Frames,60", b"").replace(b"\t60\t", b"\t0\t")  # nothing else shall tell
    (tmp_path / "take").write_bytes(text[:-less])
    with pytest.raises(RecordingError, match="truncated"):
        read_capture(tmp_path / "take")


def test_trajectories_that_end_sooner_than_the_devices_before_them_were_cut(tmp_path, writers, points):
    names, positions = points
    writers["nexus"](tmp_path / "take", names, positions, first_frame=1)
    text = (tmp_path / "take").read_text(encoding="utf-8-sig")
    devices = text.replace("1,0,5.5\n1,1,5.6\n", "".join(f"{n},{m},5.5\n" for n in range(1, 61) for m in range(2)))
    assert len(devices) > len(text)
    (tmp_path / "take").write_text(devices, encoding="utf-8")
    assert len(read_capture(tmp_path / "take").time) == 60
    (tmp_path / "take").write_text("\n".join(devices.split("\n")[:-9]) + "\n", encoding="utf-8")
    with pytest.raises(RecordingError, match="truncated: expected frames up to 60, as in Devices, got 52"):
        read_capture(tmp_path / "take")


def test_a_last_line_without_the_tab_that_ends_the_others_is_whole(tmp_path):
    """As OpenSim's own examples have it."""
    lines = ["PathFileType\t4\t(X/Y/Z)\ta.trc", "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits", "10\t10\t3\t1\tm"]
    lines += ["Frame#\tTime\ta", "\t\tX1\tY1\tZ1", "", "1\t0\t1\t2\t3\t", "2\t0.1\t1\t2\t3\t", "3\t0.2\t1\t2\t3"]
    (tmp_path / "take").write_text("\n".join(lines), encoding="utf-8")
    assert np.array_equal(read_capture(tmp_path / "take").positions, [[[1, 2, 3]]] * 3)
    (tmp_path / "take").write_text("\n".join(lines)[:-2], encoding="utf-8")
    with pytest.raises(RecordingError, match="truncated"):
        read_capture(tmp_path / "take")


def test_a_last_line_without_end_that_is_whole_is_read(tmp_path, writers, points):
    writers["nexus"](tmp_path / "take", *points)
    whole = read_capture(tmp_path / "take").positions
    (tmp_path / "take").write_bytes((tmp_path / "take").read_bytes().rstrip())
    assert np.array_equal(read_capture(tmp_path / "take").positions, whole, equal_nan=True)


@pytest.mark.parametrize("rate", [100, 120, 240, 360, 119.88])
def test_times_rounded_to_milliseconds_come_from_the_frames(rate):
    frames = np.delete(np.arange(4000.0), [7, 8, *range(300, 900)])
    exact = frames / rate
    for known in (rate, None):
        time, note = frame_times(frames, known, 3 + np.round(exact, 3))
        tolerance = 1e-12 if known else 2e-6  # without the rate it is fitted
        assert np.abs((time - time[0]) - exact).max() < tolerance * max(1, exact[-1])
        assert ("rounded" in note) == (rate != 100)


def test_a_few_coarse_times_cannot_tell_another_rate():
    """A file of OpenSim says 60 Hz above two frames at 0 and 0.1 s."""
    for stamps in ([0.0, 0.1], [3.0, 3.1, 3.2, 3.3]):
        time, note = frame_times(np.arange(1.0, len(stamps) + 1), 60.0, np.array(stamps))
        assert time.tolist() == stamps
        assert note == ""


def test_times_of_full_precision_stay_and_frames_that_do_not_keep_step_are_left_aside():
    frames = np.arange(500.0)
    stamps = frames / 120
    time, note = frame_times(frames, 120.0, stamps)
    assert np.abs(time - stamps).max() < 1e-12
    assert note == ""
    jittering = stamps + np.random.default_rng(0).uniform(-2e-3, 2e-3, 500)
    time, note = frame_times(frames, 120.0, jittering)
    assert np.array_equal(time, jittering)
    assert "do not agree with them" in note


def test_a_motive_file_with_rounded_times_loses_no_sample_and_moves_none(tmp_path, writers, laboratory):
    lab = laboratory(seconds=2.0)
    writers["motive"](tmp_path / "take", lab.names, lab.positions, rate=360.0)
    lines = (tmp_path / "take").read_text(encoding="utf-8").split("\n")
    rounded = [",".join([f[0], f"{float(f[1]):.3f}", *f[2:]]) for f in (line.split(",") for line in lines[7:] if line)]
    (tmp_path / "take").write_text("\n".join([*lines[:7], *rounded]) + "\n", encoding="utf-8")
    capture = read_capture(tmp_path / "take")
    assert np.abs(capture.time - np.arange(len(lab.positions)) / 360).max() < 1e-9
    assert any("times from frame numbers at 360 Hz" in note for note in capture.notes)


def test_gaps_at_the_ends_of_rows_may_be_left_away(tmp_path, writers, points):
    names, positions = points
    positions[:, 2] = np.nan
    positions[40:, 2] = positions[40:, 0] + 0.1
    writers["nexus"](tmp_path / "take", names, positions)
    full = read_capture(tmp_path / "take").positions
    text = (tmp_path / "take").read_text(encoding="utf-8-sig").split("\n")
    (tmp_path / "take").write_text("\n".join(line.rstrip(",") for line in text), encoding="utf-8")
    assert np.array_equal(read_capture(tmp_path / "take").positions, full, equal_nan=True)


@pytest.mark.parametrize("lead", [(), ("frame",), ("time",), ("frame", "time")])
def test_qualisys_columns_without_names_are_told_from_how_they_look(tmp_path, writers, points, lead):
    names, positions = points
    positions[:30, 0] = np.nan  # the first point comes late
    writers["qualisys"](tmp_path / "take", names, positions)
    lines = (tmp_path / "take").read_bytes().decode().split("\r\n")
    top = next(n for n, line in enumerate(lines) if line.startswith("Frame"))
    kept = [n for n, name in enumerate(("frame", "time")) if name in lead]
    body = ["\t".join([*(line.split("\t")[n] for n in kept), *line.split("\t")[2:]]) for line in lines[top + 1 : -1]]
    (tmp_path / "take").write_bytes("\r\n".join([*lines[:top], *body]).encode())
    capture = read_capture(tmp_path / "take")
    assert np.array_equal(np.isnan(capture.positions), np.isnan(positions))
    assert np.nanmax(np.abs(capture.positions - positions)) < 1e-6
    assert np.abs(capture.time - np.arange(60) / 120).max() < 1e-5


@pytest.mark.parametrize("between", ["", "\t"], ids=["nothing", "an empty column"])
@pytest.mark.parametrize("lead", [False, True], ids=["bare", "frame and time"])
def test_qualisys_bodies_are_found_with_or_without_a_column_between_them(tmp_path, points, between, lead):
    names, positions = points
    text = f"NO_OF_FRAMES\t{len(positions)}\nNO_OF_BODIES\t3\nFREQUENCY\t120\nDATA_INCLUDED\t6D\nBODY_NAMES\t" + "\t".join(names)
    text += "\n" + "Frame\tTime\t" * lead + "\t".join([" X", " Y", " Z", *(f" Rot[{n}]" for n in range(13))]) + "\n"
    for n, frame in enumerate(1000 * np.nan_to_num(positions)):
        bodies = ["\t".join(f"{value:.5f}" for value in [*place, *range(1, 14)]) for place in frame]
        text += f"{n + 1}\t{n / 120:.5f}\t" * lead + f"\t{between}".join(bodies) + "\t\n"
    (tmp_path / "take").write_text(text, encoding="utf-8")
    capture = read_capture(tmp_path / "take")
    assert capture.names == names
    assert np.array_equal(np.isnan(capture.positions), np.isnan(positions))
    assert np.nanmax(np.abs(capture.positions - positions)) < 1e-6
    (tmp_path / "take").write_text(text.replace("\t13.00000\t", "\t"), encoding="utf-8")
    with pytest.raises(RecordingError, match=r"columns: expected 16 columns for each of 3 bodies, got 4[57] in total"):
        read_capture(tmp_path / "take")


def test_a_first_line_of_megabytes_is_read(tmp_path, writers, points):
    names, positions = points
    writers["nexus"](tmp_path / "take", [f"{name}{'x' * 700_000}" for name in names], positions)
    with pytest.raises(RecordingError, match="field larger than field limit"):
        read_capture(tmp_path / "take")

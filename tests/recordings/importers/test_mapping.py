"""Any table comes in with a mapping of a few lines, and a mapping that is wrong says where."""

import re
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.assemble import import_recordings
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.detect import read_capture
from hsr_pin.recordings.importers.mapping import read_mapping
from hsr_pin.recordings.importers.settings import ImportSettings

MAPPING = """\
[time]
column = "stamp"
unit = "ms"

[space]
unit = "mm"
up = "+z"

[points]
base = ["bx", "by", "bz"]
tip = ["tip x", "tip y", "tip z"]

[input]
P1 = "left [kPa]"
P2 = "right [kPa]"
unit = "kPa"
"""


@pytest.fixture
def log(tmp_path, laboratory):
    """A log of 38 columns, most of them of no use, with times in milliseconds and pressures in kPa; and its mapping."""
    lab = laboratory()
    rng = np.random.default_rng(0)
    names = ["stamp", "bx", "by", "bz", *(f"sensor {n}" for n in range(26)), "tip x", "tip y", "tip z"]
    names += ["left [kPa]", "right [kPa]", "mode", "ok", "comment"]
    assert len(names) == 38
    rows = []
    for t, place, torque in zip(lab.time, lab.positions, lab.torque, strict=True):
        numbers = [1000 * t, *(1000 * place[0]), *rng.normal(size=26), *(1000 * place[2]), 120.0, 120.0 + 50 * torque]
        rows.append([f"{number:.6f}" for number in numbers] + ["auto", "1", "nothing"])
    path = tmp_path / "log.csv"
    path.write_text("\n".join(",".join(row) for row in [names, *rows]) + "\n", encoding="utf-8")
    (tmp_path / "map.toml").write_text(MAPPING, encoding="utf-8")
    return path, tmp_path / "map.toml", lab


def settings(mapping, **changes):
    bodies = (Body("base", ("base",), 0.0), Body("tip", ("tip",), 0.24))
    given = {"mass": 0.15, "diameter": 0.04, "keq": [1.11], "markers": bodies, "mapping": read_mapping(mapping)}
    return ImportSettings(**given | changes)


def test_a_log_of_38_columns_comes_in_with_less_than_20_lines(log):
    path, mapping, lab = log
    assert len(MAPPING.splitlines()) < 20
    trajectory = import_recordings([path], settings(mapping)).dataset.trials[0].trajectory
    assert np.abs(trajectory.positions - lab.world[:, [0, 2]]).max() < 2e-6
    assert np.allclose(trajectory.pressures, np.stack([0 * lab.torque + 1.2, 1.2 + 0.5 * lab.torque], axis=1))


def change(path, old, new):
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def test_columns_may_be_numbers_and_there_may_be_no_header(log):
    path, mapping, _ = log
    named = read_capture(path, None, read_mapping(mapping))
    change(path, path.read_text(encoding="utf-8").split("\n", 1)[0] + "\n", "")
    change(mapping, '"stamp"', "1")
    change(mapping, '["bx", "by", "bz"]', "[2, 3, 4]")
    change(mapping, '["tip x", "tip y", "tip z"]', "[31, 32, 33]")
    mapping.write_text(mapping.read_text(encoding="utf-8") + "[file]\nheader = 0\n", encoding="utf-8")
    assert np.array_equal(read_capture(path, None, read_mapping(mapping)).positions, named.positions)


def test_a_minus_turns_an_axis_round_and_an_empty_name_is_a_plane(log):
    path, mapping, _ = log
    plain = read_capture(path, None, read_mapping(mapping)).positions
    change(mapping, '["tip x", "tip y", "tip z"]', '["tip x", "-tip z", "tip y"]')
    change(mapping, '["bx", "by", "bz"]', '["bx", "", -4]')
    turned = read_capture(path, None, read_mapping(mapping)).positions
    assert np.array_equal(turned[:, 1], plain[:, 1][:, [0, 2, 1]] * [1, -1, 1])
    assert np.array_equal(turned[:, 0], plain[:, 0][:, [0, 1, 2]] * [1, 0, -1])


def test_a_rate_takes_the_place_of_times(log):
    path, mapping, lab = log
    change(mapping, 'column = "stamp"\nunit = "ms"', "rate = 120")
    assert np.allclose(read_capture(path, None, read_mapping(mapping)).time, lab.time)


def test_lines_above_and_units_below_the_names_are_passed_over(log):
    path, mapping, lab = log
    names, rest = path.read_text(encoding="utf-8").split("\n", 1)
    path.write_text("\n".join(["made by me", "", names, ",".join(["mm"] * 38), rest]), encoding="utf-8")
    mapping.write_text(mapping.read_text(encoding="utf-8") + "[file]\nheader = 3\n", encoding="utf-8")
    assert len(read_capture(path, None, read_mapping(mapping)).time) == len(lab.time)


@pytest.mark.parametrize("clock, shift", [("capture", 0.0), ("shared", 1.7e9)])
def test_commands_may_stand_in_a_file_of_their_own_on_either_clock(log, clock, shift):
    path, mapping, lab = log
    rows = [row.split(",") for row in path.read_text(encoding="utf-8").splitlines()]
    if clock == "shared":
        rows[1:] = [[f"{float(row[0]) + 1000 * shift:.6f}", *row[1:]] for row in rows[1:]]
        path.write_text("\n".join(",".join(row) for row in rows) + "\n", encoding="utf-8")
    times = lab.time[::10] + shift
    commands = ["T;tau", *(f"{t:.6f};{1000 * tau:g}".replace(".", ",") for t, tau in zip(times, lab.torque[::10], strict=True))]
    (path.parent / "commands.csv").write_text("\n".join(commands), encoding="utf-8")
    text = mapping.read_text(encoding="utf-8")
    text = text[: text.index("[input]")] + f'[input]\ntau = "tau"\nunit = "Nmm"\ntime = "T"\nclock = "{clock}"\n'
    mapping.write_text(text, encoding="utf-8")
    made = import_recordings([path], settings(mapping, inputs=[path.parent / "commands.csv"]))
    assert np.array_equal(made.dataset.trials[0].trajectory.torque, np.repeat(lab.torque[::10], 10)[: len(lab.time)])


def test_a_mapping_of_the_input_alone_leaves_the_recording_to_its_reader(log, writers, tmp_path):
    path, mapping, lab = log
    writers["nexus"](tmp_path / "take", lab.names, lab.positions)
    text = mapping.read_text(encoding="utf-8")
    mapping.write_text(text[text.index("[input]") :] + 'time = "stamp"\ntime_unit = "ms"\n', encoding="utf-8")
    bodies = (Body("base", ("Arm:base",), 0.0), Body("tip", ("Arm:tip",), 0.24))
    made = import_recordings([tmp_path / "take"], settings(mapping, markers=bodies, inputs=[path]))
    assert np.allclose(made.dataset.trials[0].trajectory.pressures[:, 1], 1.2 + 0.5 * lab.torque)


def test_a_command_is_held_over_rows_without_one(log):
    path, mapping, lab = log
    rows = [row.split(",") for row in path.read_text(encoding="utf-8").splitlines()]
    for number, row in enumerate(rows[1:]):
        if number % 6:
            row[33], row[34] = "", ""
    path.write_text("\n".join(",".join(row) for row in rows) + "\n", encoding="utf-8")
    trajectory = import_recordings([path], settings(mapping)).dataset.trials[0].trajectory
    assert np.allclose(trajectory.pressures[:, 1], 1.2 + 0.5 * np.repeat(lab.torque[::6], 6)[: len(lab.time)])


def test_commands_of_a_file_of_their_own_need_a_time(log, writers, tmp_path):
    path, mapping, lab = log
    writers["nexus"](tmp_path / "take", lab.names, lab.positions)
    text = mapping.read_text(encoding="utf-8")
    mapping.write_text(text[text.index("[input]") :], encoding="utf-8")
    bodies = (Body("base", ("Arm:base",), 0.0), Body("tip", ("Arm:tip",), 0.24))
    with pytest.raises(RecordingError, match=r"the commands have no times: .* give \[input\] time in map\.toml"):
        import_recordings([tmp_path / "take"], settings(mapping, markers=bodies, inputs=[path]))


def test_times_separated_by_spaces_are_read(tmp_path):
    rows = ["# timestamp tx ty tz qx", *(f"  {n / 50:.3f}  {n} 2   -3 0.5 " for n in range(20))]
    (tmp_path / "track.txt").write_text("\n".join(rows), encoding="utf-8")
    (tmp_path / "map.toml").write_text('[time]\ncolumn = "timestamp"\n[points]\np = ["tx", "ty", "tz"]\n', encoding="utf-8")
    capture = read_capture(tmp_path / "track.txt", None, read_mapping(tmp_path / "map.toml"))
    assert capture.positions[:, 0].tolist() == [[n, 2, -3] for n in range(20)]
    assert capture.up.axis is None


WRONG = {
    "no such column": ('"tip z"', '"tipz"', "no column 'tipz'; did you mean 'tip z'?"),
    "unknown section": ("[space]", "[room]", "unknown key 'room'"),
    "unknown key": ('unit = "mm"', 'units = "mm"', "did you mean 'unit'?"),
    "unknown unit": ('unit = "mm"', 'unit = "furlong"', "unit: expected m"),
    "unknown unit of time": ('unit = "ms"', 'unit = "min"', "expected s or ms or us or ns"),
    "unknown unit of pressure": ('unit = "kPa"', 'unit = "kpa"', "did you mean 'kPa'?"),
    "two coordinates": ('["bx", "by", "bz"]', '["bx", "by"]', "three columns"),
    "no coordinates": ('["bx", "by", "bz"]', '["", "", ""]', "three columns"),
    "a number beyond the last": ('["bx", "by", "bz"]', "[2, 3, 99]", "column 99: expected 1 to 38"),
    "two columns and one unit": ('column = "stamp"', 'column = ["stamp", "bx"]', "a unit for each of 2 columns"),
    "no time": ('column = "stamp"\nunit = "ms"', "", "a column of times, or a rate"),
    "no axis": ('up = "+z"', 'up = "north"', "+x, -x, +y, -y, +z or -z"),
    "one pressure": ('P2 = "right [kPa]"', "", "P1 and P2, or tau"),
    "a column of words": ('"left [kPa]"', '"mode"', "column 'auto'"),
    "milliseconds as seconds": ('unit = "ms"', 'unit = "s"', "if these are milliseconds,"),
}


@pytest.mark.parametrize("old, new, said", WRONG.values(), ids=list(WRONG))
def test_a_wrong_mapping_says_where(log, old, new, said):
    path, mapping, _ = log
    change(mapping, old, new)
    with pytest.raises(RecordingError) as caught:
        import_recordings([path], settings(mapping))
    if said != "column 'auto'":
        assert said in str(caught.value)
    assert caught.value.file in (path, mapping)
    assert caught.value.line is not None or "milliseconds" in said


def restamped(path, rows):
    """The log with the time of the row before in some rows."""
    lines = path.read_text(encoding="utf-8").split("\n")
    for row in rows:
        lines[row] = ",".join([lines[row - 1].split(",")[0], *lines[row].split(",")[1:]])
    path.write_text("\n".join(lines), encoding="utf-8")


def test_rows_with_the_time_of_the_row_before_are_left_out_with_a_word(log):
    path, mapping, lab = log
    restamped(path, range(9, 300, 30))
    made = import_recordings([path], settings(mapping)).dataset.trials[0].trajectory
    assert any("10 rows with the time of the previous row were left out" in note for note in made.notes)
    assert len(made.time) == len(lab.time)
    gaps = np.isnan(made.positions).any(axis=(1, 2))
    assert gaps.sum() <= 10
    assert np.abs((made.positions - lab.world[:, [0, 2]])[~gaps]).max() < 2e-6
    assert np.allclose(made.pressures[~gaps, 1], (1.2 + 0.5 * lab.torque)[~gaps])


def test_a_time_that_often_stands_still_or_goes_back_is_named_with_its_line(log):
    path, mapping, _ = log
    restamped(path, range(9, 300, 4))
    with pytest.raises(RecordingError, match=r"log\.csv:10:1: time: expected more than .* remove duplicate rows"):
        read_capture(path, None, read_mapping(mapping))
    lines = path.read_text(encoding="utf-8").split("\n")
    path.write_text("\n".join([*lines[:8], lines[9], lines[8], *lines[10:]]), encoding="utf-8")
    with pytest.raises(RecordingError, match=r"log\.csv:\d+:1: time: expected more than .* remove duplicate rows"):
        read_capture(path, None, read_mapping(mapping))


DATES = {
    "seconds and nanoseconds": (
        lambda t: f"{int(t)},{round(1e9 * (t - int(t)))}",
        "secs,nsecs",
        'column = ["secs", "nsecs"]\nunit = ["s", "ns"]',
    ),
    "a date": (
        lambda t: datetime.fromtimestamp(t, timezone.utc).strftime("%Y/%m/%d %H:%M:%S.%f") + ",0",
        "when,",
        'column = "when"\nformat = "%Y/%m/%d %H:%M:%S.%f"',
    ),
    "a time of day": (
        lambda t: datetime.fromtimestamp(t, timezone.utc).strftime("%H:%M:%S.%f") + ",0",
        "when,",
        'column = "when"\nformat = "%H:%M:%S.%f"',
    ),
}


@pytest.mark.parametrize("printed, names, clock", DATES.values(), ids=list(DATES))
def test_times_may_stand_in_two_columns_or_be_dates(log, printed, names, clock):
    path, mapping, lab = log
    plain = read_capture(path, None, read_mapping(mapping)).positions
    header, *rows = path.read_text(encoding="utf-8").strip().split("\n")
    rows = [f"{printed(1.7e9 + t)},{row.split(',', 1)[1]}" for t, row in zip(lab.time, rows, strict=True)]
    path.write_text("\n".join([f"{names},{header.split(',', 1)[1]}", *rows]) + "\n", encoding="utf-8")
    change(mapping, 'column = "stamp"\nunit = "ms"', clock)
    capture = read_capture(path, None, read_mapping(mapping))
    assert np.array_equal(capture.positions, plain)
    assert np.abs(capture.time - lab.time).max() < 2e-6
    made = import_recordings([path], settings(mapping)).dataset.trials[0].trajectory
    assert np.allclose(made.pressures[:, 1], 1.2 + 0.5 * lab.torque)


def test_a_date_of_another_form_is_named_with_its_line(log):
    path, mapping, _ = log
    change(mapping, 'unit = "ms"', 'format = "%H:%M"')
    with pytest.raises(RecordingError, match=r"log\.csv:2:1: time: expected as %H:%M, got"):
        read_capture(path, None, read_mapping(mapping))


def test_the_unit_of_length_may_be_the_pixel_of_a_camera(log):
    path, mapping, _ = log
    plain = read_capture(path, None, read_mapping(mapping)).positions
    change(mapping, 'unit = "mm"', "unit = 0.0005")
    capture = read_capture(path, None, read_mapping(mapping))
    assert np.allclose(capture.positions, 0.5 * plain)
    assert capture.unit == "0.0005 m"


def test_points_of_a_table_need_a_clock(log):
    path, mapping, _ = log
    change(mapping, '[time]\ncolumn = "stamp"\nunit = "ms"\n', "")
    with pytest.raises(RecordingError, match=r"map\.toml:1:1: no time: expected \[time\] with a column of times or a rate"):
        read_capture(path, None, read_mapping(mapping))


def test_a_table_without_a_mapping_is_told_of_it(log):
    with pytest.raises(RecordingError, match="other tables need a mapping"):
        read_capture(log[0])


def test_the_mappings_of_the_guide_are_mappings(tmp_path):
    guide = (Path(__file__).resolve().parents[3] / "docs" / "importing.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```toml\n(.*?)```", guide, re.DOTALL)
    assert len(blocks) == 9
    for block in blocks:
        assert len(block.splitlines()) <= 20 or "[robot]" in block
        (tmp_path / "map.toml").write_text(block, encoding="utf-8")
        assert read_mapping(tmp_path / "map.toml").input is not None


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(RecordingError, match=r"a ROS 2 bag with its metadata\.yaml, got a folder"):
        read_capture(tmp_path)

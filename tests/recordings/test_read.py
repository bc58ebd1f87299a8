"""A dataset is read as it stands, or refused with the place of its first fault."""

import numpy as np
import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.identification.experiment import prepare
from hsr_pin.recordings.read import read_dataset


def fault(folder):
    with pytest.raises(RecordingError) as caught:
        read_dataset(folder)
    return caught.value


def place(folder, file, piece):
    """Line and column at which a piece stands in a file."""
    text = (folder / file).read_text(encoding="utf-8")
    before = text[: text.index(piece)].split("\n")
    return len(before), len(before[-1]) + 1


def test_what_stands_there_is_what_is_read(folder):
    dataset = read_dataset(folder)
    trial = dataset.trials[0]
    assert (dataset.name, dataset.length, dataset.mass, dataset.diameter, dataset.mount) == ("known", 0.24, 0.15, 0.04, "hanging")
    assert [(marker.name, marker.arc_length) for marker in dataset.markers] == [("mid", 0.12), ("tip", 0.24)]
    assert (trial.name, trial.keq, trial.damping, trial.tip_mass, trial.t_start) == ("trial_01", 1.11, 0.05, 0.0, None)
    table = np.loadtxt(folder / "trial_01.csv", delimiter=",", skiprows=1)
    assert np.array_equal(trial.trajectory.time, table[:, 0])
    assert np.array_equal(trial.trajectory.torque, table[:, 1])
    assert np.array_equal(trial.trajectory.positions.reshape(-1, 6), table[:, 2:])
    assert trial.trajectory.notes == ()


def test_an_input_is_held_unless_the_arm_or_the_trial_says_otherwise(folder, spoil):
    assert not read_dataset(folder).trials[0].interpolated
    spoil("dataset.toml", "keq = 1.11", 'keq = 1.11\ninput = "interpolated"')
    assert read_dataset(folder).trials[0].interpolated
    assert prepare(read_dataset(folder)).runs[0].interpolated
    spoil("dataset.toml", "damping = 0.05", 'damping = 0.05\ninput = "held"')
    assert not read_dataset(folder).trials[0].interpolated


def test_the_path_of_the_declaration_will_do(folder):
    assert read_dataset(folder / "dataset.toml").path == folder


def test_columns_may_stand_in_any_order_and_a_byte_order_mark_is_no_fault(folder):
    path = folder / "trial_01.csv"
    table = [line.split(",") for line in path.read_text(encoding="utf-8").split()]
    straight = read_dataset(folder).trials[0].trajectory.positions
    path.write_text("\n".join(",".join(row[::-1]) for row in table), encoding="utf-8-sig")
    assert np.array_equal(read_dataset(folder).trials[0].trajectory.positions, straight)


@pytest.mark.parametrize("gap", ["", "nan", "NaN", "  "])
def test_an_empty_field_or_nan_is_a_gap_and_nothing_else_is(folder, spoil, gap):
    first = (folder / "trial_01.csv").read_text(encoding="utf-8").split("\n")[2].split(",")
    spoil("trial_01.csv", ",".join(first), ",".join([*first[:5], gap, *first[6:]]))
    missing = np.isnan(read_dataset(folder).trials[0].trajectory.positions)
    assert missing.sum() == 1
    assert missing[1, 1, 0]


SPOILED_DECLARATIONS = {
    "unknown key": ("length = 0.24", "lenght = 0.24", "lenght", "did you mean 'length'?"),
    "unknown key in a trial": ("damping", "tip_mas", "tip_mas", "did you mean 'tip_mass'?"),
    "unknown key at the top": ('name = "known"', 'nmae = "known"', "nmae", "did you mean 'name'?"),
    "unknown version": ("format = 1", "format = 3", "format", "format = 1 or format = 2"),
    "version that is no whole number": ("format = 1", "format = 1.0", "format", "format = 1"),
    "wrong type": ("mass = 0.15", 'mass = "0.15"', "mass", "a number, more than zero [kg]"),
    "truth for a number": ("mass = 0.15", "mass = true", "mass", "a number, more than zero [kg]"),
    "infinite": ("mass = 0.15", "mass = inf", "mass", "a number, more than zero [kg]"),
    "too large for a float": ("mass = 0.15", "mass = 1" + "0" * 400, "mass", "a number, more than zero [kg]"),
    "negative": ("damping = 0.05", "damping = -0.05", "damping", "zero or more"),
    "bad mount": ('mount = "hanging"', 'mount = "hangin"', "mount", "did you mean 'hanging'?"),
    "length in mm": ("length = 0.24", "length = 240", "length", "metres"),
    "marker beyond the tip": ("arc_length = 0.24", "arc_length = 0.3", "arc_length = 0.3", "0 to the arm's length"),
    "marker named twice": ('name = "tip"', 'name = "mid"', None, "two markers are named 'mid'"),
    "one marker for several": ("[[trial]]", "[trial]", "[trial]", "at least one table [[trial]]"),
    "no keq": ("keq = 1.11", "", "[[trial]]", "keq is missing"),
    "no such file": ("trial_01.csv", "trial_1.csv", "file", "did you mean 'trial_01.csv'?"),
    "file outside": ("trial_01.csv", "../x.csv", "file", "inside the dataset"),
    "input of a third kind": ("damping = 0.05", 'input = "holdd"', "input", "did you mean 'held'?"),
    "not TOML": ("mass = 0.15", "mass = = 0.15", "= 0.15", "invalid TOML"),
    "t_start after the end": ("damping = 0.05", "t_start = 9.0", "t_start", "a time in the recording"),
    "no marker beyond the base": (
        'name = "mid"\narc_length = 0.12\n\n[[marker]]\nname = "tip"\narc_length = 0.24',
        'name = "mid"\narc_length = 0.0',
        "[[marker]]",
        "no moving marker",
    ),
}


@pytest.mark.parametrize("old, new, at, said", SPOILED_DECLARATIONS.values(), ids=SPOILED_DECLARATIONS)
def test_a_fault_in_the_declaration_is_named_with_its_place(spoil, old, new, at, said):
    folder = spoil("dataset.toml", old, new)
    error = fault(folder)
    assert error.file == folder / "dataset.toml"
    assert said in str(error)
    if at is not None:
        assert (error.line, error.column) == place(folder, "dataset.toml", at)


@pytest.mark.parametrize("key", ["name", "length", "mass", "diameter", "mount", "arc_length", "file", "format"])
def test_a_key_that_is_missing_is_named(folder, key):
    path = folder / "dataset.toml"
    lines = path.read_text(encoding="utf-8").split("\n")
    path.write_text("\n".join(line for line in lines if not line.startswith(f"{key} = ")), encoding="utf-8")
    error = fault(folder)
    assert key in str(error)
    assert error.line is not None


SPOILED_TABLES = {
    "missing column": ("t,tau,mid_x,mid_y", "t,tau,mid_y", 1, "column 'mid_x' is missing"),
    "unknown column": ("tip_x", "tipx", 1, "did you mean 'tip_x'?"),
    "column twice": ("tip_x", "mid_x", 1, "occurs twice"),
    "one pressure": ("t,tau", "t,P1", 1, "P1 and P2, or tau, or no input columns"),
    "no number": ("0.5,", "half,", 2, "a finite number"),
    "infinite": ("0.5,", "inf,", 2, "a finite number"),
    "number as Python has it": ("0.5,", "1_0,", 2, "a finite number"),
    "input missing": ("0.5,", ",", 2, "no value"),
    "time missing": ("0.000000,", ",", 2, "no value"),
    "time standing": ("0.020000,", "0.010000,", 4, "the previous time"),
    "time going back": ("0.020000,", "0.001000,", 4, "the previous time"),
    "coordinate of no measure": ("0.5,", "1e11,", 2, "at most 1e+10"),
    "row too long": ("0.010000,0.5", "0.010000,0.5,1", 3, "8 fields"),
    "semicolons": (None, None, 1, "separated by commas"),
}


@pytest.mark.parametrize("old, new, line, said", SPOILED_TABLES.values(), ids=SPOILED_TABLES)
def test_a_fault_in_a_table_is_named_with_its_place(folder, old, new, line, said):
    path = folder / "trial_01.csv"
    text = path.read_text(encoding="utf-8")
    assert old is None or old in text
    if old == "t,tau,mid_x,mid_y":  # take the column out of every row
        rows = [row.split(",") for row in text.split()]
        text = "\n".join(",".join(row[:2] + row[3:]) for row in rows)
    else:
        text = text.replace(",", ";") if old is None else text.replace(old, new, 1)
    path.write_text(text, encoding="utf-8")
    error = fault(folder)
    assert (error.file, error.line) == (path, line)
    assert error.column is not None
    assert said in str(error)


def test_the_column_of_a_fault_is_where_the_field_begins(folder, spoil):
    row = (folder / "trial_01.csv").read_text(encoding="utf-8").split("\n")[5]
    fields = row.split(",")
    spoil("trial_01.csv", row, ",".join([*fields[:4], "here", *fields[5:]]))
    error = fault(folder)
    assert (error.line, error.column) == place(folder, "trial_01.csv", "here")


@pytest.mark.parametrize("factor, said", [(1000, "millimetres"), (100, "millimetres"), (1e-3, "is not in metres")])
def test_units_that_cannot_be_metres_are_refused(folder, factor, said):
    path = folder / "trial_01.csv"
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    table[:, 2:] *= factor
    header = path.read_text(encoding="utf-8").split("\n")[0]
    np.savetxt(path, table, delimiter=",", header=header, comments="")
    assert said in str(fault(folder))


def test_a_recording_in_which_nothing_moves_is_refused(folder):
    path = folder / "trial_01.csv"
    lines = path.read_text(encoding="utf-8").split("\n")
    still = [lines[0]] + [f"{0.01 * k:.2f},0.5,0,0,-0.12,0,0,-0.24" for k in range(20)]
    path.write_text("\n".join(still), encoding="utf-8")
    assert "no moving marker" in str(fault(folder))


def test_a_marker_never_seen_in_one_trial_is_a_note_and_in_all_trials_a_fault(folder):
    lines = (folder / "trial_01.csv").read_text(encoding="utf-8").split("\n")[:-1]
    blind = [lines[0]] + [",".join([*row.split(",")[:2], "", "", "", *row.split(",")[5:]]) for row in lines[1:]]
    (folder / "trial_02.csv").write_text("\n".join(blind), encoding="utf-8")
    with (folder / "dataset.toml").open("a", encoding="utf-8") as file:
        file.write('\n[[trial]]\nfile = "trial_02.csv"\n')
    first, second = read_dataset(folder).trials
    assert first.trajectory.notes == ()
    assert second.trajectory.notes == ("marker mid was not seen",)
    (folder / "trial_01.csv").write_text("\n".join(blind), encoding="utf-8")
    assert "marker 'mid' has no data in any trial" in str(fault(folder))


def test_bytes_that_are_no_text_are_named_with_their_place(folder):
    path = folder / "trial_01.csv"
    path.write_bytes(path.read_bytes().replace(b"0.020000", b"0.0\xff0000", 1))
    error = fault(folder)
    assert (error.file, error.line, error.column) == (path, 4, 4)
    assert "UTF-8" in str(error)


@pytest.mark.parametrize("file", ["dataset.toml", "trial_01.csv"])
@pytest.mark.parametrize("content", ["", "\n\n", "\x00"])
def test_an_empty_file_is_a_fault_of_that_file(folder, file, content):
    (folder / file).write_text(content, encoding="utf-8")
    assert fault(folder).file == folder / file


def test_a_header_without_rows_and_one_row_are_faults(folder):
    path = folder / "trial_01.csv"
    lines = path.read_text(encoding="utf-8").split("\n")
    path.write_text(lines[0], encoding="utf-8")
    assert "no rows" in str(fault(folder))
    path.write_text("\n".join(lines[:2]), encoding="utf-8")
    assert "at least two samples" in str(fault(folder))


@pytest.mark.parametrize("name", ["nowhere", "a\0b", "x" * 5000])
def test_a_folder_that_is_not_there_is_a_fault(tmp_path, name):
    assert "no such dataset" in str(fault(tmp_path / name))


def test_a_folder_without_a_declaration_is_a_fault(tmp_path):
    assert fault(tmp_path).file == tmp_path / "dataset.toml"


@pytest.mark.parametrize(
    "name, trials, markers, with_input",
    [("sample-steps", 6, 3, True), ("sample-rich-dirty", 10, 3, True), ("real-beam", 4, 2, False), ("real-trunk", 32, 3, False)],
)
def test_the_shared_datasets_load(shared, name, trials, markers, with_input):
    dataset = read_dataset(shared / "recordings" / name)
    assert (len(dataset.trials), len(dataset.markers)) == (trials, markers)
    for trial in dataset.trials:
        assert trial.trajectory.has_input == with_input
        assert trial.trajectory.notes == ()
        assert np.isfinite(trial.trajectory.positions).mean() > 0.98


@pytest.mark.parametrize(("line", "weighed"), [("", False), ("weighed = true\n", True), ("weighed = false\n", False)])
def test_a_mass_that_was_weighed_is_read_and_written(tmp_path, line, weighed):
    from hsr_pin.recordings.read import sample
    from hsr_pin.recordings.write import write_dataset

    write_dataset(sample("beam-empty"), tmp_path / "made")
    file = tmp_path / "made" / "dataset.toml"
    file.write_text(file.read_text().replace("[robot]\n", f"[robot]\n{line}"))
    dataset = read_dataset(tmp_path / "made")
    write_dataset(dataset, tmp_path / "again")
    assert (dataset.weighed, read_dataset(tmp_path / "again").weighed) == (weighed, weighed)


def test_a_mass_is_weighed_or_is_not(tmp_path):
    from hsr_pin.recordings.read import sample
    from hsr_pin.recordings.write import write_dataset

    write_dataset(sample("beam-empty"), tmp_path / "made")
    file = tmp_path / "made" / "dataset.toml"
    file.write_text(file.read_text().replace("[robot]\n", "[robot]\nweighed = 1\n"))
    with pytest.raises(RecordingError, match="weighed: expected true or false, got 1"):
        read_dataset(tmp_path / "made")

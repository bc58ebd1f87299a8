"""Excel workbooks and MATLAB files come in by the same mapping as a table, and a damaged one is refused in one line."""

import datetime
import sys

import numpy as np
import pytest
from scipy.io import savemat

from hsr_pin.errors import InputError, MissingDependencyError, RecordingError
from hsr_pin.recordings.importers.assemble import import_recordings
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.detect import read_capture
from hsr_pin.recordings.importers.guess import guessed_mapping
from hsr_pin.recordings.importers.mapping import read_mapping
from hsr_pin.recordings.importers.settings import ImportSettings
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset

COLUMNS = """\
[time]
column = "Time"
[space]
unit = "mm"
up = "+z"
[points]
base = ["base x", "base y", "base z"]
tip = ["tip x", "tip y", "tip z"]
[input]
tau = "(right - left) * gain / 2"
"""


def made(path, mapping, **changes):
    path.with_name("map.toml").write_text(mapping, encoding="utf-8")
    bodies = (Body("base", ("base",), 0.0), Body("tip", ("tip",), 0.24))
    arm = {"mass": 0.15, "diameter": 0.04, "keq": [1.11], "markers": bodies}
    return import_recordings([path], ImportSettings(**arm, mapping=read_mapping(path.with_name("map.toml")), **changes))


def agrees(imported, lab):
    trajectory = imported.dataset.trials[0].trajectory
    assert np.abs(trajectory.positions - lab.world[:, [0, 2]]).max() < 2e-6
    assert np.allclose(trajectory.torque, lab.torque, atol=1e-12)


def numbers(lab):
    """Time, base, tip, and three columns of which the torque is (right - left) * gain / 2."""
    left = 1.0 + np.sin(lab.time)
    right = left + 2 * lab.torque / 0.5
    places = 1000 * lab.positions[:, [0, 2]].reshape(len(lab.time), -1)
    return np.column_stack([lab.time, places, left, right, 0.5 + 0 * left])


@pytest.fixture
def workbook(tmp_path, laboratory):
    """A workbook with a title, merged names of points above their axes, units below, and columns beside of another length."""
    openpyxl = pytest.importorskip("openpyxl", reason="needs openpyxl (group import)")
    lab = laboratory()
    book = openpyxl.Workbook()
    book.active.title = "Notes"
    book.active.append(["not a table"])
    sheet = book.create_sheet("Run 7")
    sheet.append(["Measured by me"])
    sheet.append([None])
    sheet.append(["Time", "base", None, None, "tip", None, None, "left", "right", "gain", None, "old"])
    sheet.merge_cells("B3:D3")
    sheet.merge_cells("E3:G3")
    sheet.append([None, *"xyz", *"xyz"])
    sheet.append(["s", *["mm"] * 6, "bar", "bar", "Nm/bar"])
    for row in numbers(lab).tolist():
        sheet.append([*row, None, 1])
    for _ in range(5):
        sheet.append([*[None] * 11, 1])
    path = tmp_path / "run.xlsx"
    book.save(path)
    return path, lab


SHEET = COLUMNS + '[file]\nsheet = "Run 7"\nheader = [3, 4]\n'


def test_a_worksheet_comes_in_with_names_in_two_rows(workbook):
    path, lab = workbook
    agrees(made(path, SHEET), lab)


def test_a_fault_in_a_workbook_names_its_row_and_column(workbook):
    import openpyxl

    path, _ = workbook
    book = openpyxl.load_workbook(path)
    book["Run 7"]["F20"] = "lost"
    book.save(path)
    with pytest.raises(RecordingError, match=r"run\.xlsx:20:6: coordinate: expected a finite number, got 'lost'"):
        made(path, SHEET)


def test_dates_in_cells_are_times(workbook):
    import openpyxl

    path, lab = workbook
    book = openpyxl.load_workbook(path)
    start = datetime.datetime(2026, 1, 19, 10, 19, 43)
    for row, time in enumerate(lab.time, start=6):
        book["Run 7"].cell(row, 1).value = start + datetime.timedelta(seconds=round(time, 3))
    book.save(path)
    capture = made(path, SHEET).dataset.trials[0].trajectory
    assert np.abs(capture.time - lab.time).max() < 1e-3


def test_another_worksheet_or_none_is_named(workbook):
    path, _ = workbook
    with pytest.raises(RecordingError, match=r"\[file\] sheet: expected a worksheet .*, got 'Run 8'; did you mean 'Run 7'\?"):
        made(path, SHEET.replace("Run 7", "Run 8"))
    with pytest.raises(RecordingError, match=r"run\.xlsx:1:1: the table has no column 'base x'"):
        made(path, COLUMNS)
    path.write_text("Time\n1\n", encoding="utf-8")
    with pytest.raises(RecordingError, match="expected an Excel workbook"):
        made(path.rename(path.with_suffix(".csv")), SHEET)


def test_formulas_without_values_are_named(workbook):
    import openpyxl

    path, _ = workbook
    book = openpyxl.load_workbook(path)
    for row in range(6, book["Run 7"].max_row + 1):
        book["Run 7"].cell(row, 1).value = "=ROW()"
    book.save(path)
    with pytest.raises(RecordingError, match="formulas have values only in a workbook that Excel has saved"):
        made(path, SHEET)


def test_a_damaged_workbook_is_refused_in_one_line(workbook):
    path, _ = workbook
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(RecordingError, match=r"run\.xlsx: the workbook cannot be read: got .*; save it as \.xlsx, or as CSV"):
        made(path, SHEET)


def test_without_its_library_a_workbook_names_the_group(workbook, monkeypatch):
    path, _ = workbook
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'hsr_pin\[import\]'"):
        made(path, SHEET)


def matlab_variables(lab):
    """A struct of signals with time, as Simulink logs it, and a struct array of muscles; other sizes are of no use."""
    every = numbers(lab)
    muscles = np.array([(every[:, 7], "left"), (every[:, 8], "right")], dtype=[("Data", "O"), ("Name", "O")])
    places = {"base": every[:, 1:4], "tip": every[:, 4:7].T}
    return {
        "log": {"time": every[:, 0], "signals": {"values": places}},
        "muscle": muscles,
        "gain": every[:, 9],
        "rate": 120.0,
        "title": "run",
    }


MATLAB = """\
[time]
column = "log.time"
[space]
unit = "mm"
up = "+z"
[points]
base = ["log.signals.values.base(:,1)", "log.signals.values.base(:,2)", "log.signals.values.base(:,3)"]
tip = ["log.signals.values.tip(1,:)", "log.signals.values.tip(2,:)", "log.signals.values.tip(3,:)"]
[input]
tau = "(muscle(2).Data - muscle(1).Data) * gain / 2"
"""


def write_hdf5(path, variables):
    """Write variables as MATLAB does with -v7.3: structs as groups, struct arrays as references, arrays transposed."""
    import h5py

    def put(group, name, value):
        if isinstance(value, dict):
            inner = group.create_group(name)
            inner.attrs["MATLAB_class"] = np.bytes_("struct")
            for key, each in value.items():
                put(inner, key, each)
        elif isinstance(value, str):
            data = group.create_dataset(name, data=np.array([[ord(letter)] for letter in value], dtype=np.uint16))
            data.attrs["MATLAB_class"] = np.bytes_("char")
        elif getattr(value, "dtype", None) is not None and value.dtype.names:
            inner = group.create_group(name)
            inner.attrs["MATLAB_class"] = np.bytes_("struct")
            for field in value.dtype.names:
                references = []
                for each in value[field]:
                    put(group.file.require_group("#refs#"), key := f"r{len(group.file['#refs#'])}", each)
                    references.append([group.file["#refs#"][key].ref])
                inner.create_dataset(field, data=np.array(references, dtype=object), dtype=h5py.ref_dtype)
        else:
            array = np.atleast_2d(np.asarray(value, dtype=float))
            array = array.T if np.ndim(value) == 1 else array
            group.create_dataset(name, data=array.T).attrs["MATLAB_class"] = np.bytes_("double")

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, value in variables.items():
            put(file, name, value)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")


def matlab_file(form, path, variables):
    if form == "7.3":
        pytest.importorskip("h5py", reason="needs h5py (group import)")
        write_hdf5(path, variables)
    else:
        savemat(path, variables, do_compression=form == "compressed")
    return path


@pytest.mark.parametrize("form", ["5", "compressed", "7.3"])
def test_a_matlab_file_comes_in_by_the_names_that_matlab_has(tmp_path, laboratory, form):
    lab = laboratory()
    agrees(made(matlab_file(form, tmp_path / "run.mat", matlab_variables(lab)), MATLAB), lab)


@pytest.mark.parametrize("form", ["5", "7.3"])
def test_commands_of_another_rate_in_the_same_file_have_a_time_of_their_own(tmp_path, laboratory, form):
    lab = laboratory()
    slow = slice(0, None, 10)
    variables = matlab_variables(lab) | {"tc": lab.time[slow], "u": lab.torque[slow]}
    text = MATLAB[: MATLAB.index("[input]")] + '[input]\ntau = "u"\ntime = "tc"\n'
    trajectory = made(matlab_file(form, tmp_path / "run.mat", variables), text).dataset.trials[0].trajectory
    assert np.allclose(trajectory.torque, np.repeat(lab.torque[slow], 10)[: len(lab.time)])


def test_a_mapping_is_guessed_from_matrices(tmp_path, laboratory):
    lab = laboratory()
    savemat(tmp_path / "run.mat", {"t": lab.time, "tip": lab.positions[:, 2], "base": lab.positions[:, 0], "tau": lab.torque})
    text = guessed_mapping(tmp_path / "run.mat")
    trajectory = made(tmp_path / "run.mat", text).dataset.trials[0].trajectory
    assert np.allclose(trajectory.torque, lab.torque)
    assert np.abs(trajectory.positions - lab.world[:, [0, 2]]).max() < 2e-6


REFUSED = {
    "objects": (lambda path: savemat(path, {"name": "a table"}), "expected variables that are arrays of numbers"),
    "text of Octave": (lambda path: path.write_text("# Created by Octave 8.4\n# name: t\n"), "save -v7 FILE.mat"),
    "no MATLAB file": (lambda path: path.write_bytes(b"\x00\x01garbage" * 40), "the MATLAB file cannot be read"),
    "damaged": (lambda path: path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM\x0e"), "cannot be read"),
    "damaged HDF5": (lambda path: path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(600)), "cannot be read"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_table_of_matlab_is_refused_in_one_line(tmp_path, case):
    write, said = REFUSED[case]
    if "HDF5" in case:
        pytest.importorskip("h5py", reason="needs h5py (group import)")
    write(tmp_path / "run.mat")
    with pytest.raises(RecordingError) as caught:
        made(tmp_path / "run.mat", MATLAB)
    assert said in str(caught.value) and str(tmp_path / "run.mat") in str(caught.value)


def test_without_its_library_a_file_of_version_7_3_names_the_group(tmp_path, monkeypatch):
    (tmp_path / "run.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(600))
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingDependencyError, match=r"pip install 'hsr_pin\[import\]'"):
        made(tmp_path / "run.mat", MATLAB)


def test_an_unknown_name_in_a_formula_says_which_where_and_lists_the_names(tmp_path, laboratory):
    lab = laboratory()
    np.savetxt(tmp_path / "run.csv", numbers(lab), delimiter=",", comments="", header="Time,a,b,c,d,e,f,left,right,gain")
    text = COLUMNS.replace('"base x", "base y", "base z"', '"a", "b", "c"').replace('"tip x", "tip y", "tip z"', '"d", "e", "f"')
    agrees(made(tmp_path / "run.csv", text), lab)
    with pytest.raises(RecordingError) as caught:
        made(tmp_path / "run.csv", text.replace("(right - left)", "(right - lft)"))
    said = "run.csv:1:1: formula '(right - lft) * gain / 2' in map.toml: expected known names only, got 'lft'; "
    assert str(caught.value).endswith(said + "did you mean 'left'? the names are Time, a, b, c, d, e, f, left, right, gain")
    with pytest.raises(RecordingError, match=r"run\.csv:2:\d+: formula '.*': expected a finite value, got inf"):
        made(tmp_path / "run.csv", text.replace("* gain / 2", "/ (gain - gain)").replace("right - left", "right + left"))


def test_columns_without_names_are_numbered_in_a_formula(tmp_path, laboratory):
    lab = laboratory()
    np.savetxt(tmp_path / "run.csv", numbers(lab), delimiter=",")
    text = COLUMNS.replace('"Time"', "1").replace('"base x", "base y", "base z"', "2, 3, 4")
    text = text.replace('"tip x", "tip y", "tip z"', "5, 6, 7").replace("(right - left) * gain / 2", "($9 - $8) * $10 / 2")
    agrees(made(tmp_path / "run.csv", text + "[file]\nheader = 0\n"), lab)


REST = COLUMNS.replace('column = "Time"', "rest = true")


@pytest.fixture
def poses(tmp_path, laboratory):
    """A table of poses at rest in any order, without times, and the poses [m] and torques [N m]."""
    lab = laboratory()
    rows = np.random.default_rng(4).permutation(len(lab.time))[:40]
    np.savetxt(tmp_path / "run.csv", numbers(lab)[rows, 1:], delimiter=",", comments="", header="a,b,c,d,e,f,left,right,gain")
    text = REST.replace('"base x", "base y", "base z"', '"a", "b", "c"').replace('"tip x", "tip y", "tip z"', '"d", "e", "f"')
    return tmp_path / "run.csv", text, lab.world[rows][:, [0, 2]], lab.torque[rows]


def test_each_row_of_poses_at_rest_is_a_trial(poses):
    path, text, places, torques = poses
    write_dataset(made(path, text).dataset, path.parent / "arm")
    trials = read_dataset(path.parent / "arm").trials
    assert len(trials) == len(places)
    for trial, place, torque in zip(trials, places, torques, strict=True):
        assert np.abs(trial.trajectory.positions - place).max() < 2e-6
        assert np.ptp(trial.trajectory.torque) == 0 and np.isclose(trial.trajectory.torque[0], torque)
        assert trial.starts_at_rest


def test_poses_at_rest_have_no_times(poses):
    path, text, _, _ = poses
    with pytest.raises(RecordingError, match=r"map\.toml:2:1: rest: expected rest = true alone"):
        made(path, text.replace("rest = true", "rest = true\nrate = 10"))
    with pytest.raises(InputError, match=r"poses at rest: expected no --cut"):
        made(path, text, cut="auto")


@pytest.mark.parametrize("name", ["run.xlsx", "run.mat"])
def test_without_a_mapping_they_are_told_of_it(tmp_path, name, laboratory):
    if name.endswith("xlsx"):
        pytest.importorskip("openpyxl", reason="needs openpyxl (group import)").Workbook().save(tmp_path / name)
    else:
        savemat(tmp_path / name, {"t": laboratory().time})
    with pytest.raises(RecordingError, match="need a mapping") as caught:
        read_capture(tmp_path / name)
    assert "\\x" not in str(caught.value)


BOTH = """
P1 = "left"
P1_command = "asked"
P2 = "right"
unit = "kPa"
"""


@pytest.mark.parametrize("separate", [False, True])
def test_what_was_measured_and_what_was_commanded_come_in_together(tmp_path, laboratory, separate):
    """The command stands in one row of ten only, as loggers write what has changed."""
    lab = laboratory()
    every = numbers(lab)
    asked = np.where(np.arange(len(lab.time)) % 10 == 0, np.round(every[:, 8]), np.nan)
    rows = np.column_stack([every, asked])
    header = "Time,a,b,c,d,e,f,left,right,gain,asked"
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", comments="", header=header)
    text = COLUMNS.replace('"base x", "base y", "base z"', '"a", "b", "c"').replace('"tip x", "tip y", "tip z"', '"d", "e", "f"')
    text = text[: text.index("tau =")] + BOTH
    inputs = {"inputs": [tmp_path / "log.csv"]} if separate else {}
    (tmp_path / "log.csv").write_bytes((tmp_path / "run.csv").read_bytes())
    (trial,) = made(tmp_path / "run.csv", text, **inputs).dataset.trials
    assert np.allclose(trial.trajectory.pressures, every[:, 7:9] / 100)
    assert np.allclose(trial.trajectory.commanded[:, 0], np.repeat(asked[::10], 10)[: len(lab.time)] / 100)
    assert np.isnan(trial.trajectory.commanded[:, 1]).all()
    assert trial.interpolated


def test_a_command_without_its_measured_value_is_an_unknown_key(tmp_path, laboratory):
    with pytest.raises(RecordingError, match="unknown key 'P3_command'"):
        made(tmp_path / "run.csv", COLUMNS + 'P3_command = "x"\n')

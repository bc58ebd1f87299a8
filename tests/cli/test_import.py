"""hsr-import turns a capture into a dataset, or says in one line why it cannot."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.cli.command import run
from hsr_pin.cli.import_ import command
from hsr_pin.recordings.read import read_dataset

ARM = ["--mass", "0.15", "--diameter", "0.04", "--keq", "1.11"]
MARKERS = ["--base", "base", "-m", "mid@0.12=Arm:mid", "-m", "tip@0.24=Arm:tip"]


@pytest.fixture
def take(tmp_path):
    """A Vicon Nexus file of a hanging arm that swings in the laboratory's x-z plane, and its input."""
    time = np.arange(200) / 100
    angle = np.sin(3 * time) + 1e-9
    lines = ["Trajectories", "100", ",,Arm:base,,,Arm:mid,,,Arm:tip", "Frame,Sub Frame" + ",X,Y,Z" * 3, "," + ",mm" * 9]
    for frame, bent in enumerate(angle):
        row = [str(frame + 1), "0"]
        for arc in (0.0, 120.0, 240.0):
            k = bent * arc / 240 or 1e-12
            row += [f"{arc * (1 - np.cos(k)) / k + 500:.5f}", "0.00001", f"{900 - arc * np.sin(k) / k:.5f}"]
        lines.append(",".join(row))
    path = tmp_path / "take.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    (tmp_path / "input.csv").write_text(
        "t,tau\n" + "\n".join(f"{t},{a}" for t, a in zip(time, angle, strict=True)), encoding="utf-8"
    )
    return path


def complaint(capsys, arguments):
    """The one line that a refused command says."""
    assert run(command, [str(argument) for argument in arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("hsr-import: error: ")
    assert err.count("\n") == 1
    return err


def test_a_capture_becomes_a_dataset(take, tmp_path, capsys):
    arguments = [
        str(take),
        "-o",
        str(tmp_path / "arm"),
        *ARM,
        *MARKERS,
        "--input",
        str(tmp_path / "input.csv"),
        "--damping",
        "0.05",
    ]
    assert run(command, arguments) == 0
    dataset = read_dataset(tmp_path / "arm")
    trial = dataset.trials[0]
    assert (dataset.name, dataset.mount, dataset.length, trial.keq, trial.damping) == ("arm", "hanging", 0.24, 1.11, 0.05)
    assert [marker.name for marker in dataset.markers] == ["base", "mid", "tip"]
    tip = trial.trajectory.marker("tip")
    assert np.abs(tip[0] - [0, 0, -0.24]).max() < 1e-6
    assert np.corrcoef(tip[:, 0], trial.trajectory.torque)[0, 1] > 0.95
    said = capsys.readouterr().out
    assert "trial_01" in said
    assert "x is the direction of bending as the input rises" in said


def test_the_points_of_a_file_can_be_listed(take, capsys):
    assert run(command, [str(take), "--list"]) == 0
    said = capsys.readouterr().out
    assert all(name in said for name in ("Arm:base", "Arm:mid", "Arm:tip"))
    assert f"{take}: Vicon CSV, 200 frames, 1.990 s, 100 Hz, in mm, +z up by the convention of Vicon" in said


def test_the_list_tells_gaps(take, capsys):
    lines = take.read_text(encoding="utf-8").split("\n")
    for row in (*range(50, 80), 150):
        fields = lines[row].split(",")
        lines[row] = ",".join([*fields[:5], "", "", "", *fields[8:]])
    take.write_text("\n".join(lines), encoding="utf-8")
    assert run(command, [str(take), "--list"]) == 0
    row = next(line for line in capsys.readouterr().out.split("\n") if "Arm:mid" in line)
    assert [cell.strip() for cell in row.split("│")][2:5] == ["84%", "2", "0.3"]


def test_a_table_of_no_known_system_comes_in_with_a_mapping(tmp_path, capsys):
    rows = ["clock;base x;base y;base z;tip x;tip y;tip z"]
    for n in range(100):
        angle = np.sin(n / 15) + 1e-6
        tip = 240 * np.array([(1 - np.cos(angle)) / angle, 0, -np.sin(angle) / angle])
        rows.append(";".join(f"{value:.5f}".replace(".", ",") for value in (n / 50, 1, 2, 3, *(tip + np.arange(1, 4)))))
    (tmp_path / "log.csv").write_text("\n".join(rows), encoding="utf-8")
    points = 'base = ["base x", "base y", "base z"]\ntip = ["tip x", "tip y", "tip z"]\n'
    text = '[time]\ncolumn = "clock"\n[space]\nunit = "mm"\nup = "+z"\n[points]\n'
    (tmp_path / "map.toml").write_text(text + points, encoding="utf-8")
    given = [tmp_path / "log.csv", "--map", tmp_path / "map.toml"]
    assert run(command, [str(one) for one in (*given, "--list")]) == 0
    assert "table, by map.toml" in capsys.readouterr().out
    assert run(command, [str(one) for one in (*given, "-o", tmp_path / "arm", *ARM)]) == 0
    assert np.ptp(read_dataset(tmp_path / "arm").trials[0].trajectory.marker("tip")[:, 0]) > 0.1


def test_what_looks_wrong_is_a_warning_on_the_error_stream(take, tmp_path, capsys):
    lines = take.read_text(encoding="utf-8").split("\n")
    for row, line in enumerate(lines[5:], 5):  # as if the tip swung across, too
        fields = line.split(",")
        lines[row] = ",".join([*fields[:9], f"{60 * np.sin(row / 7):.5f}", *fields[10:]])
    take.write_text("\n".join(lines), encoding="utf-8")
    assert run(command, [str(take), "-o", str(tmp_path / "arm"), *ARM, *MARKERS]) == 0
    assert "warning: trial_01: " in capsys.readouterr().err


@pytest.mark.parametrize(
    "missing, said",
    [
        *((f"--{name}", f"{name}: expected --{name}, or {name} under [robot] in --map") for name in ("mass", "diameter", "keq")),
        ("-o", "Missing option '--output'"),
    ],
)
def test_what_is_needed_is_asked_for(take, tmp_path, capsys, missing, said):
    given = [take, "-o", tmp_path / "arm", *ARM]
    at = given.index(missing)
    assert said in complaint(capsys, given[:at] + given[at + 2 :])


WRONG = {
    "no such file": (["nowhere.csv"], "cannot read the file"),
    "no number": (["--keq", "stiff"], "stiff"),
    "no axis": (["--up", "north"], "up"),
    "no mount": (["--mount", "sideways"], "hanging or upright or horizontal"),
    "no unit": (["--unit", "furlong"], "furlong"),
    "wrong unit": (["--unit", "m"], "check the unit"),
    "no place": (["--origin", "here"], "X,Y,Z"),
    "half a place": (["--origin", "1,2"], "three numbers"),
    "no such point": (["-m", "top=Arm:top"], "did you mean 'Arm:tip'"),
    "no body": (["-m", "=x"], "NAME[@ARC_LENGTH[,RADIUS[,ANGLE]] in m and rad]=POINT"),
    "no input": (["--input", "nowhere.csv"], "cannot read the file"),
    "too many inputs": (["--t-start", "0", "--t-start", "1"], "one value for all files"),
    "unknown option": (["--lenght", "1"], "--length"),
}


@pytest.mark.parametrize("wrong, said", WRONG.values(), ids=WRONG)
def test_bad_input_is_one_line_and_nothing_is_written(take, tmp_path, capsys, wrong, said):
    before = sorted(tmp_path.iterdir())
    assert said in complaint(capsys, [take, "-o", tmp_path / "arm", *ARM, *MARKERS, *wrong])
    assert sorted(tmp_path.iterdir()) == before


def test_a_folder_with_something_else_in_it_is_left_alone(take, tmp_path, capsys):
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "thesis.tex").write_text("precious", encoding="utf-8")
    assert "will not replace" in complaint(capsys, [take, "-o", tmp_path / "arm", *ARM, *MARKERS])
    assert [path.name for path in (tmp_path / "arm").iterdir()] == ["thesis.tex"]


def test_a_dataset_that_it_did_not_write_is_replaced_only_by_force(take, tmp_path, capsys):
    given = [str(one) for one in (take, "-o", tmp_path / "arm", *ARM, *MARKERS)]
    assert run(command, given) == 0
    assert run(command, given) == 0  # what it wrote itself
    declared = tmp_path / "arm" / "dataset.toml"
    lines = declared.read_text(encoding="utf-8").split("\n")
    declared.write_text("\n".join(line for line in lines if not line.startswith("#")), encoding="utf-8")
    capsys.readouterr()
    assert "--force" in complaint(capsys, given)
    assert run(command, [*given, "--force"]) == 0


def test_an_import_that_was_killed_is_told_and_mended_by_the_next(take, tmp_path, capsys):
    given = [str(one) for one in (take, "-o", tmp_path / "arm", *ARM, *MARKERS)]
    assert run(command, given) == 0
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    (tmp_path / "arm").rename(tmp_path / f".arm.{ended.pid}.ab12.old")  # killed between its two renames
    for token in (".ab12", ""):
        (tmp_path / f".arm.{ended.pid}{token}.part").mkdir()
    capsys.readouterr()
    assert run(command, given) == 0
    said = capsys.readouterr().err.splitlines()
    assert len(said) == 3 and all(line.startswith(f"warning: {tmp_path / 'arm'}: ") for line in said)
    assert f"restored from .arm.{ended.pid}.ab12.old" in said[0]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm", "input.csv", "take.csv"]


def test_recordings_that_a_killed_import_hid_are_there_again_even_where_the_next_is_refused(take, tmp_path, capsys):
    given = [str(one) for one in (take, "-o", tmp_path / "arm", *ARM, *MARKERS)]
    assert run(command, given) == 0
    declared = tmp_path / "arm" / "dataset.toml"
    declared.write_text(declared.read_text(encoding="utf-8").replace("# imported from ", "# "), encoding="utf-8")
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    (tmp_path / "arm").rename(tmp_path / f".arm.{ended.pid}.ab12.old")
    assert run(command, given) == 2
    assert "--force" in capsys.readouterr().err
    assert read_dataset(tmp_path / "arm").name == "arm"


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="names of files are text there")
def test_a_folder_whose_name_is_no_text_asks_for_a_name(take, tmp_path, capsys):
    folder = os.fsdecode(os.fsencode(tmp_path) + b"/arm\xff")
    assert "give the dataset a name with --name" in complaint(capsys, [take, "-o", folder, *ARM, *MARKERS])
    assert run(command, [str(take), "-o", folder, *ARM, *MARKERS, "--name", "arm"]) == 0
    assert read_dataset(folder).name == "arm"


def test_help_loads_nothing_heavy():
    program = (
        "import sys; sys.argv = ['hsr-import', '--help']\n"
        "from hsr_pin.cli import import_\n"
        "code = import_.run(import_.command)\n"
        "heavy = {'numpy', 'scipy', 'rich', 'ezc3d', 'pinocchio'} & set(sys.modules)\n"
        "sys.exit(f'loaded {heavy}' if heavy else code)"
    )
    repository = Path(__file__).resolve().parents[2]
    shown = subprocess.run([sys.executable, "-c", program], cwd=repository, capture_output=True, text=True, check=False)
    assert shown.returncode == 0, shown.stderr
    assert "--marker" in shown.stdout


def test_the_input_is_moved_as_the_motion_shows_and_the_estimate_is_printed(take, tmp_path, capsys):
    log = tmp_path / "input.csv"
    header, *rows = log.read_text(encoding="utf-8").splitlines()
    late = [f"{float(row.split(',')[0]) + 40:.3f},{row.split(',')[1]}" for row in rows]
    log.write_text("\n".join([header, *late]), encoding="utf-8")
    given = [take, "-o", tmp_path / "arm", *ARM, *MARKERS, "--input", log]
    assert "the clock of the input: expected times of the recording" in complaint(capsys, given)
    assert "'--input-offset': expected a time in s, or auto" in complaint(capsys, [*given, "--input-offset", "soon"])
    assert run(command, [str(one) for one in (*given, "--input-offset", "auto")]) == 0
    said = capsys.readouterr().out
    assert "input moved by -40 +- " in said and "this removes a delay of the arm itself" in said


def test_recordings_of_other_files_are_replaced_only_by_force(take, tmp_path, capsys):
    given = [str(one) for one in (take, "-o", tmp_path / "arm", *ARM, *MARKERS)]
    assert run(command, given) == 0
    capsys.readouterr()
    other = take.rename(tmp_path / "other.csv")
    said = complaint(capsys, [other, *given[1:]])
    assert "expected a dataset imported from the same files, got recordings of take.csv; --force replaces them" in said
    assert run(command, [str(other), *given[1:], "--force"]) == 0
    assert run(command, [str(other), *given[1:]]) == 0


def test_a_mapping_is_guessed_to_be_edited_and_never_written_over(tmp_path, capsys):
    table, mapping = tmp_path / "log.csv", tmp_path / "log.toml"
    table.write_text("t,tip_x,tip_y,tip_z\n" + "".join(f"{n / 50},{n / 100},0,-0.2\n" for n in range(9)), encoding="utf-8")
    assert run(command, ["--guess", str(table)]) == 0
    shown = capsys.readouterr().out
    assert run(command, ["--guess", str(table), "-o", str(mapping)]) == 0
    assert mapping.read_text(encoding="utf-8") == shown and '"tip" = ["tip_x", "tip_y", "tip_z"]' in shown
    capsys.readouterr()
    assert "will not replace the file" in complaint(capsys, ["--guess", table, "-o", mapping])

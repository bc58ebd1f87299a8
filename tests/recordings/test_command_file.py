"""Commands from a file: held from row to row on even steps, every fault with its place."""

import numpy as np
import pytest

from hsr_pin.errors import HsrError, RecordingError
from hsr_pin.recordings.command_file import read_commands


def commands(tmp_path, text, **more):
    path = tmp_path / "input.csv"
    path.write_text(text)
    return read_commands(path, max_pressure=4.0, **more)


def test_rows_are_held_until_the_next(tmp_path):
    read = commands(tmp_path, "t,tau\n0,0\n0.5,0.4\n1.25,-0.1\n2,0\n")
    assert read.time[[0, 1, -1]] == pytest.approx([0, 0.01, 2])
    assert read.pressures is None
    at = dict(zip(np.round(read.time, 6), read.torque, strict=True))
    assert [at[t] for t in (0.0, 0.49, 0.5, 1.24, 1.25, 1.99, 2.0)] == [0, 0, 0.4, 0.4, -0.1, -0.1, 0]
    assert read.note == ""


def test_columns_may_come_in_any_order_and_pressures_are_kept(tmp_path):
    read = commands(tmp_path, "P2,t,P1\n2,0,1\n2.5,1,0.5\n")
    assert read.torque is None
    assert read.pressures[[0, -1]].tolist() == [[1, 2], [0.5, 2.5]]


@pytest.mark.parametrize(("rows", "step"), [((0, 0.1, 0.35), 0.01), ((0, 0.1, 0.355), 0.005), ((0, 0.1, 0.3517), 0.001)])
def test_the_step_is_the_longest_that_every_row_falls_on(tmp_path, rows, step):
    read = commands(tmp_path, "t,tau\n" + "".join(f"{t},{n}\n" for n, t in enumerate(rows)))
    assert read.time[1] - read.time[0] == pytest.approx(step)


def test_an_even_file_keeps_its_own_step(tmp_path):
    read = commands(tmp_path, "t,tau\n" + "".join(f"{n / 120:.9f},{n}\n" for n in range(60)))
    assert len(read.time) == 60
    assert read.torque.tolist() == list(range(60))


def test_rows_that_fall_on_no_step_are_moved_and_it_is_said(tmp_path):
    read = commands(tmp_path, "t,tau\n0,0\n0.12345,1\n1,2\n")
    assert "moved by up to 0.0005 s" in read.note
    assert read.time[np.argmax(read.torque == 1)] == pytest.approx(0.12345, abs=0.0005)


def test_a_duration_holds_the_last_row_or_leaves_rows_away(tmp_path):
    text = "t,tau\n0,0\n0.1,1\n0.5,2\n"
    longer, shorter = commands(tmp_path, text, duration=2.0), commands(tmp_path, text, duration=0.3)
    assert (longer.time[-1], longer.torque[-1]) == (pytest.approx(2.0), 2)
    assert (shorter.time[-1], shorter.torque[-1]) == (pytest.approx(0.3), 1)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time,torque\n0,1\n1,2\n", "input.csv:1:1: header: expected t,P1,P2 or t,tau or t,tau_x,tau_y, got time,torque"),
        ("t,P1\n0,1\n1,2\n", "input.csv:1:1: header"),
        ("t,tau,P1,P2\n0,1,1,1\n1,2,1,1\n", "input.csv:1:1: header"),
        ("t,tau\n0,1\n0,2\n", "input.csv:3:1: column t: expected more than 0 s"),
        ("t,tau\n0,1\n1,\n", "input.csv:3:3: column tau: expected -1000 to 1000 N m, got no value"),
        ("t,tau\n0,1\n1,inf\n", "input.csv:3:3: column tau: expected a finite number"),
        ("t,tau\n0,1\n,2\n", "input.csv:3:1: column t: expected a time [s], got no value"),
        ("t,P1,P2\n0,1,2\n1,1,9\n", "input.csv:3:5: column P2: expected 0 to 4 bar, got 9"),
        ("t,P1,P2\n0,1,2\n1,-1,2\n", "input.csv:3:3: column P1: expected 0 to 4 bar, got -1"),
        ("t,tau\n0,1\n", "input.csv:2:1: commands: expected at least two rows"),
        ("t,tau\n0,1,5\n1,2\n", "input.csv:2:5: row: expected 2 fields, got 3"),
        ("", "input.csv:1:1: the file is empty"),
    ],
)
def test_a_fault_is_named_with_file_line_and_column(tmp_path, text, said):
    with pytest.raises(RecordingError) as caught:
        commands(tmp_path, text)
    assert said in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RecordingError, match=r"gone\.csv: cannot read the file: got No such file"):
        read_commands(tmp_path / "gone.csv", max_pressure=4.0)


@pytest.mark.parametrize("duration", [0.0, -1.0, float("nan"), 1e9])
def test_a_duration_that_cannot_be_is_refused(tmp_path, duration):
    with pytest.raises(HsrError, match="duration: expected"):
        commands(tmp_path, "t,tau\n0,0\n1,1\n", duration=duration)

"""Odd and hostile datasets end in one clear line, soon and in little memory; large ones take time in proportion."""

import os
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.outliers import exchanges
from hsr_pin.recordings.read import read_dataset


def refusal(folder):
    """What a refused dataset is told, in less than 5 s and 200 MB."""
    tracemalloc.start()
    begin = time.perf_counter()
    try:
        with pytest.raises(RecordingError) as caught:
            read_dataset(folder)
        assert time.perf_counter() - begin < 5
        assert tracemalloc.get_traced_memory()[1] < 200e6
    finally:
        tracemalloc.stop()
    assert len(str(caught.value)) < 1000
    return str(caught.value)


@pytest.mark.parametrize("file", ["dataset.toml", "trial_01.csv"])
def test_a_pipe_is_no_file(folder, file):
    (folder / file).unlink()
    os.mkfifo(folder / file)
    assert "expected a regular file, got a pipe" in refusal(folder)


@pytest.mark.parametrize("file", ["dataset.toml", "trial_01.csv"])
@pytest.mark.parametrize("target", ["/dev/zero", "/etc/passwd"])
def test_a_link_out_of_the_folder_is_not_followed_and_nothing_of_what_is_there_is_shown(folder, file, target):
    if not Path(target).exists():
        pytest.skip(f"no {target} here")
    (folder / file).unlink()
    (folder / file).symlink_to(target)
    said = refusal(folder)
    assert "a link out of the folder" in said
    assert "root" not in said.replace(str(folder), "")


def test_a_link_within_the_folder_is_followed(folder):
    (folder / "trial_01.csv").rename(folder / "raw.csv")
    (folder / "trial_01.csv").symlink_to("raw.csv")
    assert len(read_dataset(folder).trials[0].trajectory.time) == 20


@pytest.mark.parametrize("file, most", [("dataset.toml", "8 MB"), ("trial_01.csv", "2,000 MB")])
def test_a_sparse_file_of_20_gb_is_not_read(folder, file, most):
    with (folder / file).open("r+b") as out:
        out.truncate(20_000_000_000)
    assert f"at most {most}, got 20,000 MB" in refusal(folder)


@pytest.mark.parametrize("text", [".".join("a" * 100_000) + "=1", "[" + ".".join("a" * 100_000) + "]", "x = " + "[" * 100_000])
def test_keys_of_very_many_parts_are_not_parsed(folder, text):
    (folder / "dataset.toml").write_text(text + "\n", encoding="utf-8")
    assert "nested too deeply" in refusal(folder)


def test_a_line_without_an_end_takes_little_more_memory_than_the_file(folder):
    size = 150_000_000
    with (folder / "trial_01.csv").open("r+b") as out:
        out.truncate(size)
    tracemalloc.start()
    try:
        with pytest.raises(RecordingError, match="not a CSV table"):
            read_dataset(folder)
        assert tracemalloc.get_traced_memory()[1] < 2 * size
    finally:
        tracemalloc.stop()


def test_more_markers_than_an_arm_carries_are_refused(folder):
    text = (folder / "dataset.toml").read_text(encoding="utf-8")
    more = "".join(f'[[marker]]\nname = "m{number}"\narc_length = 0.1\n' for number in range(1000))
    (folder / "dataset.toml").write_text(f"{text}\n{more}", encoding="utf-8")
    assert "markers: expected at most 200, got 100" in refusal(folder)


def test_a_hundred_markers_are_followed_in_little_memory():
    positions = np.random.default_rng(0).normal(size=(1, 100, 3)) + np.zeros((4000, 1, 1))
    positions[2000:, :2] = positions[2000:, 1::-1]  # two change names
    tracemalloc.start()
    found = exchanges(positions)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (found[:2000] != found[2000:]).sum() == 2 * 2000
    assert peak < 200e6


def test_dots_in_a_text_or_a_comment_are_no_depth(folder, spoil):
    spoil("dataset.toml", 'name = "known"', 'name = "' + "etc. " * 100 + '"  # ' + "." * 200)
    assert len(read_dataset(folder).trials) == 1


def test_very_many_unknown_columns_are_refused_soon(folder):
    header, *rows = (folder / "trial_01.csv").read_text(encoding="utf-8").splitlines()
    more = 100_000
    lines = [header + "," + ",".join(f"c{n}" for n in range(more)), *(row + ",1" * more for row in rows)]
    (folder / "trial_01.csv").write_text("\n".join(lines), encoding="utf-8")
    assert "unknown column 'c0'" in refusal(folder)


def many_trials(folder, count):
    declaration, table = ((folder / name).read_text(encoding="utf-8") for name in ("dataset.toml", "trial_01.csv"))
    trials = "".join(f'[[trial]]\nfile = "run_{n:05d}.csv"\n' for n in range(count))
    (folder / "dataset.toml").write_text(declaration[: declaration.index("[[trial]]")] + trials, encoding="utf-8")
    for n in range(count):
        (folder / f"run_{n:05d}.csv").write_text(table, encoding="utf-8")


def test_time_grows_in_proportion(folder):
    spent = []
    original = [(name, (folder / name).read_text(encoding="utf-8")) for name in ("dataset.toml", "trial_01.csv")]
    for count in (300, 1200):
        for name, text in original:
            (folder / name).write_text(text, encoding="utf-8")
        many_trials(folder, count)
        spent.append(min(_seconds(folder) for _ in range(2)))
    assert spent[1] < 10 * spent[0]  # four times as much; quadratic would be sixteen


def _seconds(folder):
    begin = time.process_time()
    read_dataset(folder)
    return time.process_time() - begin


UNITS = [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")]


@pytest.mark.parametrize("factor, unit", UNITS)
def test_times_in_another_unit_are_asked_about(folder, factor, unit):
    header, *rows = (folder / "trial_01.csv").read_text(encoding="utf-8").splitlines()
    cells = [row.split(",") for row in rows]
    lines = [header, *(",".join([f"{factor * float(row[0]):.0f}", *row[1:]]) for row in cells)]
    (folder / "trial_01.csv").write_text("\n".join(lines), encoding="utf-8")
    said = refusal(folder)
    assert f"if these are {unit}," in said
    assert "trial_01.csv:4:1: time" in said


def test_a_recording_of_hours_is_refused(folder):
    header, *rows = (folder / "trial_01.csv").read_text(encoding="utf-8").splitlines()
    cells = [row.split(",") for row in rows]
    lines = [header, *(",".join([f"{0.4 * n:.1f}", *cells[n % 20][1:]]) for n in range(10_000))]
    (folder / "trial_01.csv").write_text("\n".join(lines), encoding="utf-8")
    assert "at most 3600 s, got 3999.6 s" in refusal(folder)


def test_a_table_is_read_in_memory_for_little_more_than_its_numbers(folder):
    header, *rows = (folder / "trial_01.csv").read_text(encoding="utf-8").splitlines()
    cells = [row.split(",")[1:] for row in rows]
    lines = [header, *(",".join([f"{n / 1000:.3f}", *cells[n % 20]]) for n in range(150_000))]
    (folder / "trial_01.csv").write_text("\n".join(lines), encoding="utf-8")
    size = (folder / "trial_01.csv").stat().st_size
    tracemalloc.start()
    read = read_dataset(folder)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    numbers = 150_000 * 8 * 8
    assert len(read.trials[0].trajectory.time) == 150_000
    assert np.ptp(np.diff(read.trials[0].trajectory.time)) < 1e-9
    assert most < 2 * size + 8 * numbers

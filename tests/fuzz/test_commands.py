"""Whatever a dataset looks like, every command ends: with a result, or with one line that says what is wrong.

Datasets are changed part by part (``mutations``), and each goes through a command of the mix (``commands``), in this process.
An exception that no one documented, a number that is none, a second line, a file left behind or 20 s are failures. The same
datasets each time: Hypothesis draws them from the name of the test.
"""

import time
from contextlib import suppress
from random import Random
from types import SimpleNamespace

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from hsr_pin.cli.command import run
from hsr_pin.errors import RecordingError
from hsr_pin.recordings.read import read_dataset

from .commands import TABLE
from .drafts import KINDS, copied, drafts
from .judging import PATIENCE, SETTINGS, at_most, interrupted, judge, judge_files
from .mutations import MUTATIONS
from .slight import SLIGHT


def changes(kinds):
    """One to three of them, each with the seed of its random numbers."""
    one = st.tuples(st.sampled_from(list(kinds)), st.integers(0, 1 << 16))
    return st.lists(one, min_size=1, max_size=3, unique_by=lambda change: change[0])


CHANGES, SLIGHTLY = changes(MUTATIONS), changes(SLIGHT)
COMMANDS = st.sampled_from([row for row in TABLE for _ in range(row[0])])


@pytest.fixture(scope="module")
def made():
    """Datasets without a fault."""
    return drafts()


@pytest.fixture
def end(made, tmp_path, monkeypatch, capsys):
    """``end(kind, changes, row)``: put a changed dataset through a command and look at how it ends, in a word."""
    count = 0

    def one(kind, changes, row):
        nonlocal count
        count += 1
        place = tmp_path / str(count)
        place.mkdir()
        monkeypatch.chdir(place)
        monkeypatch.setattr("hsr_pin.cli.view.time", SimpleNamespace(sleep=interrupted))  # the page is up
        draft = copied(made[kind])
        for name, seed in changes:
            (MUTATIONS | SLIGHT)[name](draft, Random(seed))
        _, command, arguments, document = row
        arguments = arguments(draft.write(place / "data"))
        capsys.readouterr()
        with at_most(PATIENCE):
            code = run(command, arguments)
        out, err = capsys.readouterr()
        judge(command.name, code, out, err, document, writes=any(argument.startswith("out") for argument in arguments))
        judge_files(place, code)
        return f"{command.name}: exit code {code}"

    return one


@settings(SETTINGS, max_examples=100)
@given(st.sampled_from(KINDS), CHANGES, COMMANDS)
def test_of_100_odd_datasets_each_ends_in_a_result_or_one_line(end, kind, changes, row):
    event(end(kind, changes, row))


@pytest.mark.long
@settings(SETTINGS, max_examples=2000)
@given(st.sampled_from(KINDS), CHANGES, COMMANDS)
def test_of_2000_odd_datasets_each_ends_in_a_result_or_one_line(end, kind, changes, row):
    event(end(kind, changes, row))


@settings(SETTINGS, max_examples=40)
@given(st.sampled_from(KINDS), SLIGHTLY, COMMANDS)
def test_of_40_datasets_a_little_off_each_ends_in_a_result_or_one_line(end, kind, changes, row):
    event(end(kind, changes, row))


@pytest.mark.long
@settings(SETTINGS, max_examples=2000)
@given(st.sampled_from(KINDS), SLIGHTLY, COMMANDS)
def test_of_2000_datasets_a_little_off_each_ends_in_a_result_or_one_line(end, kind, changes, row):
    event(end(kind, changes, row))


def test_most_datasets_that_are_a_little_off_are_read(made, tmp_path):
    random, read = Random(0), 0
    for number in range(100):
        draft = copied(made[random.choice(KINDS)])
        for name in random.sample(list(SLIGHT), random.randint(1, 3)):
            SLIGHT[name](draft, random)
        with suppress(RecordingError):
            read += bool(read_dataset(draft.write(tmp_path / str(number))))
    assert read > 75


@pytest.mark.parametrize("row", TABLE, ids=[f"{row[1].name}-{number}" for number, row in enumerate(TABLE)])
def test_a_dataset_without_a_fault_goes_through_every_command(end, row):
    assert end("torque", [], row).endswith("exit code 0")


@pytest.mark.parametrize(
    ("code", "out", "err"),
    [
        (1, "", ""),
        (0, "tip 3.2 mm\n", "RuntimeWarning: divide by zero\n"),
        (0, "tip nan mm\n", ""),
        (0, "tip \x1b[2J\n", ""),
        (2, "", "Traceback (most recent call last):\n"),
        (2, "", "hsr-sim: error: one\nand another\n"),
        (2, "", "hsr-sim: error: " + "x" * 5000 + "\n"),
        (2, "tip 3.2 mm\n", "hsr-sim: error: no such dataset\n"),
    ],
)
def test_a_bad_end_would_be_seen(code, out, err):
    with pytest.raises(AssertionError):
        judge("hsr-sim", code, out, err, document=False)


def test_a_document_with_no_number_a_half_file_and_a_late_answer_would_be_seen(tmp_path):
    with pytest.raises(pytest.fail.Exception):
        judge("hsr-sim", 0, '{"rms": NaN}', "", document=True)
    (tmp_path / ".out.json.12.part").write_text("{")
    with pytest.raises(AssertionError):
        judge_files(tmp_path, 0)
    with pytest.raises(TimeoutError), at_most(0.05):
        time.sleep(5)

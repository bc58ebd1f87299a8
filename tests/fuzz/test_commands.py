"""Whatever a dataset looks like, every command ends: with a result, or with one line that says what is wrong.

Datasets are changed part by part (``mutations``), and each goes through a command of the mix (``commands``), in this process.
An exception that no one documented, a number that is none, a second line, a file left behind or 20 s are failures. The same
datasets each time: Hypothesis draws them from the name of the test.
"""

import json
import re
import signal
import time
from contextlib import contextmanager
from random import Random
from types import SimpleNamespace

import pytest
from hypothesis import HealthCheck, Phase, event, given, settings
from hypothesis import strategies as st

from hsr_pin.cli.command import run
from hsr_pin.recordings.read import read_dataset

from .commands import TABLE
from .drafts import KINDS, copied, drafts
from .mutations import MUTATIONS

#: No command takes longer for a dataset of a second [s].
PATIENCE = 20
_NO_NUMBER = re.compile(r"\b(nan|inf|NaN|Infinity)\b")

SETTINGS = settings(
    derandomize=True,
    report_multiple_bugs=False,
    phases=(Phase.generate,),  # what fails has three changes at most: nothing to shrink, for minutes
    deadline=None,
    database=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow, HealthCheck.data_too_large],
)
CHANGES = st.lists(
    st.tuples(st.sampled_from(list(MUTATIONS)), st.integers(0, 1 << 16)),
    min_size=1,
    max_size=3,
    unique_by=lambda change: change[0],
)
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
            MUTATIONS[name](draft, Random(seed))
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


def interrupted(_):
    """Ctrl-C, instead of waiting for it."""
    raise KeyboardInterrupt


@contextmanager
def at_most(seconds):
    """Raise a TimeoutError after so long, where the system can."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def late(*_):
        raise TimeoutError(f"longer than {seconds} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def judge(name, code, out, err, document, writes=False):
    """That a command ended as commands end; one that cannot write what it found has said it before."""
    assert code in (0, 2)
    if code == 2:
        assert err.startswith(f"{name}: error: ")
        assert err.count("\n") == 1 and err[:-1].isprintable() and len(err) < 2000
        if not writes:
            assert out == ""
        if not out:
            return
    else:
        assert all(line.startswith("warning: ") and line.isprintable() for line in err.splitlines())
    if document:
        json.loads(out, parse_constant=pytest.fail)
    else:
        assert not _NO_NUMBER.search(out)
    assert all(line.isprintable() for line in out.splitlines())


def judge_files(place, code):
    """That files are whole, and none is there after a refusal."""
    written = [path for path in place.iterdir() if path.name.startswith((".", "out"))]
    assert not written or code == 0
    for path in written:
        if path.is_dir():
            read_dataset(path)
            continue
        content = path.read_bytes()
        assert content and not path.name.startswith(".")
        if path.suffix == ".json":
            json.loads(content, parse_constant=pytest.fail)
        elif path.suffix == ".urdf":
            text = content.decode("utf-8").replace('torsion="inf"', "")  # of a backbone that does not twist
            assert not _NO_NUMBER.search(text)


@settings(SETTINGS, max_examples=200)
@given(st.sampled_from(KINDS), CHANGES, COMMANDS)
def test_of_200_odd_datasets_each_ends_in_a_result_or_one_line(end, kind, changes, row):
    event(end(kind, changes, row))


@pytest.mark.long
@settings(SETTINGS, max_examples=2000)
@given(st.sampled_from(KINDS), CHANGES, COMMANDS)
def test_of_2000_odd_datasets_each_ends_in_a_result_or_one_line(end, kind, changes, row):
    event(end(kind, changes, row))


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

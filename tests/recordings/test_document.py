"""Whatever the bytes of a dataset, the answer is a dataset or an error of ours."""

import contextlib
import math
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.document import places, read_document
from hsr_pin.recordings.read import read_dataset

QUICK = settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])

TEXT = '''\
format = 1
note = """
[robot]
length = 3
"""

  [robot]
"length" = 0.24
[[trial]]
file = "a.csv"
[[trial]]
file = 'b.csv'
[a.b]
c.d = 1
'''


def test_every_key_knows_its_line_and_column():
    assert places(TEXT) == {
        ("format",): (1, 1),
        ("note",): (2, 1),
        ("robot",): (7, 3),
        ("robot", "length"): (8, 1),
        ("trial", 0): (9, 1),
        ("trial", 0, "file"): (10, 1),
        ("trial", 1): (11, 1),
        ("trial", 1, "file"): (12, 1),
        ("a", "b"): (13, 1),
        ("a", "b", "c", "d"): (14, 1),
    }


def test_a_key_inside_of_a_line_is_placed_where_its_table_begins(tmp_path):
    path = tmp_path / "dataset.toml"
    path.write_text('format = 1\nrobot = {length = "long"}\n', encoding="utf-8")
    with pytest.raises(RecordingError) as caught:
        read_document(path).section("robot").number("length", "m")
    assert (caught.value.line, caught.value.column) == (2, 1)


@pytest.mark.parametrize(
    "text", ["[" * 5000, "a = " + "[" * 5000, "a = " + "1" * 5000, "a = 2026-13-45", 'a = "\\ud800"', "a = 1\ra = 2"]
)
def test_what_is_no_toml_is_an_error_of_ours(tmp_path, text):
    path = tmp_path / "dataset.toml"
    path.write_bytes(text.encode())
    with pytest.raises(RecordingError, match="invalid TOML"):
        read_document(path)


#: Lines on which patterns that take the same signs twice need time by the square or the cube.
LONG = [" " * 500, " \t" * 250, "[" + " " * 498, "a " * 250, "a." * 250, '"' + '\\"' * 40_000]


@pytest.mark.parametrize("line", LONG, ids=lambda line: repr(line[:4]))
def test_lines_of_nothing_take_time_in_proportion(tmp_path, line):
    path = tmp_path / "dataset.toml"
    path.write_text("\n".join([line] * max(1, 100_000 // len(line))), encoding="utf-8")
    begin = time.process_time()
    places(path.read_text(encoding="utf-8"))
    with contextlib.suppress(RecordingError):  # of blanks alone it is one
        read_document(path)
    assert time.process_time() - begin < 0.5


def read_or_refuse(declaration: bytes, table: bytes):
    """A dataset of these bytes; None if it is refused with an error of ours that names a file."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "dataset.toml").write_bytes(declaration)
        (folder / "trial_01.csv").write_bytes(table)
        try:
            return read_dataset(folder)
        except RecordingError as error:
            assert error.file is not None
            assert "\n" not in str(error)
            return None


def pieces(folder):
    return [(folder / file).read_bytes() for file in ("dataset.toml", "trial_01.csv")]


def mutated(content: bytes, cuts) -> bytes:
    for start, length, insert in cuts:
        at = start % (len(content) + 1)
        content = content[:at] + insert + content[at + length :]
    return content


INSERTS = st.one_of(
    st.binary(max_size=6),
    st.text(max_size=6).map(lambda text: text.encode("utf-8", "surrogatepass")),
    st.sampled_from(
        [b"nan", b"inf", b"-1e308", b"1e999", b"\n", b",", b'"', b"'''", b"[[", b"=", b"\0", b"{}", b"true", b"9e9", b"\r"]
    ),
)
CUTS = st.lists(st.tuples(st.integers(0, 2000), st.integers(0, 8), INSERTS), min_size=1, max_size=4)


@QUICK
@given(cuts=CUTS)
def test_a_declaration_with_random_bytes_changed_is_read_or_refused(folder, cuts):
    declaration, table = pieces(folder)
    dataset = read_or_refuse(mutated(declaration, cuts), table)
    if dataset is not None:
        assert all(math.isfinite(value) for value in (dataset.length, dataset.mass, dataset.diameter, dataset.trials[0].keq))


@QUICK
@given(cuts=CUTS)
def test_a_table_with_random_bytes_changed_is_read_or_refused_and_loses_no_number(folder, cuts):
    declaration, table = pieces(folder)
    changed = mutated(table, cuts)
    dataset = read_or_refuse(declaration, changed)
    if dataset is None:
        return
    trajectory = dataset.trials[0].trajectory
    missing = int(np.isnan(trajectory.positions).sum())
    fields = [
        field.strip().lower() for row in changed.decode("utf-8-sig").replace("\r", "\n").split("\n") for field in row.split(",")
    ]
    empty = sum(field.strip('"').strip() in ("", "nan") for field in fields)
    assert missing <= empty or trajectory.notes, "numbers became gaps without a word"


@QUICK
@given(
    values=st.lists(
        st.lists(st.one_of(st.floats(), st.floats(-0.3, 0.3), st.just("")), min_size=8, max_size=8), min_size=1, max_size=6
    )
)
def test_any_numbers_in_a_table_are_read_or_refused(folder, values):
    declaration, table = pieces(folder)
    header = table.split(b"\n")[0].decode()
    rows = [",".join("" if value == "" else repr(value) for value in row) for row in values]
    dataset = read_or_refuse(declaration, "\n".join([header, *rows]).encode())
    if dataset is not None:
        trajectory = dataset.trials[0].trajectory
        assert np.isfinite(trajectory.time).all()
        assert np.isfinite(trajectory.torque).all()
        assert not np.isinf(trajectory.positions).any()


@QUICK
@given(st.binary(max_size=200), st.binary(max_size=200))
def test_random_bytes_are_refused(declaration, table):
    assert read_or_refuse(declaration, table) is None

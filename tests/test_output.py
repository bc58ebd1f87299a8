"""A file is written whole or not at all, and what cannot be written is named."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hsr_pin.errors import OutputError
from hsr_pin.output import check_writable, write_bytes, write_text


def test_a_file_is_written_and_replaced_without_leaving_anything_beside_it(tmp_path):
    path = tmp_path / "a.txt"
    write_text(path, "one\nµ\n")
    write_text(path, "two\nµ\n")
    assert path.read_bytes() == "two\nµ\n".encode()
    assert list(tmp_path.iterdir()) == [path]


def test_a_write_that_fails_half_way_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def full_disk(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full_disk)
    with pytest.raises(OutputError, match=r"a\.txt: cannot write the file: .*got No space left on device"):
        write_bytes(path, b"new")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_and_what_it_points_to_is_replaced(tmp_path):
    path, link = tmp_path / "a.txt", tmp_path / "link"
    path.write_text("old")
    link.symlink_to(path)
    write_text(link, "new")
    assert link.is_symlink()
    assert path.read_text() == "new"


@pytest.mark.parametrize("call", [check_writable, lambda path: write_text(path, "text")])
@pytest.mark.parametrize(
    ("name", "reason"), [("file/a.txt", "Not a directory"), ("gone/a.txt", "No such file or directory"), (".", "Is a directory")]
)
def test_a_path_that_cannot_be_written_is_one_line_and_leaves_nothing(tmp_path, call, name, reason):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match=f"cannot write the file: .*got {reason}$") as caught:
        call(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_text() == "mine"


def test_checking_a_path_leaves_everything_as_it_was(tmp_path):
    check_writable(tmp_path / "new.txt")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/stdout").exists(), reason="this system has no /dev/stdout")
def test_standard_output_named_as_a_file_may_be_a_pipe():
    program = "from hsr_pin.output import *; check_writable('/dev/stdout'); write_text('/dev/stdout', 'text')"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout == "text"

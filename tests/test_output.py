"""Files are written completely or not at all, and errors name the file."""

import os
import secrets
import subprocess
import sys
from pathlib import Path

import pytest

from hsr_pin.errors import OutputError
from hsr_pin.output import (
    PAGE_SIGNATURE,
    check_folder_writable,
    check_replaceable,
    check_writable,
    is_ours,
    write_bytes,
    write_text,
)


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


def test_a_file_that_is_replaced_keeps_its_mode(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    for mode in (0o600, 0o644, 0o755):
        path.chmod(mode)
        write_text(path, "new")
        assert path.stat().st_mode & 0o777 == mode


def test_a_draft_is_never_open_to_those_who_may_not_read_the_file(tmp_path, monkeypatch):
    path, modes = tmp_path / "a.txt", []
    path.write_text("old")
    path.chmod(0o600)
    replace = os.replace
    monkeypatch.setattr(os, "replace", lambda draft, target: (modes.append(draft.stat().st_mode & 0o777), replace(draft, target)))
    write_text(path, "new")
    assert modes == [0o600]


@pytest.mark.skipif(sys.platform == "win32", reason="processes are not asked for there")
def test_drafts_of_killed_processes_are_taken_away_and_those_of_running_ones_are_not(tmp_path):
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    lost = [tmp_path / f".a.txt.{ended.pid}{token}.part" for token in ("", ".0f3a")]
    kept = tmp_path / f".a.txt.{os.getppid()}.0f3a.part"
    others = tmp_path / ".a.txt.notes.part", tmp_path / f".b.txt.{ended.pid}.0f3a.part"
    for path in (*lost, kept, *others):
        path.write_text("half")
    write_text(tmp_path / "a.txt", "whole")
    assert sorted(tmp_path.iterdir()) == sorted([kept, *others, tmp_path / "a.txt"])


@pytest.mark.parametrize("call", [check_writable, lambda path: write_text(path, "new"), check_folder_writable])
def test_a_draft_is_never_written_through_a_link_that_stands_under_its_name(tmp_path, monkeypatch, call):
    precious, target = tmp_path / "precious", tmp_path / "a"
    precious.write_text("mine")
    os.utime(precious, (1, 1))
    monkeypatch.setattr(secrets, "token_hex", lambda _: "ab")
    for name in ("a", "check"):
        (tmp_path / f".{name}.{os.getpid()}.ab.part").symlink_to(precious)
    with pytest.raises(OutputError, match="File exists"):
        call(target)
    assert (precious.read_text(), precious.stat().st_mtime, target.exists()) == ("mine", 1, False)


def test_nobody_foresees_the_name_of_a_draft(tmp_path, monkeypatch):
    drafts, replace = [], os.replace
    monkeypatch.setattr(os, "replace", lambda draft, target: (drafts.append(draft), replace(draft, target)))
    for _ in range(3):
        write_text(tmp_path / "a", "text")
    assert len({*drafts}) == 3


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b'{\n  "schema": 1,\n  "dataset": "x"',
        b'{\n "cases": 3,\n "missing": []',
        PAGE_SIGNATURE.encode(),
        b'<hsr version="1"',
    ],
)
def test_ones_own_files_and_empty_ones_are_known(tmp_path, content):
    path = tmp_path / "a"
    path.write_bytes(content)
    assert is_ours(path)
    check_replaceable(path)


@pytest.mark.parametrize(
    "content",
    [b"import hsr_pin", b'{"dataset": "x", "schema": 1}', b"x" * 10_000 + b'{"schema": 1, "dataset": "x"', b"\x89PNG\r\n"],
)
def test_another_programs_file_is_replaced_only_by_force(tmp_path, content):
    path = tmp_path / "a"
    path.write_bytes(content)
    with pytest.raises(OutputError, match=r"will not replace the file.*--force replaces it"):
        check_replaceable(path)
    check_replaceable(path, force=True)
    check_replaceable(tmp_path / "new")


@pytest.mark.parametrize("name", ["data/a.csv", "link", "data/way/a.csv"])
def test_what_is_read_is_not_replaced_by_force_either(tmp_path, name):
    folder = tmp_path / "data"
    folder.mkdir()
    (folder / "a.csv").write_text("t")
    (tmp_path / "link").symlink_to(folder / "a.csv")
    (folder / "way").symlink_to(folder)
    for read in ([folder], [folder / "a.csv"], [tmp_path / "link"]):
        with pytest.raises(OutputError, match="will not write over what is read"):
            check_replaceable(tmp_path / name, read=read, force=True)


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

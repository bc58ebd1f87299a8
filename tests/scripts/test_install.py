"""The installer fetches nothing that is not pinned by version and hash, its own tool included."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

SCRIPT = "install"


@pytest.fixture
def fetched(script, tmp_path, monkeypatch):
    """What pip is asked for, and the text of its requirements, where there is no uv; no network is needed."""
    root, asked = script.ROOT, []

    def run(command, **_):
        asked.append((command, Path(command[command.index("--requirement") + 1]).read_text(encoding="utf-8")))

    shutil.copy(root / "constraints.txt", tmp_path)
    monkeypatch.setattr(script, "ROOT", tmp_path)
    monkeypatch.setattr(shutil, "which", lambda _: None)
    monkeypatch.setattr(subprocess, "run", run)
    script.find_uv()
    ((command, requirements),) = asked
    return command, requirements


def test_uv_is_fetched_in_the_pinned_version_with_its_hash_verified(fetched):
    command, requirements = fetched
    assert {"--require-hashes", "--no-deps"} < {*command}
    first, *hashes = requirements.replace("\\\n", "").split()
    assert re.fullmatch(r"uv==\d+\.\d+\.\d+", first)
    assert len(hashes) > 5 and all(re.fullmatch(r"--hash=sha256:[0-9a-f]{64}", each) for each in hashes)


def test_a_package_is_not_taken_for_one_whose_name_begins_alike(script):
    assert script.pin("numpy").startswith("numpy==") and script.pin("uv").count("==") == 1

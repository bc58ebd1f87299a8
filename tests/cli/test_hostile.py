"""Results, reports and scores that a command reads again may be anything: it ends with one line, soon and in little memory."""

import os
import subprocess
import sys

import pytest

from hsr_pin.recordings.write import write_dataset

#: Command, the arguments before the file, what it is told to do with it.
READERS = {
    "export --from": ("export", ["--to", "mjcf", "-o", "arm.xml", "--from"]),
    "view --from": ("view", ["data", "--no-open", "--from"]),
    "view --report": ("view", ["data", "--no-open", "--report"]),
    "blind show": ("blind", ["show"]),
}
PROGRAM = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
from hsr_pin.cli.{} import main
main()
"""


@pytest.mark.skipif(sys.platform != "linux", reason="pipes, sparse files and limits are others elsewhere")
@pytest.mark.parametrize("kind", ["a pipe", "a device", "sparse", "nested"])
@pytest.mark.parametrize("reader", READERS)
def test_what_is_no_result_is_one_line(heavy_tip, tmp_path, reader, kind):
    command, arguments = READERS[reader]
    if command == "view":
        pytest.importorskip("viser", reason="needs viser")
    write_dataset(heavy_tip, tmp_path / "data")
    path = "/dev/zero" if kind == "a device" else tmp_path / "found.json"
    if kind == "a pipe":
        os.mkfifo(path)
    elif kind == "sparse":
        with open(path, "wb") as file:
            file.truncate(20_000_000_000)
    elif kind == "nested":
        path.write_text("[" * 200_000, encoding="utf-8")
    program = [sys.executable, "-c", PROGRAM.format(command), *arguments, str(path)]
    done = subprocess.run(program, cwd=tmp_path, capture_output=True, text=True, timeout=30)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"hsr-{command}") and done.stderr.count("\n") == 1 and len(done.stderr) < 600
    said = {"a pipe": "got a pipe", "a device": "got a device", "sparse": "20,000 MB"}.get(kind, "expected ")
    assert said in done.stderr

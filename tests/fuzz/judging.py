"""How a command must end, whatever it was given."""

import json
import re
import signal
from contextlib import contextmanager
from xml.etree import ElementTree

import pytest
from hypothesis import HealthCheck, Phase, settings

from hsr_pin.recordings.read import read_dataset

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
        elif path.suffix == ".py":
            compile(content, path.name, "exec")
        elif path.suffix in (".urdf", ".xml", ".sdf"):
            ElementTree.fromstring(content)
            text = content.decode("utf-8").replace('torsion="inf"', "")  # of a backbone that does not twist
            assert not _NO_NUMBER.search(text)

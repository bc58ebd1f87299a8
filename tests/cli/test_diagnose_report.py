"""What the screen of a diagnosis has no room for is wrapped, and not cut within a sentence."""

from types import SimpleNamespace

from hsr_pin.cli.diagnose_report import _notes


def test_a_note_is_wrapped_and_not_cut():
    note = " ".join(f"word{number}" for number in range(60))
    diagnosis = SimpleNamespace(experiment=SimpleNamespace(notes=(note, "another")))
    lines = [line.plain for line in _notes(diagnosis, 80)]
    assert " ".join(line.strip() for line in lines) == f"note:  {note} (and 1 more notes)"
    assert max(map(len, lines)) <= 80

"""`hsr-diagnose NEW --since OLD` says what has changed, on the screen and in files, or in one line why not."""

import json

import pytest

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.outcome import outcome_of
from hsr_pin.cli.command import run
from hsr_pin.cli.diagnose import command
from hsr_pin.recordings.write import write_dataset

from ..diagnosis.change.recorded import recorded

QUICK = ["--effects", "tip_mass", "--max-effects", "0", "--links", "8", "--jobs", "1"]


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Three sessions, the last with 20 g at the tip."""
    folder = tmp_path_factory.mktemp("sessions")
    for name, *effects in (("one",), ("two",), ("three", "tip_mass:mass=0.02")):
        write_dataset(recorded(*effects, name=name), folder / name)
    return folder


@pytest.fixture(scope="module")
def answer(folders):
    """Exit code, the document and the page of a comparison over all three."""
    files = [folders / "found.json", folders / "found.html"]
    since = ["--since", str(folders / "one"), "--since", str(folders / "two")]
    code = run(command, [str(folders / "three"), *since, *QUICK, "--json", str(files[0]), "--html", str(files[1])])
    return code, json.loads(files[0].read_text(encoding="utf-8")), files[1].read_text(encoding="utf-8")


def test_the_verdict_and_its_sizes_are_in_the_document(answer):
    code, document, _ = answer
    assert (code, document["schema"], document["dataset"], document["since"]) == (0, 1, "three", "one")
    verdict = document["verdict"]
    assert (verdict["status"], verdict["effects"], verdict["alternatives"]) == ("identified", ["tip_mass"], [])
    (change,) = verdict["changes"]
    assert (change["name"], change["parameter"], change["from"]) == ("tip_mass", "tip_mass.mass", 0)
    assert {"from", "to", "step"} == change["intervals"].keys()


def test_a_blind_check_can_read_it(answer):
    truth = {"name": "case_001", "tier": "change", "kind": "appears", "effects": ["tip_mass"], "names": [["tip_mass"]]}
    told = outcome_of(Answer.of(truth | {"size": "", "kinds": [["mass_gravity"]], "background": []}), answer[1], None)
    assert (told.grade, told.status) == ("exact", "identified")


def test_the_first_session_with_a_certain_change_is_told(answer):
    _, document, page = answer
    mass = next(each for each in document["quantities"] if each["name"] == "tip_mass.mass")
    assert mass["first_certain"] == "three"
    assert [point["changed"] for point in mass["points"]] == ["", "", "certain"]
    assert [verdict["status"] for verdict in document["verdicts"]] == ["unchanged", "identified"]
    assert "Development over the sessions" in page
    assert page.count("<svg") == 4


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--since", "one", "--train", "trial_01"], "--train: expected no use of this option with --since"),
        (["--since", "three"], "the same recording twice"),
        (["--since", "nowhere"], "nowhere"),
    ],
)
def test_what_cannot_be_compared_is_one_line(folders, monkeypatch, capsys, arguments, line):
    monkeypatch.chdir(folders)
    assert run(command, ["three", *arguments]) == 2
    error = capsys.readouterr().err
    assert line in error
    assert error.count("\n") == 1

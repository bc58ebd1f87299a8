"""``hsr-diagnose`` where the folder holds recordings of a robot of rigid links."""

import json

import pytest
from click.testing import CliRunner

from hsr_pin.cli.diagnose import command
from hsr_pin.errors import HsrError

QUICK = ["--effects", "link_inertia", "--max-effects", "1", "--jobs", "1"]


def run(*arguments):
    return CliRunner().invoke(command, ["double-pendulum", *arguments], catch_exceptions=True)


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    folder = tmp_path_factory.mktemp("robot")
    done = run(*QUICK, "--json", str(folder / "found.json"), "--html", str(folder / "report.html"))
    assert done.exit_code == 0, done.output
    return done.output, folder


def test_the_cause_is_named_with_its_numbers(told):
    text, folder = told
    assert "double-pendulum: " in text and "noise floor" in text and "link_inertia" in text
    assert "stretches of" in text and "wrote" in text
    found = json.loads((folder / "found.json").read_text(encoding="utf-8"))
    assert found["verdict"]["sentence"].split()[0] in text
    assert -1 < found["candidates"][0]["parameters"]["link_inertia.Joint1"]["value"] < -0.5
    assert "double-pendulum" in (folder / "report.html").read_text(encoding="utf-8")


def test_the_sample_is_listed():
    assert "double-pendulum" in CliRunner().invoke(command, ["--list-samples"]).output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--links", "4"), "--links: expected no use of this option for a robot"),
        (("--train", "trial_01"), "--train: expected --test with the trials to hold out"),
        (("--effects", "dry_friction"), "one of coulomb_friction"),
        (("--since", "double-pendulum", "--since", "double-pendulum"), "one earlier session"),
    ],
)
def test_what_a_robot_has_not_is_refused_in_one_line(arguments, words):
    done = run(*arguments)
    assert isinstance(done.exception, HsrError) and words in str(done.exception)

"""The exported animation, as a browser shows it: complete in itself, with arm and markers in view, and moving."""

import base64
import json
import re
import uuid
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.errors import OutputError
from hsr_pin.replay.page import page, write_page
from hsr_pin.robot.specification import ArmSpecification

#: Of the first and the last link, lit; simulated and measured markers, lit.
BASE_LINK, TIP_LINK = (84, 42, 137), (255, 238, 37)
SIMULATED, MEASURED = (0, 114, 178), (213, 94, 0)


def hue_of(colour):
    colour = np.asarray(colour, dtype=float)
    return colour / np.linalg.norm(colour, axis=-1, keepdims=True)


def places(picture, colour):
    """(n, 2) rows and columns of the pixels that have a colour, however lit; the caption and the controls left out."""
    bright = np.linalg.norm(picture, axis=-1) > 60
    alike = hue_of(np.maximum(picture, 1)) @ hue_of(colour) > 0.995
    alike[:200, :400] = alike[720:] = False
    return np.argwhere(bright & alike)


@pytest.fixture(scope="module")
def compared(run_of, tmp_path_factory):
    """A page with a measurement that is 3 cm away from the simulation."""
    path = tmp_path_factory.mktemp("page") / "run.html"
    write_page([run_of(measured=(0.03, 0.0, 0.03))], path, title="A <run> & its measurement")
    return path


def test_the_page_loads_without_a_complaint_and_asks_for_nothing_outside_itself(tab, compared):
    tab.open(compared.as_uri())
    tab.wait_for("viewer.animator.time > 0.05")
    assert tab.complaints == []
    assert [address for address in tab.requests if not address.startswith(("data:", compared.as_uri()))] == []
    assert compared.as_uri() in tab.requests


def test_a_complaint_of_a_page_would_be_seen(tab, tmp_path):
    (tmp_path / "bad.html").write_text("<script>console.error('one'); missing()</script><img src='gone.png'>")
    tab.open((tmp_path / "bad.html").as_uri())
    tab.wait_for("document.images[0].complete")
    assert len(tab.complaints) >= 3


def test_the_caption_is_shown_as_it_was_given(tab, compared):
    tab.open(compared.as_uri())
    assert tab.evaluate("document.title") == "A <run> & its measurement"
    assert tab.evaluate("document.querySelector('h1').textContent") == "A <run> & its measurement"
    assert "measured" in tab.evaluate("document.getElementById('legend').textContent")


def test_the_page_shows_the_arm_and_both_kinds_of_markers_and_each_can_be_hidden(tab, compared):
    tab.open(compared.as_uri())
    picture = tab.at(0.9)
    assert len(places(picture, BASE_LINK)) > 500
    assert len(places(picture, TIP_LINK)) > 500
    hide = "viewer.scene_tree.find({}).object.visible = false; viewer.set_dirty()"
    arm = '["meshcat", "arms", "arm_1", "{}"]'
    for colour, parts in (
        (SIMULATED, ("simulated_markers", "simulated_trail")),
        (MEASURED, ("measured_markers", "measured_trail")),
    ):
        shown = len(places(picture, colour))
        assert shown > 300
        for part in parts:
            tab.evaluate(hide.format(arm.format(part)))
        picture = tab.at(0.9)
        assert len(places(picture, colour)) < 0.1 * shown


def test_a_marker_out_of_sight_is_not_shown(tab, compared):
    tab.open(compared.as_uri())
    for part in ("measured_trail", "simulated_trail"):
        tab.evaluate(f'viewer.scene_tree.find(["meshcat", "arms", "arm_1", "{part}"]).object.visible = false')
    seen, out_of_sight = (len(places(tab.at(time), MEASURED)) for time in (0.4, 0.55))
    assert 0.3 * seen < out_of_sight < 0.7 * seen  # the middle one is still there


def test_the_picture_changes_over_time_and_only_with_it(tab, compared):
    tab.open(compared.as_uri())
    first, later, again = tab.at(0.0), tab.at(0.3), tab.at(0.0)
    assert np.abs(first - again)[:700].max() <= 8
    assert (np.abs(first - later)[:700].max(axis=-1) > 40).sum() > 5000


def test_it_plays_by_itself_and_the_slider_moves_it(tab, compared):
    tab.open(compared.as_uri())
    start = tab.evaluate("viewer.animator.time")
    tab.wait_for(f"viewer.animator.time > {start} + 0.05 || viewer.animator.time < {start}")
    tab.evaluate("time.value = 0.7; time.dispatchEvent(new Event('input'))")
    assert tab.evaluate("viewer.animator.time") == pytest.approx(0.7, abs=1e-3)
    assert tab.evaluate("viewer.animator.playing") is False
    tab.wait_for("clock.textContent.startsWith('0.70 s')")
    tab.evaluate("play.click()")
    tab.wait_for("viewer.animator.playing && viewer.animator.time != 0.7")


@pytest.mark.parametrize(
    ("mount", "towards"), [("hanging", (1, 0)), ("upright", (-1, 0)), ("horizontal", (0, 1))], ids=lambda value: str(value)
)
def test_the_arm_fills_the_view_and_points_where_its_mount_says(tab, run_of, tmp_path, mount, towards):
    write_page([run_of(ArmSpecification(mount=mount), torque=0.3)], tmp_path / "arm.html")
    tab.open((tmp_path / "arm.html").as_uri())
    picture = tab.at(0.9)
    base, tip = (places(picture, colour) for colour in (BASE_LINK, TIP_LINK))
    way = tip.mean(axis=0) - base.mean(axis=0)
    assert way @ np.array(towards) > 0.9 * np.linalg.norm(way)
    assert np.linalg.norm(way) > 0.35 * picture.shape[0]
    every = np.concatenate([base, tip])
    assert every.min() > 20
    assert np.all(every.max(axis=0) < np.array(picture.shape[:2]) - 20)


def test_several_arms_stand_side_by_side(tab, run_of, tmp_path):
    write_page([run_of(torque=torque, label=f"{torque} N m") for torque in (0.2, 0.5, 0.8)], tmp_path / "arms.html")
    tab.open((tmp_path / "arms.html").as_uri())
    columns = np.unique(places(tab.at(0.9), BASE_LINK)[:, 1])
    assert (np.diff(columns) > 40).sum() == 2
    assert tab.complaints == []


def test_the_page_is_text_that_does_not_depend_on_the_place_it_is_written_to(run_of):
    text = page([run_of()])
    assert str(Path(__file__).resolve().parents[2]) not in text
    assert "site-packages" not in text
    assert len(text) < 3_000_000


def test_a_page_that_cannot_be_written_is_one_line(run_of, tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(OutputError, match="cannot write the file"):
        write_page([run_of()], tmp_path / "file" / "run.html")


def test_the_page_tells_nothing_of_the_machine_and_is_the_same_each_time(run_of):
    text = page([run_of(measured=(0.01, 0.0, 0.0))])
    commands = [base64.b64decode(each) for each in json.loads(re.search(r"for \(const command of (\[.*?\])\)", text)[1])]
    assert sum(b"set_object" in command for command in commands) > 10
    assert f"{uuid.getnode():012x}".encode() not in b"".join(commands)
    assert page([run_of(measured=(0.01, 0.0, 0.0))]) == text


def test_parts_of_one_page_have_different_names(run_of):
    text = page([run_of()])
    commands = [base64.b64decode(each) for each in json.loads(re.search(r"for \(const command of (\[.*?\])\)", text)[1])]
    made = [set(re.findall(rb"[0-9a-f]{8}-[0-9a-f-]{27}", command)) for command in commands if b"set_object" in command]
    assert all(len(names) >= 3 for names in made)
    assert len(set().union(*made)) == sum(map(len, made))

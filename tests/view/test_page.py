"""The page in a browser: it shows the trial, follows its sliders, asks nobody else, and puts nothing on the console."""

import time

import numpy as np
import pytest

from hsr_pin.errors import InputError
from hsr_pin.view.settings import Settings

from ..replay.conftest import chromium, open_tab
from .conftest import LAG

pytest.importorskip("viser", reason="needs viser (group view)")

#: Viser's own three.js says so.
DEPRECATED = "THREE.Clock: This module has been deprecated."
FOUND = {name: Settings({"actuator_lag.time_constant": LAG}) for name in ("trial_01", "trial_02")}


@pytest.fixture(scope="module")
def page(session):
    from hsr_pin.view.page import Page

    shown = Page(session, found=FOUND, report="http://127.0.0.1:1/report.html")
    yield shown
    shown.stop()


@pytest.fixture(scope="module")
def tab(page):
    if chromium() is None:
        pytest.skip("needs Chromium, which is not installed here (Debian: apt-get install chromium)")
    with open_tab((1400, 900)) as opened:
        opened.open(page.address)
        opened.wait_for("document.body.innerText.includes('as declared; all trials')")
        yield opened


@pytest.fixture(autouse=True)
def from_the_start(request):
    if "page" in request.fixturenames:
        shown = request.getfixturevalue("page")
        shown.set(Settings())
        wait_until(lambda: finished(shown) and facts(shown).startswith("**trial_01"))


def facts(page):
    return page._facts.content.replace("\\", "")  # which keep names from being Markdown


def finished(page):
    return page.finished == (page.settings, page.trial)


def wait_until(condition, seconds=60.0):
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def millimetres(text):
    return float(text.partition(": ")[2].partition(" mm")[0])


def test_the_trial_its_error_and_every_effect_are_there(tab, page, session):
    text = tab.evaluate("document.body.innerText")
    for words in ("trial_01", "trial_02", "Distance of the markers", "stiffness K", "damping C", "As found"):
        assert words in text
    for name in ("dry_friction", "marker_offset", "torque_map"):
        assert name in text
    answer = session.answer(session.run("trial_01"), Settings())
    assert millimetres(facts(page)) == pytest.approx(1e3 * answer.rms, abs=0.01)
    assert f"{1e3 * answer.rms:.2f} mm" in text
    assert tab.evaluate("document.querySelectorAll('.uplot canvas').length") == 2


def test_a_slider_moved_by_hand_changes_the_simulation_and_the_page(tab, page, session):
    before = facts(page)
    page._play.value = False  # so that the browser has time for keys
    tab.evaluate("[...document.querySelectorAll('[role=slider]')].find(s => s.getAttribute('aria-valuemax') === '3').focus()")
    for _ in range(20):
        for kind in ("keyDown", "keyUp"):
            tab.call("Input.dispatchKeyEvent", type=kind, key="ArrowRight", code="ArrowRight", windowsVirtualKeyCode=39)
        time.sleep(0.05)
    wait_until(lambda: page.settings.arm("keq_scale") > 1.1 and finished(page))
    moved = session.answer(session.run("trial_01"), page.settings)
    assert millimetres(facts(page)) == pytest.approx(1e3 * moved.rms, abs=0.01)
    assert abs(millimetres(facts(page)) - millimetres(before)) > 0.1
    page._play.value = True
    tab.wait_for(f"document.body.innerText.includes('trial_01: {millimetres(facts(page)):.2f} mm')")


def test_as_found_sets_the_sliders_and_marks_the_effect(tab, page, session):
    tab.evaluate("[...document.querySelectorAll('button')].find(b => b.innerText === 'As found').click()")
    wait_until(lambda: page.settings.acts("actuator_lag") and millimetres(facts(page)) < 1.3e3 * session.noise)
    tab.wait_for("document.body.innerText.includes('actuator_lag ●')")
    tab.evaluate("[...document.querySelectorAll('button')].find(b => b.innerText === 'As declared').click()")
    wait_until(lambda: not page.settings.acts("actuator_lag"))
    tab.wait_for("!document.body.innerText.includes('●')")


def test_a_trial_is_chosen_by_its_button(tab, page, session):
    tab.evaluate("[...document.querySelectorAll('button')].find(b => b.innerText === 'trial_02').click()")
    wait_until(lambda: facts(page).startswith("**trial_02"))
    wanted = 1e3 * session.answer(session.run("trial_02"), Settings()).rms
    assert millimetres(facts(page)) == pytest.approx(wanted, abs=0.01)
    tab.evaluate("[...document.querySelectorAll('button')].find(b => b.innerText === 'trial_01').click()")
    wait_until(lambda: facts(page).startswith("**trial_01"))


def test_the_arm_is_drawn_where_it_was_measured_and_simulated(tab, page):
    stand_still(page, 0.8)
    wait_until(lambda: blue(room(tab)).sum() > 1000 and orange(room(tab)).sum() > 200)
    still = blue(room(tab))
    page.set(Settings({"keq_scale": 3.0}))
    wait_until(lambda: (blue(room(tab)) & ~still).sum() > 500)  # it stands elsewhere
    page._play.value = True
    page._wanted.set()


def test_the_time_slider_moved_by_hand_stops_the_motion(tab, page):
    assert page._play.value
    tab.evaluate("document.querySelectorAll('[role=slider]')[0].focus()")
    for kind in ("keyDown", "keyUp"):
        tab.call("Input.dispatchKeyEvent", type=kind, key="Home", code="Home", windowsVirtualKeyCode=36)
    wait_until(lambda: not page._play.value)
    page._play.value = True
    page._wanted.set()


def stand_still(page, at):
    page._play.value = False
    page._wanted.set()
    time.sleep(1.0)  # longer than a picture
    page._clock.value = at


def room(tab):
    """The picture between the panels."""
    return tab.picture()[:, 420:1060]


def blue(picture):
    return (np.abs(picture - [0, 114, 178]) < 60).all(axis=2)


def orange(picture):
    return (picture[..., 0] > 120) & (picture[..., 0] > picture[..., 2] + 60)


def test_a_failed_simulation_is_said_on_the_page(tab, page):
    page.set(Settings({"keq_scale": 0.2, "torque_gain": 3.0}))
    tab.wait_for("document.body.innerText.includes('The simulation stopped at')")
    assert "no number" in facts(page)


def test_nobody_else_is_asked_and_nothing_is_complained_of(tab, page):
    port = page.address.rpartition(":")[2]
    assert [url for url in tab.requests if not url.startswith((f"http://127.0.0.1:{port}", "data:", "blob:"))] == []
    assert [said for said in tab.complaints if DEPRECATED not in said] == []
    assert tab.evaluate("document.querySelector('a[href$=\"report.html\"]').href") == "http://127.0.0.1:1/report.html"


def test_a_port_that_is_taken_is_refused(page, session):
    from hsr_pin.view.page import Page

    port = int(page.address.rpartition(":")[2])
    with pytest.raises(InputError, match=f"--port: expected a free port, got {port}"):
        Page(session, port=port)

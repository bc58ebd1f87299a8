"""An arm in space on the page: its own effects, two directions, and the arm where it is measured and simulated."""

import numpy as np
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.trajectory import Dataset, Marker
from hsr_pin.view.controls import arm_sliders, effect_sliders, effects_for, variants
from hsr_pin.view.session import POINTS, Session
from hsr_pin.view.settings import Settings

from ..filmed import filmed
from ..replay.conftest import chromium, open_tab
from .test_page import DEPRECATED, blue, facts, finished, millimetres, orange, room, stand_still, wait_until

TRUE = Settings({"bend_at_rest.towards_y": 0.3})
MARKERS = (Marker("base", 0.0), Marker("mid", 0.12, 0.02, 1.0), Marker("tip", 0.24))


@pytest.fixture(scope="module")
def session():
    """Two trials of an arm that is bent at ease towards y, 0.3 mm of noise."""
    arm = ArmSpecification(links=12, placement="mid", bending="space", torsion=1.11)
    bent = (parse_effect("bend_at_rest:towards_y=0.3"),)
    steps = [step_scenario(arm, tau, duration=1.0, effects=bent, markers=MARKERS) for tau in ((0.5, 0.2), (-0.3, 0.8))]
    trials = filmed([result.trajectory for result in simulate_batch(steps)], 3e-4, 3)
    dataset = Dataset("bent", arm.length, arm.mass, arm.diameter, arm.mount, trials, bending="space", torsion=1.11)
    return Session.of(dataset, 12, "mid")


def test_the_right_setting_leaves_noise_and_others_more(session):
    run = session.run("trial_02")
    declared, right = session.answer(run, Settings()), session.answer(run, TRUE)
    assert right.rms == pytest.approx(session.noise, rel=0.15)
    assert declared.rms > 5 * right.rms
    assert right.residual.shape[2] == 3


def test_the_backbone_passes_through_the_markers_on_it_and_stays_where_markers_are_moved(session):
    run = session.run("trial_01")
    plain, moved = (session.answer(run, each) for each in (TRUE, TRUE.changed("markers_beside.towards_x", 0.01)))
    assert plain.backbone.shape[1:] == (POINTS, 3)
    np.testing.assert_allclose(plain.backbone[:, -1], plain.markers[:, 1], atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(plain.backbone[:, POINTS // 2] - plain.markers[:, 0], axis=1), 0.02, atol=1e-9)
    np.testing.assert_allclose(moved.backbone, plain.backbone)
    np.testing.assert_allclose(np.linalg.norm(moved.markers - plain.markers, axis=2), 0.01, atol=1e-9)


def test_what_is_drawn_over_time_is_towards_x_and_towards_y_of_the_base(session):
    (to_x, x), (to_y, y) = session.across.items()
    assert to_x.endswith("towards x of the base") and to_y.endswith("towards y of the base")
    tip = session.answer(session.run("trial_02"), Settings()).markers[-1, 1]
    assert tip @ x < -0.02 and tip @ y > 0.06


def test_every_effect_that_can_be_moved_can_be_simulated(session):
    run, kinds = session.run("trial_01"), effects_for(space=True)
    assert set(SPATIAL) < set(kinds)
    assert "restraint" not in kinds and "preset_bend" not in kinds
    for name, kind in kinds.items():
        amplitude = next(slider for slider in effect_sliders(name) if slider.upper > slider.neutral)
        settings = Settings({amplitude.name: amplitude.neutral + 3 * amplitude.step})
        for option, values in variants(kind, space=True).items():
            for value in values:
                answer = session.answer(run, settings.changed(f"{name}.{option}", value))
                assert np.isfinite(answer.rms), (name, value)
        assert np.isfinite(session.answer(run, settings).rms), name
    assert variants(kinds["torque_map"], space=True)["parity"] == ("odd",)
    assert len(arm_sliders()) == 4


def test_the_page_shows_it_and_follows_its_sliders(session):
    pytest.importorskip("viser", reason="needs viser (group view)")
    if chromium() is None:
        pytest.skip("needs Chromium, which is not installed here (Debian: apt-get install chromium)")
    from hsr_pin.view.page import Page

    page = Page(session)
    try:
        with open_tab((1400, 900)) as tab:
            tab.open(page.address)
            tab.wait_for("document.body.innerText.includes('as declared; all trials')")
            text = tab.evaluate("document.body.innerText")
            for words in (
                "unequal_stiffness",
                "weak_chamber",
                "markers_beside",
                "towards x of the base",
                "towards y of the base",
            ):
                assert words in text
            assert "restraint" not in text
            assert tab.evaluate("document.querySelectorAll('.uplot canvas').length") == 3
            stand_still(page, 0.8)
            wait_until(lambda: blue(room(tab)).sum() > 1000 and orange(room(tab)).sum() > 200, 240.0)
            still = blue(room(tab))
            page.set(TRUE)
            wait_until(lambda: finished(page) and millimetres(facts(page)) < 1.3e3 * session.noise)
            wait_until(lambda: (blue(room(tab)) & ~still).sum() > 300, 240.0)
            assert [said for said in tab.complaints if DEPRECATED not in said] == []
    finally:
        page.stop()

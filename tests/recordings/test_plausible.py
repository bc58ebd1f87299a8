"""Numbers that no arm has are refused before anything is computed from them, with what was probably meant."""

import numpy as np
import pytest

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.importers.bodies import Body
from hsr_pin.recordings.importers.settings import ImportSettings
from hsr_pin.recordings.plausible import exchanged, implausible_angle, implausible_mount, implausible_payload, implausible_size
from hsr_pin.recordings.read import read_dataset


@pytest.mark.parametrize(
    "old, new, said",
    [
        ("mass = 0.15", "mass = 150", "got 150 kg; the mass is in kg; if this is grams, write 0.15"),
        ("mass = 0.15", "mass = 0.00015", "got 0.00015 kg; the mass is in kg; if this is tonnes, write 0.15"),
        (
            "diameter = 0.04",
            "diameter = 40",
            "at most 0.48 m for an arm of 0.24 m, got 40 m; the diameter is in metres; if this is mm",
        ),
        ("diameter = 0.04", "diameter = 0.00004", "check that the mass is in kg and the outer diameter in m"),
    ],
)
def test_a_size_that_is_off_by_a_thousand_is_refused_where_it_stands(spoil, old, new, said):
    with pytest.raises(RecordingError) as caught:
        read_dataset(spoil("dataset.toml", old, new))
    assert said in str(caught.value)
    assert caught.value.line == (7 if "got 40 m" in said else 6)


@pytest.mark.parametrize(
    "size", [(0.24, 0.15, 0.04), (0.29, 0.293, 0.086), (0.1, 0.0963, 0.03), (2.0, 40.0, 0.2), (0.1, 0.0005, 0.01)]
)
def test_real_arms_are_plausible(size):
    assert implausible_size(*size) is None


def test_an_angle_in_degrees_is_refused_and_a_turn_is_not():
    assert implausible_angle(120.0).hint == "the angle is in rad; if this is degrees, write 2.094"
    assert implausible_angle(-2 * np.pi) is None
    bodies = [Body.parse("side@0.24,0.02,90=side")]
    with pytest.raises(InputError, match=r"angle of marker side: expected .* if this is degrees"):
        ImportSettings(mass=0.15, diameter=0.04, keq=[1.11], bending="space", markers=bodies)
    with pytest.raises(InputError, match=r"angle: expected .* got 120; the angle is in rad; if this is degrees"):
        ImportSettings(mass=0.15, diameter=0.04, keq=[1.11], bending="space", gain=0.3, angle=120.0)


def test_markers_that_stand_in_each_others_places_are_refused_by_name(spoil):
    folder = spoil("trial_01.csv", "mid_x,mid_y,mid_z,tip_x,tip_y,tip_z", "tip_x,tip_y,tip_z,mid_x,mid_y,mid_z")
    with pytest.raises(
        RecordingError, match=r"markers 'mid' and 'tip' seem to be exchanged: expected 'mid' at most 0.12 m"
    ) as caught:
        read_dataset(folder)
    assert (caught.value.line, caught.value.column) == (1, 25)


def test_an_arm_that_curls_up_or_stretches_has_its_markers_in_order():
    arcs = [0.0, 0.12, 0.24]
    assert exchanged(arcs, [0.0, 0.12, 0.03]) is None  # the tip is back at the base
    assert exchanged(arcs, [0.0, 0.14, 0.27]) is None
    assert exchanged(arcs, [0.0, np.nan, 0.24]) is None
    assert exchanged(arcs, [0.0, 0.23, 0.12]) == (1, 2)


@pytest.mark.parametrize(
    ("mount", "place", "fits"),
    [
        ("hanging", (0.01, 0.0, 0.23), "upright"),
        ("upright", (0.0, 0.0, -0.2), "hanging"),
        ("horizontal", (-0.2, 0.0, 0.1), "upright"),
    ],
)
def test_an_arm_on_the_other_side_of_its_base_has_another_mount(mount, place, fits):
    assert implausible_mount(mount, [place, place], 0.24).hint == f'z is up; mount = "{fits}" fits the recordings'
    bent = (0.2, 0.0, 0.0) if mount != "horizontal" else (0.0, 0.0, -0.2)
    assert implausible_mount(mount, [place, bent], 0.24) is None


def test_a_mount_that_the_recording_contradicts_is_refused_with_the_one_that_fits(spoil):
    folder = spoil("dataset.toml", 'mount = "hanging"', 'mount = "upright"')
    with pytest.raises(RecordingError, match=r"mount: expected an arm that points up, got .* mount = .hanging. fits"):
        read_dataset(folder)


def test_a_payload_in_grams_is_refused():
    assert implausible_payload(0.1, 52.0).hint == "the mass is in kg; if this is grams, write 0.052"
    assert implausible_payload(0.1, 2.0) is None

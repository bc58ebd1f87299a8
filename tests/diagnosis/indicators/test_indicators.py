"""The indicators point to the error of an arm, and to nothing if there is none."""

import json

import numpy as np
import pytest

from hsr_pin.diagnosis.indicators.indicators import indicators
from hsr_pin.effects.effect import KINDS
from hsr_pin.identification.experiment import prepare
from hsr_pin.recordings.read import read_dataset
from hsr_pin.report.inline_svg import drawing

from .recorded import arcs, commanded, released, swing


@pytest.fixture(scope="module")
def nominal():
    return indicators(commanded())


@pytest.mark.parametrize("make", [commanded, released])
@pytest.mark.parametrize("damping", [0.01, 0.05])
def test_the_nominal_arm_points_to_nothing(make, damping):
    assert indicators(make(damping=damping)).kinds == ()


@pytest.mark.parametrize("effect", ["gravity_tilt:angle=0.12", "tip_mass:mass=0.05", "stiffening:cubic=0.4"])
def test_what_acts_at_rest_and_in_motion_alike_is_no_friction_creep_or_lag(effect):
    assert not {"friction", "creep", "actuation_time", "measurement"} & {*indicators(commanded(effect)).kinds}


@pytest.mark.parametrize(
    ("effect", "kind", "name"),
    [
        ("dry_friction:level=0.06", "friction", "loops"),
        ("dry_friction:level=0.06", "friction", "rests"),
        ("hysteresis:amplitude=0.12,yield_angle=0.25", "friction", "loops"),
        ("actuator_lag:time_constant=0.05", "actuation_time", "timing"),
        ("dead_time:delay=0.045", "actuation_time", "timing"),
        ("viscoelastic:ratio=0.4,time_constant=0.4", "creep", "creep"),
        ("viscoelastic:ratio=0.4,time_constant=0.4", "creep", "loops"),
    ],
)
def test_a_law_is_pointed_to_by_its_print(effect, kind, name):
    found = indicators(commanded(effect))
    assert kind in found.named(name).kinds
    strangers = (
        {"friction", "creep", "damping", "elastic", "actuation_time"}
        - {kind}
        - ({"actuation_time"} if kind == "creep" else set())
    )
    assert not strangers & {*found.kinds}


@pytest.mark.parametrize(
    ("effect", "kind"),
    [
        ("viscoelastic:ratio=0.4,time_constant=0.4", "creep"),
        ("hysteresis:amplitude=0.12,yield_angle=0.25", "friction"),
        ("dry_friction:level=0.06", "friction"),
        ("quadratic_damping:coefficient=0.001", "damping"),
    ],
)
def test_releases_show_it_too(effect, kind):
    assert kind in indicators(released(effect)).kinds


def test_every_print_can_be_drawn_and_told_and_written(nominal):
    from matplotlib.figure import Figure

    for each in (*nominal.items, *indicators(released()).items):
        with drawing():
            axes = Figure(figsize=(4, 3)).add_subplot()
            each.draw(axes)
            axes.figure.canvas.draw()
        assert axes.get_xlabel() and axes.get_ylabel() and axes.has_data()
        assert each.sentence.endswith(".") and "nan" not in each.sentence and each.sentence.count(". ") == 0
        assert {*each.kinds} <= {*KINDS}


def test_it_is_plain_json(nominal):
    written = json.loads(json.dumps(nominal.to_json(), allow_nan=False))
    assert [each["name"] for each in written["prints"]] == ["timing", "loops", "creep", "rests", "out_of_plane", "length"]
    assert len(written["starts"]) == 5


def test_what_recordings_cannot_show_is_left_out():
    found = indicators(arcs(swing(0.8, 2.0, 0.05)))
    assert found.named("timing") is None and found.named("loops") is None and found.named("rests") is None
    assert found.named("decay") is not None


def test_gaps_and_a_marker_that_is_lost_do_not_stop_it():
    experiment = commanded.__wrapped__()
    holes = np.random.default_rng(3)
    for run in experiment.runs:
        run.measured.flags.writeable = True
        run.measured[holes.random(len(run.time)) < 0.2] = np.nan
        run.measured[:, -1] = np.nan
    assert {each.name for each in indicators(experiment).items} >= {"loops", "rests"}


@pytest.mark.parametrize(
    ("name", "there", "absent"),
    [
        ("sample-steps", {"actuation_time"}, {"friction", "creep", "measurement"}),
        ("sample-rich-dirty", {"friction"}, {"actuation_time", "creep", "measurement"}),
        ("real-pneumatic", {"actuation_time"}, set()),
        ("real-trunk", {"friction"}, {"creep", "actuation_time"}),
        ("real-beam", {"creep"}, {"actuation_time"}),
    ],
)
def test_what_the_shared_recordings_show(shared, name, there, absent):
    kinds = {*indicators(prepare(read_dataset(shared / "recordings" / name))).kinds}
    assert there <= kinds and not absent & kinds

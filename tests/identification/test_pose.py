"""The pose of an arm from its markers: where they were seen, moving as they did, bent most where the arm is soft."""

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.identification.evaluation import predict, predict_with_slopes
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.pose import pose_from_markers
from hsr_pin.inference.fit import fit
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.cameras import Cameras

REACH = (0.08, 0.16, 0.24)
STILL = np.zeros((3, 3))


def arms(links, *effects, count=1):
    """A batch of copies of one arm, and the cameras that measure them."""
    batch = ArmBatch(Arms.of([ArmSpecification(links=links, placement="mid", bending_limit=6.0)] * count), effects)
    return batch, Cameras(batch, REACH)


def shown(cameras, angles):
    return cameras.positions(np.asarray(angles)[None, None])[0, 0]


def moving(cameras, angles, rates):
    return (shown(cameras, angles + 1e-6 * rates) - shown(cameras, angles - 1e-6 * rates)) / 2e-6


def test_pose_and_rates_put_the_markers_where_they_were_seen_and_moving_as_they_did():
    batch, cameras = arms(8)
    s = 2 * (np.arange(8) + 0.5) / 8 - 1
    angles, rates = (0.9 + 0.3 * s) / 8, (2.0 - 1.0 * s) / 8
    seen, velocity = shown(cameras, angles), moving(cameras, angles, rates)
    q, v, _ = pose_from_markers(batch, cameras, seen, velocity, 1e-4)
    assert np.abs(shown(cameras, q[0]) - seen).max() < 1e-5
    assert np.abs(moving(cameras, q[0], v[0]) - velocity).max() < 1e-2 * np.abs(velocity).max()


@pytest.mark.parametrize("bend", [-3.0, -0.4, 0.0, 1.5, 3.0])
def test_an_arm_that_is_bent_far_is_found(bend):
    batch, cameras = arms(16)
    q = pose_from_markers(batch, cameras, shown(cameras, np.full(16, bend / 16)), STILL, 1e-4)[0]
    assert q.sum() == pytest.approx(bend, abs=0.01)


def test_a_marker_that_is_not_seen_does_not_bend_the_arm():
    batch, cameras = arms(8)
    seen = shown(cameras, np.full(8, 0.1))
    seen[1] = np.nan
    q = pose_from_markers(batch, cameras, seen, STILL, 1e-4)[0]
    assert np.abs(q - 0.1).max() < 1e-3


def test_an_arm_of_which_nothing_is_seen_is_taken_as_straight():
    batch, cameras = arms(8)
    q, v, modes = pose_from_markers(batch, cameras, np.full((3, 3), np.nan), STILL, 1e-4)
    assert q.shape == v.shape == (1, 8) and not q.any() and not v.any() and modes.shape == (0,)


def test_an_arm_held_by_a_couple_bends_most_where_it_is_soft():
    soft = EFFECTS["soft_spot"](depth=0.7, centre=0.46, width=0.05)
    batch, cameras = arms(12, soft)
    held = 0.8 / 12 / batch.arrays.profile[0]
    seen = shown(cameras, held)
    q = pose_from_markers(batch, cameras, seen, STILL, 1e-4)[0][0]
    assert q == pytest.approx(held, abs=0.02 * held.max())
    even, others = arms(12)
    assert np.abs(pose_from_markers(even, others, seen, STILL, 1e-4)[0][0] - held).max() > 0.3 * held.max()


def test_arms_side_by_side_are_each_found_as_if_alone():
    depths = np.array([0.0, 0.4, 0.8])
    soft = EFFECTS["soft_spot"](depth=depths, centre=np.full(3, 0.4), width=np.full(3, 0.1))
    batch, cameras = arms(10, soft, count=3)
    _, cameras_of_one = arms(10)
    seen = shown(cameras_of_one, np.linspace(0.05, 0.15, 10))
    velocity = np.tile([0.1, 0.0, 0.02], (3, 1))
    q, v, modes = pose_from_markers(batch, cameras, seen, velocity, 1e-4)
    for column, depth in enumerate(depths):
        alone = pose_from_markers(*arms(10, EFFECTS["soft_spot"](depth, 0.4, 0.1)), seen, velocity, 1e-4)
        assert q[column] == pytest.approx(alone[0][0], rel=1e-6)
        assert v[column] == pytest.approx(alone[1][0], rel=1e-6)
        again = pose_from_markers(*arms(10, EFFECTS["soft_spot"](depth, 0.4, 0.1)), seen, velocity, 1e-4, near=modes)
        assert again[0] == pytest.approx(alone[0], rel=1e-6)


def test_what_an_effect_makes_of_the_start_of_a_release_is_in_its_derivatives(record):
    """A gradient of stiffness changes the pose in which the markers are seen where they were: at once, not only later."""
    experiment = prepare(record([(1.11, None)], effects=[EFFECTS["stiffness_gradient"](0.6)], noise=1e-6))
    model = Hypothesis(tolerance=1e-6).with_effects(EFFECTS["stiffness_gradient"](0.6))
    values = model.start
    (found,) = predict_with_slopes(experiment, model, values, central=True)
    width = 0.01
    (run,) = experiment.runs
    there, here = (
        p.positions for p in predict(experiment, model, [(run, values + side * np.array([0.0, 0.0, width])) for side in (1, -1)])
    )
    chord = (there - here) / (2 * width)
    assert np.abs(chord[0]).max() < 0.15 * np.abs(chord).max()  # the markers stay where they were seen, at first
    assert np.abs(found.slopes[..., 2] - chord).max() < 0.05 * np.abs(chord).max()
    assert np.abs(found.positions[0] - run.compared[0]).max() < 1e-4


def test_a_release_of_an_arm_with_a_gradient_is_recovered(record):
    dataset = record([(1.11, None), (2.33, None)], keq=1.1, damping=0.8, effects=[EFFECTS["stiffness_gradient"](0.6)])
    answer = fit(prepare(dataset), Hypothesis().with_effects(EFFECTS["stiffness_gradient"](0.1)))
    assert answer.named["stiffness_gradient.slope"] == pytest.approx(0.6, abs=0.05)


def test_a_search_led_astray_from_a_pose_nearby_begins_anew():
    """From the pose of an even arm, held by hand, the search curls one up that is far softer at its base than at its tip."""
    held, found = np.array([[-0.024, 0.0, -0.117], [-0.060, 0.0, -0.232]]), []
    near = None  # where the search begins: the first time from no pose
    for effects in ((), (EFFECTS["stiffness_gradient"](slope=1.6),)):
        batch = ArmBatch(Arms.of([ArmSpecification(links=16, placement="mid", bending_limit=6.0)]), effects)
        cameras = Cameras(batch, (0.12, 0.24))
        q, _, near = pose_from_markers(batch, cameras, held, STILL[:2], 1e-4, near)
        found.append(np.abs(shown(cameras, q[0]) - held).max())
    assert max(found) < 1e-3


def test_markers_declared_where_they_are_not_do_not_fold_the_arm():
    batch, cameras = arms(8)
    seen = shown(cameras, np.full(8, 0.15))
    wrong = Cameras(batch, (0.05, 0.12, 0.24))  # its inner markers are seen farther from the base than the backbone is long
    q, _, kappa = pose_from_markers(batch, wrong, seen, STILL, 1e-4)
    assert q.sum() == pytest.approx(1.2, rel=0.1) and np.abs(kappa[1:]).max() < 0.3
    assert np.abs(shown(wrong, q[0])[2] - seen[2]).max() < 0.03

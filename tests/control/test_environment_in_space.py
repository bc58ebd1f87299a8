"""The environments of arms in space keep Gymnasium's promises; in a plane they are those of the plane."""

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="needs the group gym")

from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import SyncVectorEnv  # noqa: E402

from hsr_pin.control.dynamics import ArmDynamics  # noqa: E402
from hsr_pin.control.environment import FollowTip, ReachTip  # noqa: E402
from hsr_pin.control.registration import ENVIRONMENTS, register  # noqa: E402
from hsr_pin.control.stepping import ArmSimulator  # noqa: E402
from hsr_pin.control.vector import FollowTips, ReachTips  # noqa: E402
from hsr_pin.effects import parse_effect  # noqa: E402
from hsr_pin.errors import InputError  # noqa: E402
from hsr_pin.robot.sections import Section  # noqa: E402
from hsr_pin.robot.specification import ArmSpecification  # noqa: E402

ARM = ArmSpecification(bending="space", placement="mid", torsion=1.11)
EFFECTS = tuple(map(parse_effect, ("hysteresis:amplitude=0.1", "weak_chamber:loss=0.3", "markers_beside:towards_y=0.01")))
both = pytest.mark.parametrize("kind", [ReachTip, FollowTip])


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_an_arm_in_space_passes_gymnasiums_own_checker(name):
    register()
    check_env(gymnasium.make(name, arm=ARM, effects=EFFECTS).unwrapped)


@both
def test_observations_are_in_the_units_that_are_documented(kind):
    environment = kind(ARM, EFFECTS)
    environment.reset(seed=4)
    arm = ArmSimulator(ARM, EFFECTS, torque_range=(-2, 2))
    for share in ((0.5, 0.2), (0.6, -0.8), (-0.2, -0.7)):
        seen, reward, *_, facts = environment.step(np.array(share))
        state = arm.step(1.11 * np.array(share), dt=0.02)
    assert seen.shape == (16,)
    model, q, v = ArmDynamics(ARM), state.angles.ravel(), state.rates.ravel()
    tip = arm.observe()[-1]
    np.testing.assert_allclose(seen[:3], tip, atol=1e-12)
    ways = [model.tip(q + w * v) for w in (-1e-6, 1e-6)]  # [m] in 1 us
    np.testing.assert_allclose(seen[3:6], (ways[1] - ways[0]) / 2e-6, atol=1e-8)
    np.testing.assert_allclose(seen[6:8], state.angles[:, :2].sum(axis=0), atol=1e-12)
    np.testing.assert_allclose(seen[8:10], state.rates[:, :2].sum(axis=0), atol=1e-12)
    assert facts["distance"] == pytest.approx(np.linalg.norm(seen[10:13] - tip))
    assert reward == pytest.approx(-facts["distance"] / 0.24)


def test_towards_x_alone_it_is_the_arm_in_the_plane():
    arms = ArmSpecification(placement="mid"), ArmSpecification(placement="mid", bending="space")
    plane, space = (ReachTip(arm) for arm in arms)
    plane.reset(seed=1)
    space.reset(seed=1)
    for share in (0.9, 0.4, -0.7):
        flat, whole = plane.step(np.array([share]))[0], space.step(np.array([share, 0.0]))[0]
    np.testing.assert_allclose(whole[[0, 2, 3, 5, 6, 8]], flat[:6], atol=1e-9)
    np.testing.assert_allclose(whole[[1, 4, 7, 9]], 0.0, atol=1e-9)


def test_a_target_to_any_side_can_be_reached_and_held():
    environment = ReachTip(ARM)
    seen, _ = environment.reset(options={"target": (0.07, -0.08, -0.2)})
    target, bend = seen[10:13], np.zeros(2)
    assert target[1] > 0.05 or target[1] < -0.05
    side = np.array([1.0, -1.0])  # a hanging arm bends to -y of the world where its base has +y
    for _ in range(environment.steps):
        bend += 0.4 * side * (target - seen[:3])[:2]
        seen, _, terminated, truncated, facts = environment.step(np.clip(bend, -1, 1))
    assert truncated and not terminated
    assert facts["distance"] < 2e-3


def test_drawn_targets_are_on_all_sides():
    environment = ReachTip(ARM)
    places = np.array([environment.reset(seed=seed)[0][10:12] for seed in range(40)])
    assert {(x > 0, y > 0) for x, y in places} == {(a, b) for a in (True, False) for b in (True, False)}


def test_the_path_leaves_every_plane_and_starts_at_rest():
    environment = FollowTip(ARM)
    first, _ = environment.reset(seed=1)
    np.testing.assert_allclose(first[10:13], [0.0, 0.0, -0.24], atol=1e-9)
    path = np.array([environment.step(np.zeros(2))[0][10:12] for _ in range(environment.steps)])
    assert np.linalg.svd(path - path.mean(axis=0))[1][1] > 0.05


@pytest.mark.parametrize(("single", "many"), [(ReachTip, ReachTips), (FollowTip, FollowTips)])
def test_many_arms_are_each_what_they_are_alone(single, many):
    arms = [ArmSpecification(bending="space", placement="mid", mass=0.15 * share) for share in (0.8, 1.0, 1.2)]
    together = many(3, arms, EFFECTS)
    alone = SyncVectorEnv([lambda arm=arm: single(arm, EFFECTS) for arm in arms], observation_mode="different")
    random = np.random.default_rng(0)
    np.testing.assert_allclose(together.reset(seed=5)[0], alone.reset(seed=5)[0], atol=1e-10)
    for _ in range(5):
        actions = random.uniform(-1, 1, (3, 2))
        ours, theirs = together.step(actions), alone.step(actions)
        for one, other in zip(ours[:4], theirs[:4], strict=True):
            np.testing.assert_allclose(one, other, atol=1e-10)


@pytest.mark.parametrize("action", [np.array([0.1]), np.array([0.1, np.nan]), np.array([0.1, 1.01])])
def test_a_bad_action_gets_a_clear_error(action):
    environment = ReachTip(ARM)
    environment.reset(seed=0)
    with pytest.raises(InputError, match=r"action: expected two numbers from -1 to 1, shape \(2,\)"):
        environment.step(action)
    vector = ReachTips(1, ARM)
    vector.reset(seed=0)
    with pytest.raises(InputError, match=r"actions: expected numbers from -1 to 1, shape \(1, 2\)"):
        vector.step(action[None])


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        (ReachTip, {"target": (0.1, -0.2)}, "tip position: expected x, y and z"),
        (FollowTip, {"path": np.zeros((151, 2))}, r"path: expected finite x, y and z \[m\], shape \(151, 3\)"),
        (FollowTip, {"torque": 0.5}, "torque: .* towards x and towards y"),
    ],
)
def test_a_bad_reset_gets_a_clear_error(kind, options, message):
    with pytest.raises(InputError, match=message):
        kind(ARM).reset(options=options)


def test_it_settles_under_two_torques():
    seen, _ = ReachTip(ARM).reset(seed=0, options={"torque": (0.3, -0.4)})
    assert seen[6] == pytest.approx(-0.75 * seen[7])
    assert seen[6] > 0.15


def test_an_arm_of_several_sections_is_refused_in_one_line():
    arm = ArmSpecification.in_sections([Section(0.1, 0.1, 3.0, 0.1), Section(0.1, 0.1, 3.0, 0.1)])
    with pytest.raises(InputError, match="sections: expected none, because the arm of an environment has one torque"):
        ReachTip(arm)

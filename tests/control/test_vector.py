"""Many arms in one vector environment are each what they are alone, and keep Gymnasium's promises."""

import copy

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="needs the group gym")

from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402
from gymnasium.vector.utils import batch_space  # noqa: E402
from gymnasium.wrappers.vector import DictInfoToList, RecordEpisodeStatistics  # noqa: E402

from hsr_pin.control.environment import FollowTip, ReachTip  # noqa: E402
from hsr_pin.control.registration import ENVIRONMENTS, register  # noqa: E402
from hsr_pin.control.vector import FollowTips, ReachTips  # noqa: E402
from hsr_pin.effects import parse_effect  # noqa: E402
from hsr_pin.errors import InputError  # noqa: E402
from hsr_pin.robot.specification import ArmSpecification  # noqa: E402
from hsr_pin.simulation.motion import Engine  # noqa: E402

PAIRS = [(ReachTip, ReachTips), (FollowTip, FollowTips)]
both = pytest.mark.parametrize("kind", [ReachTips, FollowTips])


def different(count):
    """Arms, and what acts on each, that differ in every number that may differ."""
    shares = np.linspace(0.8, 1.2, count)
    arms = [ArmSpecification(keq=1.11 * s, mass=0.15 / s, length=0.24 * s, damping=0.05 * s, tip_mass=0.01 * s) for s in shares]
    texts = "dead_time:delay={}", "hysteresis:amplitude={}", "unequal_lag:rise={},fall=0.05", "marker_offset:offset={}"
    sizes = 0.03, 0.1, 0.03, 0.003
    effects = [[parse_effect(text.format(size * s)) for text, size in zip(texts, sizes, strict=True)] for s in shares]
    return arms, effects


def together_and_alone(single, many, arms, effects, **more):
    """The vector environment, and Gymnasium's own of single ones."""
    alone = [lambda a=a, e=e: single(a, e, **more) for a, e in zip(arms, effects, strict=True)]
    return many(len(arms), arms, effects, **more), SyncVectorEnv(alone, observation_mode="different")


def same(ours, theirs):
    assert ours.keys() == theirs.keys()
    for name, values in ours.items():
        assert values.dtype == theirs[name].dtype
        if values.dtype == object:
            assert list(values) == list(theirs[name])
        else:
            np.testing.assert_allclose(values, theirs[name], rtol=0, atol=1e-10)


@pytest.mark.parametrize(("single", "many"), PAIRS)
def test_arms_that_differ_are_what_they_are_alone_over_several_episodes(single, many):
    ours, theirs = together_and_alone(single, many, *different(4), duration=0.2)
    random, ends = np.random.default_rng(0), 0
    for given in (dict(seed=3), dict(seed=[7, None, 1, 2]), dict(options={"torque": 0.3})):
        (seen, facts), (expected, told) = ours.reset(**given), theirs.reset(**copy.deepcopy(given))
        np.testing.assert_allclose(seen, expected, rtol=0, atol=1e-10)
        same(facts, told)
        for _ in range(25):
            actions = random.uniform(-1, 1, (4, 1))
            *values, facts = ours.step(actions)
            *others, told = theirs.step(actions)
            for value, other in zip(values, others, strict=True):
                assert value.dtype == other.dtype
                np.testing.assert_allclose(value, other, rtol=0, atol=1e-10)
            same(facts, told)
            ends += values[3].sum()
    assert ends == 3 * 2 * 4


def test_an_arm_that_fails_ends_alone_and_begins_anew_in_the_next_step():
    arms = [ArmSpecification(), ArmSpecification(keq=8.0)]
    ours, theirs = together_and_alone(ReachTip, ReachTips, arms, [(), ()], largest_torque=8.0)
    ours.reset(seed=0)
    theirs.reset(seed=0)
    fallen = 0
    for _ in range(40):
        *values, facts = ours.step(np.ones((2, 1)))
        *others, told = theirs.step(np.ones((2, 1)))
        for value, other in zip(values, others, strict=True):
            np.testing.assert_allclose(value, other, rtol=0, atol=1e-9)
        same(facts, told)
        fallen += values[2]
    assert fallen[0] > 1
    assert fallen[1] == 0


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_gymnasium_makes_it_by_its_id(name):
    register()
    envs = gymnasium.make_vec(name, num_envs=3, vectorization_mode="vector_entry_point", duration=0.1)
    assert isinstance(envs, (ReachTips, FollowTips))
    assert type(gymnasium.make_vec(name, num_envs=3)) is type(envs)
    assert envs.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    assert envs.observation_space == batch_space(envs.single_observation_space, 3)
    assert envs.action_space == batch_space(envs.single_action_space, 3)


@both
def test_gymnasiums_wrappers_work_on_it(kind):
    envs = DictInfoToList(RecordEpisodeStatistics(kind(5, duration=0.1)))
    seen, _ = envs.reset(seed=0)
    envs.action_space.seed(0)
    lengths = []
    for _ in range(14):
        assert envs.observation_space.contains(seen)
        seen, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
        assert rewards.shape == terminated.shape == truncated.shape == (5,)
        lengths += [info["episode"]["l"] for info in infos if "episode" in info]
    assert lengths == [5] * 10


def test_all_arms_are_stepped_in_one_call(monkeypatch):
    calls, advance = [], Engine.advance
    monkeypatch.setattr(Engine, "advance", lambda self, state, *rest: calls.append(state.shape) or advance(self, state, *rest))
    envs = ReachTips(300, [ArmSpecification(mass=0.1 + 1e-4 * i) for i in range(300)])
    envs.reset(seed=0)
    envs.step(np.full((300, 1), 0.3))
    assert calls == [(2, 300, 4)]


def test_a_masked_reset_leaves_the_others_alone():
    envs = FollowTips(4)
    envs.reset(seed=0)
    before = envs.step(np.full((4, 1), 0.8))[0]
    mask = np.array([True, False, False, True])
    after, facts = envs.reset(seed=9, options={"reset_mask": mask})
    assert np.array_equal(after[~mask], before[~mask])
    np.testing.assert_allclose(after[mask, :2], [[0, -0.24]] * 2, atol=1e-12)
    np.testing.assert_allclose(after[mask], FollowTips(4).reset(seed=9)[0][mask], rtol=0, atol=1e-12)
    assert np.array_equal(facts["_distance"], mask)


@both
def test_the_same_seed_gives_the_same_targets_and_every_arm_its_own(kind):
    first, second, other = (kind(3).reset(seed=seed)[0] for seed in (1, 1, 7))
    assert np.array_equal(first, second)
    assert not np.any(first[:, 8] == other[:, 8])
    assert len({*first[:, 8]}) == 3


def test_a_copied_environment_goes_its_own_way():
    envs = ReachTips(2, effects=[parse_effect("viscoelastic:ratio=0.4")])
    envs.reset(seed=0)
    envs.step(np.ones((2, 1)))
    twin = copy.deepcopy(envs)
    there, back = envs.step(np.ones((2, 1)))[0], twin.step(-np.ones((2, 1)))[0]
    assert np.all(there[:, 0] > back[:, 0])
    assert np.array_equal(there[:, 6:], back[:, 6:])


def test_a_given_target_is_the_nearest_place_that_each_arm_can_reach():
    arms = [ArmSpecification(), ArmSpecification(length=0.3)]
    envs = ReachTips(2, arms)
    seen, _ = envs.reset(options={"target": (0.1, -0.2)})
    for row, arm in zip(seen, arms, strict=True):
        np.testing.assert_allclose(row, ReachTip(arm).reset(options={"target": (0.1, -0.2)})[0], rtol=0, atol=1e-9)
    assert np.linalg.norm(seen[1, 6:8] - seen[0, 6:8]) > 1e-3


@pytest.mark.parametrize("actions", [np.full((2, 1), np.nan), np.array([[0.0], [1.01]]), np.zeros(2), np.zeros((3, 1))])
def test_bad_actions_get_a_clear_error_and_change_nothing(actions):
    envs, twin = ReachTips(2), ReachTips(2)
    envs.reset(seed=0)
    twin.reset(seed=0)
    with pytest.raises(InputError, match=r"actions: expected numbers from -1 to 1, shape \(2, 1\)"):
        envs.step(actions)
    assert np.array_equal(envs.step(np.zeros((2, 1)))[0], twin.step(np.zeros((2, 1)))[0])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"num_envs": 0}, "environment: expected one for all, or one for each of 0"),
        ({"num_envs": 3, "arm": [ArmSpecification()] * 2}, "one for each of 3 environments, got 2 arms"),
        ({"num_envs": 2, "effects": [[], [], []]}, "got 2 arms, 3 sequences of effects"),
        ({"num_envs": 2, "arm": [ArmSpecification(), ArmSpecification(links=5)]}, "arms: expected the same links"),
        ({"num_envs": 2, "effects": [[], [parse_effect("tip_mass:mass=0.02")]]}, "arms: expected the same links"),
        ({"num_envs": 2, "dt": 0.0}, "environment: expected largest_torque and dt above zero"),
        ({"num_envs": 2, "largest_torque": [1.0, -1.0]}, "environment: expected largest_torque and dt above zero"),
    ],
)
def test_a_bad_environment_gets_a_clear_error(given, message):
    with pytest.raises(InputError, match=message):
        ReachTips(**given)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"seed": [1, 2, 3]}, "seed: expected a number, or 2 of them, got 3"),
        ({"options": {"reset_mask": np.zeros(2, dtype=bool)}}, "reset_mask: expected 2 truth values, one true at least"),
        ({"options": {"reset_mask": np.ones(3, dtype=bool)}}, "reset_mask: expected 2"),
        ({"options": {"path": 0}}, "reset options: expected torque"),
        ({"options": {"torque": 5.0}}, "torque: expected -1.11 to 1.11 N m, got 5.0"),
    ],
)
def test_a_bad_reset_gets_a_clear_error(given, message):
    with pytest.raises(InputError, match=message):
        ReachTips(2).reset(**given)


def test_a_step_before_a_reset_gets_a_clear_error():
    with pytest.raises(InputError, match="a reset before the first"):
        ReachTips(2).step(np.zeros((2, 1)))

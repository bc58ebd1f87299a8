"""The environments keep Gymnasium's promises and their own units."""

import builtins
import copy
import sys

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="needs the group gym")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from hsr_pin.control import registration  # noqa: E402
from hsr_pin.control.dynamics import ArmDynamics  # noqa: E402
from hsr_pin.control.environment import FollowTip, ReachTip  # noqa: E402
from hsr_pin.control.registration import ENVIRONMENTS, register  # noqa: E402
from hsr_pin.control.stepping import ArmSimulator  # noqa: E402
from hsr_pin.effects import parse_effect  # noqa: E402
from hsr_pin.errors import InputError, MissingDependencyError  # noqa: E402
from hsr_pin.robot.specification import ArmSpecification  # noqa: E402

both = pytest.mark.parametrize("kind", [ReachTip, FollowTip])


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_a_registered_environment_passes_gymnasiums_own_checker(name):
    register()
    register()
    check_env(gymnasium.make(name).unwrapped)


@both
def test_an_environment_with_effects_passes_too(kind):
    effects = [parse_effect("dead_time:delay=0.03"), parse_effect("hysteresis:amplitude=0.1")]
    check_env(kind(ArmSpecification(links=6, keq=2.33), effects), skip_render_check=True)


@both
def test_observations_are_in_the_units_that_are_documented(kind):
    environment = kind()
    environment.reset(seed=4)
    arm, shares = ArmSimulator(ArmSpecification(), torque_range=(-2, 2)), (0.5, 0.6, -0.2)
    for share in shares:
        seen, reward, *_, facts = environment.step(np.array([share]))
        state = arm.step(1.11 * share, dt=0.02)
    model = ArmDynamics(ArmSpecification())
    tip = arm.observe()[-1, [0, 2]]
    np.testing.assert_allclose(seen[:2], tip, atol=1e-12)
    ways = [model.tip(state.angles + w * state.rates)[[0, 2]] for w in (-1e-6, 1e-6)]  # [m] in 1 us
    np.testing.assert_allclose(seen[2:4], (ways[1] - ways[0]) / 2e-6, atol=1e-8)
    np.testing.assert_allclose(seen[4:6], [state.angles.sum(), state.rates.sum()], atol=1e-12)
    assert facts["distance"] == pytest.approx(np.linalg.norm(seen[6:8] - tip))
    assert reward == pytest.approx(-facts["distance"] / 0.24)
    assert facts["time"] == pytest.approx(0.06)


def test_a_copied_environment_goes_its_own_way():
    environment = ReachTip()
    environment.reset(seed=0)
    environment.step(np.ones(1))
    twin = copy.deepcopy(environment)
    there, back = environment.step(np.ones(1))[0], twin.step(-np.ones(1))[0]
    assert there[0] > back[0]
    assert np.array_equal(there[6:], back[6:])


def test_a_target_can_be_reached_and_held():
    environment = ReachTip()
    seen, _ = environment.reset(options={"target": (0.1, -0.2)})
    target, bend = seen[6:8], 0.0
    for _ in range(environment.steps):
        bend += 0.4 * (target[0] - seen[0])  # integral control of the torque
        seen, reward, terminated, truncated, facts = environment.step(np.clip([bend], -1, 1))
    assert truncated and not terminated
    assert facts["distance"] < 2e-3
    assert reward > -0.01


def test_the_path_is_seen_ahead_and_starts_at_rest():
    environment = FollowTip()
    first, _ = environment.reset(seed=1)
    np.testing.assert_allclose(first[6:8], [0.0, -0.24], atol=1e-9)
    later = [environment.step(np.zeros(1))[0] for _ in range(5)][-1]
    np.testing.assert_allclose(later[6:8], first[8:10])


def test_the_same_seed_gives_the_same_path_and_another_another():
    first, second, other = (FollowTip().reset(seed=seed)[0] for seed in (1, 1, 2))
    assert np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_an_arm_that_leaves_its_limit_ends_the_episode_at_the_worst_price():
    environment = ReachTip(largest_torque=8.0)
    environment.reset(seed=0, options={"target": (0.1, -0.2)})
    total, ended = 0.0, False
    while not ended:
        _, reward, ended, truncated, facts = environment.step(np.ones(1))
        total += reward
        assert not truncated
    assert "bending limit" in facts["failure"]
    assert reward <= -2 * (environment.steps - 20)


@pytest.mark.parametrize("action", [np.array([np.nan]), np.array([1.01]), np.zeros(2), 0.5])
def test_a_bad_action_gets_a_clear_error(action):
    environment = ReachTip()
    environment.reset(seed=0)
    with pytest.raises(InputError, match=r"action: expected one number from -1 to 1, shape \(1,\)"):
        environment.step(action)


@pytest.mark.parametrize(
    ("kind", "options", "message"),
    [
        (ReachTip, {"target": (np.nan, 0.0)}, "tip position"),
        (ReachTip, {"path": 0}, "reset options"),
        (FollowTip, {"path": np.zeros((3, 2))}, r"path: expected finite x and z \[m\], shape \(151, 2\)"),
        (FollowTip, {"torque": 5.0}, "torque"),
    ],
)
def test_a_bad_reset_gets_a_clear_error(kind, options, message):
    with pytest.raises(InputError, match=message):
        kind().reset(options=options)


def test_a_bad_environment_gets_a_clear_error():
    with pytest.raises(InputError, match="environment"):
        ReachTip(dt=0.0)


def test_without_gymnasium_the_group_is_named(monkeypatch):
    real = builtins.__import__

    def absent(name, *rest, **more):
        if name.split(".")[0] == "gymnasium":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", absent)
    monkeypatch.delitem(sys.modules, "hsr_pin.control.environment")
    with pytest.raises(MissingDependencyError, match=r"hsr_pin\[gym\]"):
        import hsr_pin.control.environment  # noqa: F401
    with pytest.raises(MissingDependencyError, match=r"hsr_pin\[gym\]"):
        registration.register()


def test_gymnasium_finds_the_environments_by_the_module_that_registers_them():
    for name in ENVIRONMENTS:
        gymnasium.registry.pop(name, None)
    sys.modules.pop("hsr_pin.control.registration")
    try:
        environment = gymnasium.make("hsr_pin.control.registration:hsr_pin/ReachTip-v0")
    finally:
        sys.modules["hsr_pin.control.registration"] = registration
    assert environment.reset(seed=1)[0].shape == environment.observation_space.shape

"""The derivatives of marker positions are those of the sensitivity equations, and of closed forms."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp

from hsr_pin.effects.stiffening import Stiffening
from hsr_pin.errors import InputError
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.batch import simulate_batch
from hsr_pin.simulation.result import Outcome
from hsr_pin.simulation.scenario import Pose, Scenario, Settled, step_scenario
from hsr_pin.simulation.sensitivity import sensitivities, value_of, with_value

ARM = ArmSpecification(links=3, mount="horizontal", tip_mass=0.05)


def analytic(scenario):
    """(T, M, 3, 2) derivatives to keq and damping: d/dt of dy/dp is J dy/dp + df/dp, by pin.computeABADerivatives and Radau."""
    arm, n = scenario.arm, scenario.arm.links
    model = build_model(arm).model
    data, k, c = model.createData(), n * arm.keq, n * arm.damping

    def slope(_, y):
        q, v, s = y[:n], y[n : 2 * n], y[2 * n :].reshape(2 * n, 2)
        tau = scenario.torque[0] - k * q - c * v
        da_dq, da_dv, inverse = pin.computeABADerivatives(model, data, q, v, tau)
        inverse = np.triu(inverse) + np.triu(inverse, 1).T
        ds = (da_dq - k * inverse) @ s[:n] + (da_dv - c * inverse) @ s[n:] - n * inverse @ np.column_stack([q, v])
        return np.concatenate([v, pin.aba(model, data, q, v, tau), s[n:].ravel(), ds.ravel()])

    start = np.concatenate([scenario.start.angles, np.zeros(5 * n)])
    run = solve_ivp(slope, scenario.time[[0, -1]], start, "Radau", scenario.time, rtol=1e-7, atol=1e-10)
    q, dq = run.y[:n].T, run.y[2 * n : 4 * n].T.reshape(-1, n, 2)
    places = marker_map(arm, [m.arc_length for m in scenario.markers])
    turn = 1e-6
    jacobian = [(places.positions(q + turn * e) - places.positions(q - turn * e)) / (2 * turn) for e in np.eye(n)]
    return np.einsum("jtmx,tjp->tmxp", jacobian, dq)


def test_derivatives_are_those_of_the_sensitivity_equations():
    scenario = Scenario(ARM, np.arange(21) * 0.02, np.full(21, 0.5), Pose(np.full(3, 0.1)))
    _, (found,) = sensitivities([scenario], ["keq", "damping"], step=1e-3)
    exact = analytic(scenario)
    for p in range(2):
        assert np.abs(found[..., p] - exact[..., p]).max() < 1e-5 * np.abs(exact[..., p]).max()


@pytest.mark.parametrize("name", ["keq", "damping", "mass", "tip_mass", "tilt"])
def test_derivatives_do_not_depend_on_the_size_of_the_difference(name):
    scenario = step_scenario(ARM, 1.0, duration=0.5)
    (_, (coarse,)), (_, (fine,)) = (sensitivities([scenario], [name], fraction=f) for f in (2e-3, 5e-4))
    assert np.abs(coarse - fine).max() < 1e-5 * np.abs(fine).max()


def test_tilting_a_weightless_arm_turns_its_markers(weightless):
    (result,), (found,) = sensitivities([Scenario(ARM, [0.0, 0.01], [0.5, 0.5], Settled(0.5))], ["tilt"])
    axis = build_model(ARM).joint_axis
    np.testing.assert_allclose(found[..., 0], np.cross(axis, result.trajectory.positions), atol=1e-8)


def test_at_a_bound_the_differences_are_one_sided_and_as_good():
    arm = ArmSpecification(links=3, mount="horizontal", tip_mass=0.0)
    scenario = step_scenario(arm, 1.0, duration=0.5)
    _, (at_bound,) = sensitivities([scenario], ["tip_mass"])
    _, (fine,) = sensitivities([scenario], ["tip_mass"], fraction=1e-4)
    assert np.abs(at_bound - fine).max() < 1e-4 * np.abs(fine).max()


def test_the_run_itself_is_the_single_run():
    scenario = step_scenario(ARM, 1.0, duration=0.3)
    (together,), _ = sensitivities([scenario], ["keq", "tip_mass"])
    (alone,) = simulate_batch([scenario])
    np.testing.assert_array_equal(together.trajectory.joint_angles, alone.trajectory.joint_angles)


def test_scenarios_of_different_length_go_together():
    scenarios = [step_scenario(ARM, 1.0, duration=d) for d in (0.2, 0.7)]
    results, found = sensitivities(scenarios, ["keq", "damping"])
    assert [x.shape for x in found] == [(len(r.scenario.time), 3, 3, 2) for r in results] == [(21, 3, 3, 2), (71, 3, 3, 2)]


def test_a_failed_run_has_no_derivatives():
    results, (lost, found) = sensitivities([step_scenario(ARM, 9.0), step_scenario(ARM, 0.5)], ["keq"])
    assert [result.outcome for result in results] == [Outcome.BENDING_LIMIT, Outcome.COMPLETED]
    assert np.isnan(lost).all()
    assert np.isfinite(found).all()


def test_an_unknown_parameter_is_refused_with_those_there_are():
    with pytest.raises(InputError, match="expected keq, damping, mass, tip_mass, tilt, cross_tilt, torsion, got 'stifness'"):
        sensitivities([step_scenario(ARM, 0.5)], ["stifness"])


def test_a_parameter_of_an_effect_goes_by_the_name_of_both():
    scenario = step_scenario(ARM, 0.5, effects=(Stiffening(0.1),))
    changed = with_value(scenario, "stiffening.cubic", 0.2)
    assert value_of(changed, "stiffening.cubic") == 0.2
    assert changed.arm is scenario.arm


def test_a_stiffening_law_straightens_a_settled_arm_as_its_equilibrium_says(weightless):
    arm, torque = ArmSpecification(links=1), 0.8
    scenario = Scenario(arm, [0.0, 0.01], [torque, torque], Settled(torque), (Stiffening(0.1),))
    (result,), (found,) = sensitivities([scenario], ["stiffening.cubic"])
    phi = result.trajectory.joint_angles[0, 0]  # keq (phi + cubic phi^3) = torque
    slope = -(phi**3) / (1 + 0.3 * phi**2)
    tangent = arm.length * np.array([np.cos(phi), 0, np.sin(phi)])
    np.testing.assert_allclose(found[0, -1, :, 0], tangent * slope, atol=1e-8)


def test_an_arm_with_a_hundredth_of_the_papers_damping_has_its_derivative():
    arm = ArmSpecification(length=0.1, mass=0.096, diameter=0.03, keq=0.178, damping=5e-4, mount="horizontal", placement="mid")
    scenario = Scenario(arm, np.arange(31) * 0.01, np.zeros(31), Pose(np.zeros(4)))
    (base,), (slopes,) = sensitivities([scenario], ["damping"], fraction=0.02)
    assert base.completed
    assert np.isfinite(slopes).all()
    assert np.abs(slopes[-1]).max() > 0.1


@pytest.mark.parametrize("damping", [0.0, 5e-324, 1e-250])
def test_next_to_no_damping_is_changed_as_none_is(damping):
    scenario = step_scenario(ArmSpecification(links=2, damping=damping), 0.3, duration=0.3)
    _, (slopes,) = sensitivities([scenario], ["damping"])
    assert np.isfinite(slopes).all() and np.abs(slopes).max() > 0

"""The pressure map is Eqs. (1), (4), (5) of the paper, both ways, and knows how far the 16 rows behind it carry."""

import math

import numpy as np
import pytest
from scipy.optimize import curve_fit

from hsr_pin.errors import PressureError
from hsr_pin.robot.combinations import TABLE_II, combinations
from hsr_pin.robot.pressure import PAPER, PressureMap, measured_rows

FITTED = PressureMap.fit()


def to_digits(value, digits):
    return float(f"{value:.{digits}g}")


def test_the_shipped_rows_are_those_of_the_paper(shared):
    source = shared / "facts" / "hsr2022_table2_shape_pressure_stiffness.csv"
    np.testing.assert_array_equal(measured_rows(), np.loadtxt(source, delimiter=",", skiprows=1))
    assert measured_rows().shape == (16, 4)


def test_refitting_the_16_rows_gives_both_equations_to_every_printed_digit():
    assert tuple(to_digits(a, 4) for a in FITTED.stiffness_plane) == (-2.594, 0.8183, 1.415) == PAPER.stiffness_plane
    assert tuple(to_digits(b, 4) for b in FITTED.bending_plane) == (-0.7742, -0.2892, 0.7321) == PAPER.bending_plane


def test_one_wrong_row_would_show_in_the_refit():
    rows = measured_rows()
    rows[3, 3] += 0.01
    assert to_digits(PressureMap.fit(rows).stiffness_plane[0], 4) != -2.594


@pytest.mark.parametrize("row", TABLE_II, ids=str)
def test_table_ii_pressures_give_its_stiffness_and_torque(row):
    P = (row.P1, row.P2)
    assert float(PAPER.stiffness(P)) == pytest.approx(row.keq, abs=2e-3)
    assert float(PAPER.torque(P)) == pytest.approx(row.tau, abs=1e-3)
    assert float(PAPER.torque(P, row.keq)) == pytest.approx(row.tau, abs=1e-3)


def test_table_ii_comes_out_of_the_equations_to_the_printed_digit_but_for_two_swapped_ones():
    solved = [tuple(np.round(PAPER.pressures_for_torque(row.keq, row.tau), 4).tolist()) for row in TABLE_II]
    printed = [(row.P1, row.P2) for row in TABLE_II]
    assert printed[2] == (0.3368, 2.4218)
    assert solved[2] == (0.3386, 2.4218)
    assert solved[:2] + solved[3:] == printed[:2] + printed[3:]


@pytest.mark.parametrize(("keq", "tau"), [(1.11, [0.25, 0.625, 1.0]), (2.33, [0.1, 1.8, 3.5])])
def test_the_three_combinations_of_a_stiffness_are_found(keq, tau):
    assert [row.tau for row in combinations(keq)] == tau
    assert {row.keq for row in combinations(keq)} == {keq}


def test_a_stiffness_without_combinations_says_what_to_give_instead():
    with pytest.raises(PressureError, match=r"stiffness of 1\.11 or 2\.33 Nm/rad, got 2; .* specify pressures or a torque$"):
        combinations(2.0)


def test_pressures_and_what_they_do_are_inverse_over_arrays():
    keq, phi = np.meshgrid([0.5, 1.11, 2.33, 3.5], np.linspace(0.0, 0.8, 5))
    P = PAPER.pressures_for(keq, phi)
    assert P.shape == (5, 4, 2)
    np.testing.assert_allclose(PAPER.stiffness(P), keq, atol=1e-12)
    np.testing.assert_allclose(PAPER.bending(P), phi, atol=1e-12)
    np.testing.assert_allclose(PAPER.torque(P), keq * phi, atol=1e-12)
    np.testing.assert_allclose(PAPER.pressures_for_torque(keq, keq * phi), P, atol=1e-12)


@pytest.mark.parametrize("keq", [0.3, 1.11, 2.33, 4.0, 6.0])
def test_the_ends_of_the_reachable_range_are_reached_with_a_pressure_at_its_limit(keq):
    for phi, tau in zip(PAPER.bending_range(keq), PAPER.torque_range(keq), strict=True):
        assert tau == pytest.approx(keq * phi)
        P = PAPER.pressures_for(keq, phi)
        assert min(np.min(np.abs(P)), np.min(np.abs(P - PAPER.max_pressure))) < 1e-9
        beyond = phi + math.copysign(1e-3, phi - sum(PAPER.bending_range(keq)) / 2)
        with pytest.raises(PressureError, match="bending at Keq"):
            PAPER.pressures_for(keq, beyond)


def test_the_pressure_range_is_the_first_whole_bar_that_holds_table_i_and_table_ii():
    assert max(max(row.P1, row.P2) for row in TABLE_II) < PAPER.max_pressure
    for keq in (0.1, 1.0, 2.0, 3.0, 4.0):
        low, high = PAPER.bending_range(keq)
        assert low < 0 < high
    smaller = PressureMap(PAPER.stiffness_plane, PAPER.bending_plane, max_pressure=3.0)
    assert smaller.bending_range(4.0)[0] > 0


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: PAPER.torque([1.0, 4.2]), r"P2: expected a pressure from 0 to 4 bar, got 4\.2"),
        (lambda: PAPER.bending([[1.0, 2.0], [-0.1, 2.0]]), r"P1: expected a pressure from 0 to 4 bar, got -0\.1"),
        (lambda: PAPER.torque([math.nan, 2.0]), r"pressures: expected finite numbers, got nan"),
        (lambda: PAPER.torque([1.0, math.inf]), r"pressures: expected finite numbers, got inf"),
        (lambda: PAPER.torque([1.0, 2.0, 3.0]), r"pressures: expected P1 and P2 .*got \(3,\)"),
        (lambda: PAPER.torque(1.0), r"pressures: expected P1 and P2 .*got \(\)"),
        (lambda: PAPER.torque("high"), r"pressures: expected numbers, got 'high'"),
        (lambda: PAPER.torque([1.0, 2.0], 0.0), r"keq: expected a stiffness above zero .*got 0"),
        (lambda: PAPER.stiffness([0.0, 0.0]), r"stiffness at P1, P2 = 0, 0 bar: .*6\.34 Nm/rad, got -2\.594 by Eq. \(1\)"),
        (
            lambda: PAPER.pressures_for_torque(1.11, 2.0),
            r"bending at Keq 1\.11 .*torque -1\.896 to 1\.268 N m.*got 1\.8.* \(2 N m\)",
        ),
        (lambda: PAPER.pressures_for_torque(1.11, math.nan), r"tau: expected finite numbers, got nan"),
        (lambda: PAPER.pressures_for(-1.0, 0.5), r"keq: expected a stiffness above zero .*got -1"),
        (lambda: PAPER.pressures_for(7.0, 0.5), r"keq: expected more than 0 and up to 6\.34 Nm/rad, got 7"),
        (lambda: PressureMap.fit(np.zeros((3, 4))), r"rows: expected four or more rows of phi, P1, P2, Keq, got shape \(3, 4\)"),
        (lambda: PressureMap.fit(np.zeros((5, 4))), r"rows: .*got pressures on one line"),
        (lambda: PressureMap.fit(np.full((5, 4), np.nan)), r"rows: expected finite numbers, got nan"),
        (
            lambda: PressureMap((1.0, 1.0, 1.0), (0.0, 2.0, 2.0)),
            r"planes: expected stiffness and bending with linearly independent",
        ),
        (lambda: PressureMap((1.0, 1.0, 1.0), (0.0, 2.0, 1.0), max_pressure=0), r"max_pressure: expected more than zero"),
    ],
)
def test_what_the_map_cannot_do_is_one_clear_line(call, said):
    with pytest.raises(PressureError, match=said) as caught:
        call()
    assert "\n" not in str(caught.value)


def test_the_scatter_about_the_planes_is_the_one_measured():
    root_mean_square = np.array(FITTED.scatter.residual) * math.sqrt(13 / 16)
    np.testing.assert_allclose(root_mean_square, [0.136, 0.0232], rtol=0.005)


def test_uncertainty_is_what_repeating_the_experiment_shows():
    """An independent oracle: draw new rows from the fitted planes and their scatter, refit, look at the spread."""
    rng, rows = np.random.default_rng(2), measured_rows()
    P = np.array([[0.8127, 2.1477], [0.3807, 3.2597]])
    keq, phi = FITTED.stiffness(rows[:, 1:3]), FITTED.bending(rows[:, 1:3])
    planes, singles = [], []
    for _ in range(4000):
        noise = rng.multivariate_normal([0, 0], FITTED.scatter.residual_covariance, 16)
        again = PressureMap.fit(np.c_[phi + noise[:, 1], rows[:, 1:3], keq + noise[:, 0]])
        plane = np.array([np.asarray(x + P @ c) for x, *c in (again.stiffness_plane, again.bending_plane)])
        single = plane + rng.multivariate_normal([0, 0], FITTED.scatter.residual_covariance, 2).T
        planes.append([*plane, plane[0] * plane[1]])
        singles.append([*single, single[0] * single[1]])
    said = FITTED.uncertainty(P)
    np.testing.assert_allclose(np.std(planes, axis=0), [said.keq_mean, said.phi_mean, said.tau_mean], rtol=0.05)
    np.testing.assert_allclose(np.std(singles, axis=0), [said.keq_single, said.phi_single, said.tau_single], rtol=0.05)


def test_coefficients_are_as_uncertain_as_scipys_own_fit_says():
    rows = measured_rows()
    for response, values in ((0, rows[:, 3]), (1, rows[:, 0])):
        _, covariance = curve_fit(lambda x, a, b, c: a + b * x[0] + c * x[1], rows[:, 1:3].T, values)
        np.testing.assert_allclose(FITTED.scatter.coefficient_covariance(response), covariance, rtol=1e-5)


def test_a_known_stiffness_leaves_only_the_bending_uncertain():
    both, bending = PAPER.uncertainty([0.8127, 2.1477]), PAPER.uncertainty([0.8127, 2.1477], keq=1.11)
    assert float(bending.keq_single) == 0
    assert float(bending.tau_single) == pytest.approx(1.11 * float(bending.phi_single))
    assert float(bending.tau_single) < float(both.tau_single)


def test_extrapolation_is_flagged_outside_of_the_measured_pressures_only():
    assert not PAPER.uncertainty(measured_rows()[:, 1:3]).extrapolates.any()
    flagged = PAPER.uncertainty([(row.P1, row.P2) for row in TABLE_II]).extrapolates
    assert flagged.tolist() == [True, False, True, True, True, True]

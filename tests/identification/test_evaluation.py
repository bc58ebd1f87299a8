"""What a hypothesis predicts: commands held or interpolated as declared, derivatives as they are, families as single ones."""

from dataclasses import replace

import numpy as np
import pytest

from hsr_pin.effects import EFFECTS
from hsr_pin.identification.evaluation import predict, predict_all, predict_with_slopes, simulate_run
from hsr_pin.identification.experiment import prepare
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.identification.part import Part
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import residuals, rms

TRUE = np.array([1.0, 1.0])


def missed(experiment):
    return rms(residuals(experiment, predict_all(experiment, Hypothesis(), TRUE)))


def test_a_command_is_interpolated_where_the_run_says_so_and_held_where_it_does_not(record):
    """Each against recordings made in either way; half a sample of delay lies between them."""
    slope = 8.0 * np.clip(0.01 * np.arange(101) - 0.1, 0.0, 0.15)
    for interpolated in (False, True):
        experiment = prepare(record([(1.11, slope)], interpolated=interpolated, noise=1e-5))
        alike, other = (
            replace(experiment, runs=tuple(replace(run, interpolated=reading) for run in experiment.runs))
            for reading in (interpolated, not interpolated)
        )
        assert missed(alike) < 1e-4
        assert missed(other) > 4 * missed(alike)


def test_interpolated_commands_give_the_same_parameters_at_half_the_rate(record):
    smooth = 0.6 * np.sin(6.0 * np.clip(0.01 * np.arange(201) - 0.1, 0.0, None))
    dataset = record([(1.11, smooth)], keq=1.1, damping=0.8, seconds=2.0, interpolated=True, noise=1e-5)
    trajectory = dataset.trials[0].trajectory
    coarse = replace(trajectory, time=trajectory.time[::2], positions=trajectory.positions[::2], torque=trajectory.torque[::2])
    experiment = prepare(replace(dataset, trials=(replace(dataset.trials[0], trajectory=coarse),)))
    held, interpolated = (
        fit(replace(experiment, runs=(replace(experiment.runs[0], interpolated=reading),)), Hypothesis())
        for reading in (False, True)
    )
    assert interpolated.values == pytest.approx([1.1, 0.8], rel=5e-3)
    assert held.rms > 10 * interpolated.rms


@pytest.mark.parametrize("effect", [EFFECTS["actuator_lag"](0.08), EFFECTS["tip_mass"](0.02), EFFECTS["viscoelastic"](0.4, 0.4)])
@pytest.mark.parametrize("command", [0.8, None])
def test_derivatives_are_those_of_wide_differences_of_converged_simulations(record, effect, command):
    experiment = prepare(record([(1.11, command)], effects=[effect]))
    model = Hypothesis(tolerance=1e-7).with_part(Part("torque_gain")).with_effects(effect)
    values = model.start
    (found,) = predict_with_slopes(experiment, Hypothesis(model.effects, model.free), values, central=True)
    (run,) = experiment.runs
    for place, scale in enumerate(model.scale):
        width = 0.02 * scale * np.eye(len(values))[place]
        ahead, behind = (p.positions for p in predict(experiment, model, [(run, values + width), (run, values - width)]))
        chord = (ahead - behind) / 2 / 0.02
        away = found.slopes[..., place] * scale - chord
        assert np.abs(away).max() < max(0.03 * np.abs(chord).max(), 2e-5)


def test_arms_side_by_side_move_as_each_alone(record):
    """To the error of a step: all take the steps of the first."""
    experiment = prepare(record([(1.11, 0.8)]))
    (run,) = experiment.runs
    model = Hypothesis(tolerance=1e-7).with_effects(EFFECTS["hysteresis"](0.1, 0.3))
    points = model.start * np.array([[1.0] * 4, [1.1, 0.7, 1.0, 1.0], [0.9, 1.2, 0.5, 1.2]])
    together = simulate_run(experiment, run, model, points).positions
    for k, point in enumerate(points):
        assert together[:, k] == pytest.approx(simulate_run(experiment, run, model, point[None]).positions[:, 0], abs=2e-5)


def test_the_compiled_loop_predicts_what_the_one_over_pinocchio_does(record):
    experiment = prepare(record([(1.11, 0.8), (1.11, None)], seconds=0.4))
    model = Hypothesis(links=4).with_effects(EFFECTS["dry_friction"](0.05))
    for run in experiment.runs:
        compiled, reference = (
            simulate_run(experiment, run, model, model.start[None], dynamics=dynamics).positions
            for dynamics in ("compiled", "aba")
        )
        assert compiled == pytest.approx(reference, abs=1e-9)


@pytest.mark.parametrize("command", [0.8, None])
def test_where_one_in_three_samples_is_looked_at_these_are_as_among_all(record, command):
    """A release begins between two samples; a torque far too large ends the simulation early."""
    experiment = prepare(record([(1.11, command)]))
    (run,) = experiment.runs
    few = replace(run, every=3)
    points = np.array([[1.0, 1.0], [1.2, 0.5], [0.05, 1.0]])
    whole, third = (simulate_run(experiment, each, Hypothesis(), points).positions for each in (run, few))
    np.testing.assert_array_equal(third, whole[::3])
    np.testing.assert_array_equal(few.compared, run.compared[::3])
    slopes, some = (
        predict_with_slopes(replace(experiment, runs=(each,), rest_scatter=1e-3), Hypothesis(), TRUE)[0] for each in (run, few)
    )
    np.testing.assert_array_equal(some.slopes, slopes.slopes[::3])
    assert some.nuisance.shape[-1] == (1 if command else 6)
    np.testing.assert_allclose(some.nuisance, slopes.nuisance[::3], atol=0.15 * np.abs(slopes.nuisance).max())


def test_what_hardly_moves_is_integrated_as_finely_for_its_size(record):
    """Of a swing of a millimetre that lasts, what a step may be in error by in one of centimetres is a good part."""
    experiment = prepare(record([(1.11, 0.005)], damping=0.1, seconds=3.0, noise=1e-6))
    (run,) = experiment.runs
    found, converged = (predict_all(experiment, Hypothesis(tolerance=each), TRUE * [1.0, 0.1])[0] for each in (2e-4, 1e-8))
    moved = run.compared - run.compared.mean(axis=0)
    assert rms([found.positions - converged.positions]) < 0.05 * rms([moved])


def test_how_far_the_arm_moves_is_told_where_a_coordinate_of_a_marker_was_never_seen(record):
    (run,) = prepare(record([(1.11, 0.8)])).runs

    def without(*at):
        hidden = run.measured.copy()
        hidden[(slice(None), *at)] = np.nan
        return replace(run, measured=hidden).moved

    assert without(0, 0) == run.moved  # a coordinate of the marker in the middle, which goes less far
    assert 0 < without(1, 0) < run.moved  # of the tip's
    assert without() == 0.0

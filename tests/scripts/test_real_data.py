"""What a table of predictions leaves out: how rests scatter from trial to trial, and nothing that a model should foretell."""

import numpy as np
import pytest

from hsr_pin.inference.residuals import rms

SCRIPT = "real_data"


def test_the_scatter_of_rests_is_taken_out_and_what_all_rests_have_in_common_is_not(script):
    generator = np.random.default_rng(0)
    common, scatter = np.array([0.0, 1.6e-3]), np.array([[2e-3, 0.0], [-2e-3, 1e-3], [0.0, -1e-3]])
    swings = 1e-4 * generator.standard_normal((3, 80, 1, 2))
    swings[:, -30:] = 0.0  # at rest
    left = script.aligned([swing + common + own for swing, own in zip(swings, scatter, strict=True)])
    np.testing.assert_allclose(left, swings + common, atol=1e-12)
    assert rms(left) == pytest.approx(1.6e-3, rel=0.02)

"""How fast markers are seen to move is the slope of where they are seen, with effects of the cameras too."""

import numpy as np
import pytest

from hsr_pin.effects import parse_effect
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.cameras import Cameras


@pytest.mark.parametrize("effects", [(), ("length_change:depth=0.03", "marker_offset:offset=0.004")])
@pytest.mark.parametrize("bending", ["plane", "space"])
def test_velocities_are_the_slope_of_positions(effects, bending):
    arm = ArmSpecification(links=5, placement="mid", bending=bending)
    batch = ArmBatch(Arms.of([arm, arm]), tuple(map(parse_effect, effects)))
    cameras = Cameras(batch, [0.1, 0.24])
    q, v = 0.3 * np.random.default_rng(0).normal(size=(2, 3, 2, batch.coordinates))
    step = 1e-5
    slope = (cameras.positions(q + step * v) - cameras.positions(q - step * v)) / (2 * step)
    assert np.abs(slope).max() > 0.01
    assert cameras.velocities(q, v) == pytest.approx(slope, abs=1e-3 * np.abs(slope).max())


@pytest.mark.parametrize("width", [0.2, 2.0], ids=["as links bend", "farther than the series hold"])
@pytest.mark.parametrize("arms", [1, 2], ids=["one map for all", "a map for each"])
def test_machine_code_sees_what_the_map_of_markers_says(width, arms):
    rng = np.random.default_rng(1)
    several = [ArmSpecification(links=7, length=0.24 + 0.1 * k * (arms - 1), tilt=0.3 * k * (arms - 1)) for k in range(2)]
    batch = ArmBatch(Arms.of(several), ())
    fast, slow = (Cameras(batch, [0.05, 0.1, 0.24], fast=fast) for fast in (True, False))
    q = np.clip(width * rng.normal(size=(8, 2, 7)), -1.2 * width, 1.2 * width)[::2]
    assert len(fast.places.fixed) == arms
    assert (np.abs(q).max() > 0.5) == (width > 0.5)
    assert fast.positions(q) == pytest.approx(slow.positions(q), rel=0, abs=1e-14)

"""Obstacles are declared in ``dataset.toml``, survive being written, and faults in them are named with their place."""

from __future__ import annotations

import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.obstacles import Box, Cylinder, HalfSpace, Sphere, Surface
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset
from hsr_pin.robot.specification import ArmSpecification

TABLES = """
[[obstacle]]
shape = "half_space"
point = [0.0, 0.0, -0.3]
material = "rubber"

[[obstacle]]
shape = "cylinder"
centre = [0.06, 0.0, -0.14]
radius = 0.01
friction = 0.0

[[obstacle]]
shape = "sphere"
centre = [1, 0, 0]
radius = 0.1
stiffness = 2e6

[[obstacle]]
shape = "box"
centre = [0.0, 0.1, 0.0]
size = [0.1, 0.2, 0.3]
rotation = [0.0, 0.5, 0.0]
"""
DECLARED = (
    HalfSpace(point=(0, 0, -0.3), **Surface.of("rubber")._asdict()),
    Cylinder(centre=(0.06, 0, -0.14), radius=0.01, friction=0.0),
    Sphere(centre=(1, 0, 0), radius=0.1, stiffness=2e6),
    Box(centre=(0, 0.1, 0), size=(0.1, 0.2, 0.3), rotation=(0, 0.5, 0)),
)


def declare(folder, text):
    path = folder / "dataset.toml"
    path.write_text(path.read_text(encoding="utf-8") + text, encoding="utf-8")
    return read_dataset(folder)


def test_declared_obstacles_are_those_of_the_arm_and_survive_being_written(folder, tmp_path):
    dataset = declare(folder, TABLES)
    assert dataset.obstacles == DECLARED
    assert ArmSpecification.from_trial(dataset, dataset.trials[0]).obstacles == DECLARED
    write_dataset(dataset, tmp_path / "again")
    assert read_dataset(tmp_path / "again").obstacles == DECLARED


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('shape = "sfere"', "shape.*sphere.*sfere"),
        ('shape = "sphere"\ncentre = [0, 0, 0]', "radius"),
        ('shape = "sphere"\ncentre = [0, 0]\nradius = 0.1', "centre.*three finite numbers"),
        ('shape = "sphere"\ncentre = [0, 0, 0]\nradius = -0.1', "radius.*above zero"),
        ('shape = "half_space"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]', "normal.*direction"),
        ('shape = "half_space"\npoint = [0, 0, 0]\nmaterial = "wool"', "material.*silicone.*wool"),
        ('shape = "half_space"\npoint = [0, 0, 0]\nradius = 1.0', "radius"),
        ('shape = "half_space"\npoint = [0, 0, 0]\nfriction = -1', "friction"),
        ('shape = "half_space"\npoint = [0, [1], 0]', "point.*three finite numbers"),
        ('shape = "cylinder"\ncentre = [0, 0, 0]\nradius = 0.1\nlength = "long"', "length.*above zero"),
        ('shape = "cylinder"\ncentre = [0, 0, 0]\nradius = 0.1\nlength = nan', "length.*above zero"),
    ],
)
def test_a_fault_is_named_with_its_place(folder, table, words):
    with pytest.raises(RecordingError, match=words) as caught:
        declare(folder, f"\n[[obstacle]]\n{table}\n")
    assert caught.value.file is not None
    assert caught.value.line > 20

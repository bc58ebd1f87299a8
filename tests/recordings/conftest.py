"""A known dataset, on disk and in memory."""

import numpy as np
import pytest

from hsr_pin.trajectory import Dataset, Marker, Trajectory, Trial

DECLARATION = """\
format = 1
name = "known"

[robot]
length = 0.24  # m
mass = 0.15
diameter = 0.04
mount = "hanging"
keq = 1.11

[[marker]]
name = "mid"
arc_length = 0.12

[[marker]]
name = "tip"
arc_length = 0.24

[[trial]]
file = "trial_01.csv"
damping = 0.05
"""

HEADER = "t,tau,mid_x,mid_y,mid_z,tip_x,tip_y,tip_z"


def bend(angle, arc_length, length=0.24):
    """(T, 3) [m] a point of a hanging arm of constant curvature, bent by (T,) angles [rad]."""
    angle = np.asarray(angle, dtype=float) * arc_length / length
    small = np.abs(angle) < 1e-6
    safe = np.where(small, 1.0, angle)
    x = np.where(small, angle / 2, (1 - np.cos(safe)) / safe)
    z = np.where(small, 1.0, np.sin(safe) / safe)
    return arc_length * np.stack([x, np.zeros_like(x), -z], axis=-1)


def csv_text(samples=20, step=0.01):
    time = np.arange(samples) * step
    rows = [HEADER]
    for t in time:
        mid, tip = (bend([3 * t], s)[0] for s in (0.12, 0.24))
        rows.append(",".join([f"{t:.6f}", "0.5", *(f"{value:.6f}" for value in (*mid, *tip))]))
    return "\n".join(rows) + "\n"


@pytest.fixture
def folder(tmp_path):
    """A good dataset on disk, to be spoiled."""
    path = tmp_path / "known"
    path.mkdir()
    (path / "dataset.toml").write_text(DECLARATION, encoding="utf-8")
    (path / "trial_01.csv").write_text(csv_text(), encoding="utf-8")
    return path


@pytest.fixture
def spoil(folder):
    """Replace a piece of a file of the good dataset; the piece must be there."""

    def change(file, old, new):
        text = (folder / file).read_text(encoding="utf-8")
        assert old in text, f"nothing to spoil: no {old!r}"
        (folder / file).write_text(text.replace(old, new, 1), encoding="utf-8")
        return folder

    return change


@pytest.fixture
def dataset():
    """The same motion in memory, with numbers of full precision, a gap, and everything that can be declared."""
    rng = np.random.default_rng(1)
    markers = (Marker("base", 0.0), Marker('mid "1"', 0.12), Marker("tip", 0.24))
    trials = []
    for number, kind in enumerate(("torque", "pressures", None), start=1):
        time = np.arange(50) / 120 + 0.1
        angle = np.sin(7 * time) * number
        positions = np.stack([bend(angle, marker.arc_length) for marker in markers], axis=1)
        positions += rng.normal(0, 1e-4, positions.shape)
        positions[10:14, 1] = np.nan
        given = {"torque": rng.normal(size=50), "pressures": rng.uniform(0, 3, (50, 2))}
        trajectory = Trajectory(time, markers, positions, **({kind: given[kind]} if kind else {}))
        trials.append(Trial(f"run-{number}", trajectory, 1.11 + number / 3, 0.05, 0.01 * number, None if kind else 0.2))
    return Dataset("a name", 0.24, 0.15, 0.04, "hanging", tuple(trials), description='say "é"', notes=("a note",))


@pytest.fixture(scope="session")
def bending():
    return bend

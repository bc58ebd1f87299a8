"""Datasets of the plants have the recording format, do not reveal the law, and follow from their seed alone."""

from __future__ import annotations

import ast
import csv
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hsr_pin.blind.plants.nuisance import Nuisance, noise_floor
from hsr_pin.blind.plants.program import KINDS, LEVELS, Program, pressures, program
from hsr_pin.errors import InputError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PLANTS = Path(__file__).parents[2] / "hsr_pin" / "blind" / "plants"
ALL = "+".join(sorted(KINDS))


def short(kinds: str = ALL, mount: str = "hanging", given: str = "pressures") -> Program:
    """Return one trial of each kind, cut to 0.3 s."""
    trials = []
    for name in kinds.split("+"):
        trial = program(name).trials[0]
        trials.append(replace(trial, duration=0.3, command=trial.command[:31]))
    return Program(mount, tuple(trials), given)


@pytest.fixture
def plant():
    pytest.importorskip("mujoco", reason="mujoco is not installed (dependency group blind)")
    from hsr_pin.blind.plants.chain import ChainPlant

    return ChainPlant(elements=6, step=5e-4)


def test_table_ii_is_met_by_the_pressures():
    table = {
        1.11: [(1.2868, 1.8735), (0.8127, 2.1477), (0.3368, 2.4218)],
        2.33: [(2.4285, 2.0755), (1.4046, 2.6676), (0.3807, 3.2597)],
    }
    for keq, rows in table.items():
        assert np.allclose(np.transpose(pressures(np.array(LEVELS[keq][1]), keq)), rows, atol=2e-3)


def test_an_unknown_program_lists_the_known_ones():
    with pytest.raises(InputError, match="staircase"):
        program("wiggle")


@pytest.mark.parametrize("mount", ["hanging", "upright", "horizontal"])
def test_a_dataset_obeys_the_format(plant, tmp_path, mount):
    asked = short(mount=mount, given="tau")
    folder = plant.run(asked, (), 5, tmp_path / "case")
    document = tomllib.loads((folder / "dataset.toml").read_text())
    assert document["format"] == 1
    assert document["robot"] == {"length": 0.24, "mass": 0.15, "diameter": 0.04, "mount": mount}
    assert [m["arc_length"] for m in document["marker"]] == [0.0, 0.12, 0.24]
    along = {"hanging": (0, 0, -1), "upright": (0, 0, 1), "horizontal": (1, 0, 0)}[mount]
    for trial, entry in zip(asked.trials, document["trial"], strict=True):
        rows = list(csv.reader((folder / entry["file"]).read_text().splitlines()))
        inputs = ["tau"] if trial.command else []
        assert rows[0] == ["t", *inputs, *(f"{m}_{axis}" for m in ("base", "mid", "tip") for axis in "xyz")]
        values = np.array(rows[1:], dtype=float)
        assert values.shape[0] == trial.samples
        assert np.allclose(np.diff(values[:, 0]), 0.01)
        if trial.command and trial.command[0] == 0:
            assert np.allclose(values[0, -3:], 0.24 * np.array(along), atol=0.05 if mount == "horizontal" else 0.003)
        assert entry.get("tip_mass", 0.0) == trial.tip_mass
        assert entry.get("t_start", 0.0) == trial.release


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(plant, tmp_path):
    def files(folder: Path) -> list[bytes]:
        return [path.read_bytes() for path in sorted(folder.glob("*.csv"))]

    a, b, c = (plant.run(short("steps"), (), seed, tmp_path / str(k)) for k, seed in enumerate((3, 3, 4)))
    assert files(a) == files(b) != files(c)


def test_no_file_reveals_the_law(plant, tmp_path):
    from hsr_pin.blind.plants import laws

    for name in laws.CATALOGUE:
        law = laws.draw(name, np.random.default_rng(1))
        folder = plant.run(short("steps"), (law,), 5, tmp_path / "case")
        document = tomllib.loads((folder / "dataset.toml").read_text())
        assert not set(document["trial"][0]) - {"file", "keq", "damping"}
        assert set(document) == {"format", "name", "robot", "marker", "trial"}


def test_tiny_nuisances_stay_below_half_the_noise(plant):
    nuisance = Nuisance.draw(np.random.default_rng(0))
    without = Nuisance(k=nuisance.k, c=nuisance.c)
    asked = program("steps")
    pairs = zip(plant.watch(asked, (), nuisance), plant.watch(asked, (), without), strict=True)
    gap = np.concatenate([(a - b)[:, 1:].reshape(-1, 3) for a, b in pairs])
    assert np.sqrt(np.mean(np.sum(gap**2, axis=1))) < noise_floor(nuisance.noise) / 2


def test_drawn_nuisances_keep_to_their_ranges():
    drawn = [Nuisance.draw(np.random.default_rng(seed)) for seed in range(200)]
    assert all(abs(n.k - 1) <= 0.15 and abs(n.c - 1) <= 0.3 and 3e-4 <= n.noise <= 5e-4 for n in drawn)
    assert max(abs(n.k - 1) for n in drawn) > 0.14


def test_strength_is_found_for_a_gap(plant):
    from hsr_pin.blind.plants.laws.actuation import TorqueBias
    from hsr_pin.blind.plants.laws.elastic import StiffnessGradient
    from hsr_pin.blind.plants.scaling import GapSimulator, scale_to_gap

    gap_simulator = GapSimulator(short("steps+chirp"), plant=plant)
    found = scale_to_gap(TorqueBias(0.01), 2.0, gap_simulator)
    assert found.reached
    assert gap_simulator.gap(found.law) == pytest.approx(2.0, rel=0.05)
    assert gap_simulator.refitted_gap(found.law) <= gap_simulator.gap(found.law)
    capped = scale_to_gap(StiffnessGradient(0.1), 200.0, gap_simulator)
    assert not capped.reached
    assert capped.law.slope == StiffnessGradient.limit


def test_plants_import_nothing_of_the_model_and_no_engine():
    for path in PLANTS.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and node.level == 0:
                names = [node.module or ""]
            for name in names:
                assert not name.startswith("hsr_pin") or name in ("hsr_pin.errors",) or name.startswith("hsr_pin.blind"), (
                    path,
                    name,
                )
    code = "import sys, hsr_pin.blind.plants.rod, hsr_pin.blind.plants.scaling; "
    code += "assert not {'mujoco', 'elastica', 'pinocchio'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)

"""Builder of cases from recordings of hardware, according to a recipe."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.cases import Case
from hsr_pin.blind.plants.laws import CATALOGUE
from hsr_pin.blind.real.edits import measured_torque
from hsr_pin.blind.real.recipes import OTHER_KINDS, RECIPES, START_DELAY, Recipe
from hsr_pin.errors import InputError
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset
from hsr_pin.trajectory import Dataset, Trial


def plan_real(seed: int, recordings: Path) -> tuple[Case, ...]:
    """Return one case for each recipe.

    Raises:
        InputError: the folder lacks a recording that a recipe needs.
    """
    for name in dict.fromkeys(recipe.recording for recipe in RECIPES.values()):
        if not (recordings / name / "dataset.toml").is_file():
            raise InputError("--real", expected=f"a folder with {name}/dataset.toml", received=recordings)
    rng = np.random.default_rng([seed, 30])
    return tuple(
        Case("", "real", (name,), (), "", "", recipe.recording, "", int(rng.integers(1 << 31)), "real")
        for name, recipe in RECIPES.items()
    )


def build_real(case: Case, folder: Path, recordings: Path | None) -> Answer:
    """Write an edited copy of a recording, which does not reveal its source, and return the answer.

    Raises:
        InputError: the folder of the recordings is not given.
    """
    if recordings is None:
        raise InputError("real cases", expected="the folder of the recordings", hint="give --real DIR")
    recipe = RECIPES[case.effects[0]]
    amount = drawn_amount(recipe, case.seed)
    clean = reference(recipe, recordings)
    write_dataset(_anonymous(recipe.edit(clean, amount), folder.name), folder)
    facts = {
        "recipe": case.effects[0],
        "recording": recipe.recording,
        "mount": clean.mount,
        "program": recipe.recording,
        "trials": list(recipe.trials),
        "amount": amount,
        "own": list(OTHER_KINDS[recipe.recording]),
        "seed": case.seed,
    }
    effects = tuple(name for name in recipe.truth.names[:1] if name in CATALOGUE)
    return Answer(case.name, case.kind, effects, "", facts, case.tier, (recipe.truth.names,), (recipe.truth.kinds,))


def reference(recipe: Recipe, recordings: Path) -> Dataset:
    """Return the recording of a recipe before the edit, with the input that is closest to the truth."""
    dataset = read_dataset(recordings / recipe.recording)
    if recipe.measured:
        dataset = measured_torque(dataset)
    trials = [dataset.trials[number - 1] for number in recipe.trials]
    return replace(dataset, trials=tuple(_start_delayed(trial, START_DELAY.get(recipe.recording, 0.0)) for trial in trials))


def drawn_amount(recipe: Recipe, seed: int) -> float:
    """Return the drawn amount of the edit."""
    rng = np.random.default_rng([seed, 0])
    side = float(rng.choice([-1.0, 1.0])) if recipe.either_way else 1.0
    return side * recipe.amount * float(rng.uniform(0.9, 1.2))


def _start_delayed(trial: Trial, by: float) -> Trial:
    return trial if trial.t_start is None or not by else replace(trial, t_start=round(trial.t_start + by, 3))


def _anonymous(dataset: Dataset, name: str) -> Dataset:
    trials = tuple(
        replace(trial, name=f"trial_{k:02d}", trajectory=replace(trial.trajectory, notes=()))
        for k, trial in enumerate(dataset.trials, start=1)
    )
    return replace(dataset, name=name, description="", trials=trials, path=None, notes=())

"""Cases of plants by other authors, planned like those of the clean tier and recorded by each plant with its own functions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.cases import PAIR_SIZES, Case, Content, balanced, contents_of, quotas
from hsr_pin.blind.kinds import names_of
from hsr_pin.blind.plants.others import NAMES, plant
from hsr_pin.blind.plants.scaling import SIZES
from hsr_pin.blind.workshop import DRAWS
from hsr_pin.errors import SimulationFailure

#: Kind of case -> its share of the cases of a plant.
SHARES: dict[str, float] = {"single": 0.56, "pair": 0.12, "none": 0.14, "outside": 0.18}
#: In one of so many cases the tracks are smoothed, as in exports of motion capture software.
SMOOTHED = 4


def plan_others(rng: np.random.Generator, count: int) -> list[Case]:
    """Return a number of cases, equally many for each plant."""
    cases: list[Case] = []
    for name, share in zip(NAMES, quotas(count, dict.fromkeys(NAMES, 1 / len(NAMES))).values(), strict=True):
        for content, smooth in zip(_contents(rng, name, share), balanced(rng, range(SMOOTHED), share), strict=True):
            program = "smoothed" if smooth == 0 else "as seen"
            cases.append(Case("", *content, name, "", program, "tau", int(rng.integers(1 << 31)), "others"))
    return cases


def _contents(rng: np.random.Generator, name: str, count: int) -> list[Content]:
    number, own = quotas(count, SHARES), plant(name)
    found = contents_of(rng, number, {"none": (), "single": own.CATALOGUE, "outside": own.OUTSIDE})
    for _ in range(number["pair"]):
        laws = rng.choice(list(own.CATALOGUE), 2, replace=False)
        found.append(("pair", tuple(map(str, laws)), tuple(str(rng.choice(PAIR_SIZES)) for _ in laws)))
    return found


def build_other(case: Case, folder: Path, attempt: int) -> Answer:
    """Write the recording of a case into a new folder, and return its answer.

    If a law cannot reach its size, later attempts ask for a smaller size; the last but one attempt uses one law only, and the
    last attempt none.

    Raises:
        SimulationFailure: a law cannot reach its size, or the arm collapses.
    """
    own, steps = plant(case.plant), list(SIZES)
    count = {DRAWS - 2: 1, DRAWS - 1: 0}.get(attempt, len(case.effects))
    sizes = tuple(steps[max(0, steps.index(size) - max(0, attempt - 1))] for size in case.sizes[:count])
    laws = list(zip(case.effects[:count], sizes, strict=True))
    try:
        truth: dict[str, Any] = own.record(folder, case.seed + attempt, laws, smooth=case.program == "smoothed")
    except ValueError as error:
        raise SimulationFailure(f"{case.name}: {error}", None) from error
    effects = tuple(name for name, _ in laws)
    kinds = own.CATALOGUE | own.OUTSIDE
    size = sizes[0] if len(sizes) == 1 else ""
    facts = {"plant": case.plant, "program": case.program, "seed": case.seed, "sizes": list(sizes), "truth": truth}
    return Answer(
        case.name,
        case.kind if len(effects) == len(case.effects) else "single" if effects else "none",
        effects,
        size,
        facts,
        case.tier,
        tuple(map(names_of, effects)),
        tuple(tuple(kinds[effect]) for effect in effects),
    )

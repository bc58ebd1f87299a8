"""Cases of arms in space, recorded on the chain of ball joints or on the rod, and planned like those of the clean tier."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.cases import MOUNTS, Case, balanced, contents_of, quotas
from hsr_pin.blind.plants.laws.law import Law
from hsr_pin.blind.plants.plant import nuisance_of
from hsr_pin.blind.plants.program import LEVELS
from hsr_pin.blind.plants.scaling import GapSimulator, target
from hsr_pin.blind.plants.space.laws import CATALOGUE, OUTSIDE
from hsr_pin.blind.plants.space.program import program
from hsr_pin.blind.plants.space.writing import MARKERS
from hsr_pin.blind.workshop import Workshop, answer_of, scaled_to_size
from hsr_pin.errors import EffectError

#: Kind of case -> its share of the tier.
SHARES: dict[str, float] = {"single": 0.7, "none": 0.13, "outside": 0.17}
#: Programs: combinations of kinds of trials.
PROGRAMS = ("steps", "steps+releases", "steps+circle", "circle+releases", "steps+payload", "chirp+releases")
#: One of so many cases is recorded on the rod, which takes longer, with short programs only; it supports every law.
ROD_EVERY, ROD_PROGRAMS = 6, ("steps", "steps+releases", "steps+payload")


def plan_in_space(rng: np.random.Generator, count: int) -> list[Case]:
    """Return a number of balanced cases."""
    contents = contents_of(rng, quotas(count, SHARES), {"none": (), "single": CATALOGUE, "outside": OUTSIDE})
    recordings = zip(*(balanced(rng, choices, count) for choices in (PROGRAMS, MOUNTS)), strict=True)
    rods, cases = rng.integers(ROD_EVERY), []
    for k, (content, (done, mount)) in enumerate(zip(contents, recordings, strict=True)):
        rod = k % ROD_EVERY == rods
        if rod and done not in ROD_PROGRAMS:
            done = ROD_PROGRAMS[k // ROD_EVERY % len(ROD_PROGRAMS)]
        plant = "space_rod" if rod else "balls"
        cases.append(Case("", *content, plant, mount, done, "tau", int(rng.integers(1 << 31)), "space"))
    return cases


def build_in_space(case: Case, folder: Path, workshop: Workshop, attempt: int) -> Answer:
    """Write the recording of a case into a new folder, and return its answer."""
    nuisance = nuisance_of(case.seed)
    keq = float(np.random.default_rng([case.seed, 7]).choice(sorted(LEVELS)))
    trials = program(case.program, case.mount, keq)
    gap_simulator = GapSimulator(trials, nuisance, workshop.measured_in_space)
    chosen = [
        scaled_to_size(case, place, target(size, nuisance.noise, axes=3), gap_simulator, attempt, draw_law=draw)
        for place, size in enumerate(case.sizes)
    ]
    workshop.plants[case.plant].run(trials, [scaled.law for scaled in chosen], case.seed, folder, nuisance, MARKERS)
    return answer_of(case, chosen, [scaled.gap for scaled in chosen], nuisance, axes=3)


def draw(name: str, rng: np.random.Generator) -> Law:
    """Return a law in space by its name, with random secondary parameters and moderate strength."""
    laws = CATALOGUE | OUTSIDE
    if name not in laws:
        raise EffectError("law", expected=" or ".join(sorted(laws)), received=name)
    return laws[name].draw(rng)

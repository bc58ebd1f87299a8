"""Oracle: reduction of the gap by the true law, whose parameters are fitted like those of any other law."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from itertools import permutations, product
from math import sqrt
from pathlib import Path

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.state import is_intact, read_state
from hsr_pin.errors import InputError, quoted
from hsr_pin.output import write_text
from hsr_pin.parallel import for_each


def consult(
    folder: Path,
    cache: Path,
    answers: Sequence[Answer],
    *,
    jobs: int = 1,
    cluster: str | None = None,
    advance: Callable[[], None] = lambda: None,
) -> None:
    """Write the held-out RMS distance of the true law for each case with effects of the catalogue that has none yet."""
    cache.mkdir(parents=True, exist_ok=True)
    asked = [(answer.name, answer.effects) for answer in answers if answer.kind in ("single", "pair")]
    open_cases = [case for case in asked if not is_intact(cache / f"{case[0]}.json")]
    for _ in range(len(asked) - len(open_cases)):
        advance()
    work = partial(_consult, folder=folder.resolve(), cache=cache.resolve())
    for_each(work, open_cases, jobs=jobs, cluster=cluster, advance=advance)


def read_oracle(cache: Path) -> dict[str, float]:
    """Return the held-out RMS distance of the true law [mm] by the name of the case.

    Raises:
        InputError: a file is damaged.
    """
    hint, found = "hsr-blind score --oracle fits it again once it is deleted", {}
    for path in sorted(cache.glob("case_*.json")):
        rms = read_state(path, hint).get("heldout_rms_mm")
        if not isinstance(rms, (int, float)):
            raise InputError("damaged", expected="heldout_rms_mm", received=quoted(rms), hint=hint, file=path)
        found[path.stem] = float(rms)
    return found


def _consult(case: tuple[str, tuple[str, ...]], folder: Path, cache: Path) -> None:
    name, effects = case
    rms = heldout_rms(folder / name, effects)
    write_text(cache / f"{name}.json", json.dumps({"effects": effects, "heldout_rms_mm": 1e3 * rms}) + "\n")


def heldout_rms(recording: Path, names: Sequence[str]) -> float:
    """Return the smallest held-out RMS distance with these effects [m], over their variants and the orders of adding them."""
    from hsr_pin.effects import effect_named
    from hsr_pin.identification.experiment import prepare
    from hsr_pin.identification.hypothesis import Hypothesis
    from hsr_pin.identification.part import part_variants
    from hsr_pin.inference.candidate import candidate, full_fit
    from hsr_pin.inference.fit import fit
    from hsr_pin.inference.proposals import proposals, quick_fit
    from hsr_pin.recordings.read import read_dataset

    experiment = prepare(read_dataset(recording))
    nothing = candidate(experiment, fit(experiment, Hypothesis()), {})
    found = []
    for order in permutations(names):
        for parts in product(*(part_variants(effect_named(name)) for name in order)):
            last = nothing
            for part in parts:
                for proposal in proposals(experiment, last.fit, [part]):  # at most one; none if it cannot be simulated
                    last = full_fit(experiment, quick_fit(experiment, last.fit, proposal), {})
            found.append(last.heldout_square)
    return sqrt(min(found))

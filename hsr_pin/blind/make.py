"""Recordings without labels, from a plan; whole or not at all, one case after the other."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from math import inf, sqrt
from pathlib import Path

import numpy as np

from hsr_pin.blind.answers import SEAL, Answer, seal
from hsr_pin.blind.cases import PROGRAMS, Case, plan
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws import draw
from hsr_pin.blind.plants.laws.law import Law
from hsr_pin.blind.plants.nuisance import noise_floor
from hsr_pin.blind.plants.plant import Plant, nuisance_of
from hsr_pin.blind.plants.program import program
from hsr_pin.blind.plants.rod import RodPlant
from hsr_pin.blind.plants.scaling import SIZES, Scaled, Yardstick, scale_to_gap, target
from hsr_pin.blind.pool import for_each
from hsr_pin.errors import InputError, SimulationFailure
from hsr_pin.output import check_folder_writable, check_writable, write_text

#: A law that cannot be as strong as it should, or at which the plant diverges, is drawn anew, so many times in all.
DRAWS = 4


@dataclass(frozen=True)
class Workshop:
    """What cases are made with: quicker ones for tests."""

    plants: Mapping[str, Plant] = field(  # the chain within 0.02 mm RMS of one twice as fine
        default_factory=lambda: {"chain": ChainPlant(elements=24, step=2e-4), "rod": RodPlant()}
    )
    measured_on: Plant = field(default_factory=lambda: ChainPlant(elements=8, step=1e-3))  # gaps within 2 % of fine ones
    programs: tuple[str, ...] = PROGRAMS


def default_answers(folder: Path) -> Path:
    """Beside the folder, not in it."""
    return folder.with_name(f"{folder.name}-answers.json")


def make(
    folder: Path,
    seed: int,
    count: int,
    answers: Path | None = None,
    *,
    jobs: int = 1,
    workshop: Workshop | None = None,
    advance: Callable[[], None] = lambda: None,
) -> Path:
    """Make the recordings of a check, or go on where it was left, and return the file of its answers.

    Until all are made, what is known of the answers stands in a folder beside that file.

    Raises:
        InputError: the folder holds another check, or the answers would lie in it.
    """
    workshop, folder = workshop or Workshop(), folder.resolve()
    file = (answers or default_answers(folder)).resolve()
    if folder in file.parents:
        raise InputError("answers", expected=f"a file outside of {folder.name}", received=file)
    if (folder / SEAL).exists():
        raise InputError("folder", expected="one without a finished check", received=folder)
    check_folder_writable(folder)
    check_writable(file)
    drafts = file.with_name(f"{file.name}.draft")
    cases = plan(seed, count, workshop.programs)
    _begin(folder, drafts, cases)
    open_cases = [case for case in cases if not (folder / case.name).exists()]
    for _ in range(count - len(open_cases)):
        advance()
    for_each(partial(make_case, folder=folder, drafts=drafts, workshop=workshop), open_cases, jobs, advance)
    seal(folder, file, seed, [Answer.of(json.loads(_draft(drafts, case).read_text(encoding="utf-8"))) for case in cases])
    shutil.rmtree(drafts)
    return file


def _begin(folder: Path, drafts: Path, cases: Sequence[Case]) -> None:
    """Folders for the recordings and for drafts, which remember what they are drafts of."""
    note, wanted = drafts / "plan.json", json.dumps([asdict(case) for case in cases], indent=1)
    if note.exists():
        if note.read_text(encoding="utf-8") != wanted:
            hint = "give the seed and number of cases it was begun with, and the same version"
            raise InputError("folder", expected="the check begun in it", hint=hint, file=folder)
    elif folder.exists() and any(folder.iterdir()):
        raise InputError("folder", expected="a new or empty folder", received=folder)
    folder.mkdir(parents=True, exist_ok=True)
    drafts.mkdir(parents=True, exist_ok=True)
    write_text(note, wanted)


def make_case(case: Case, folder: Path, drafts: Path, workshop: Workshop) -> None:
    """Record one case: its answer among the drafts first, then the whole recording into the folder."""
    for attempt in range(DRAWS):
        try:
            answer = _record(case, drafts, workshop, _strong_enough(case, workshop, attempt))
            break
        except SimulationFailure:
            if attempt == DRAWS - 1:
                raise
    write_text(_draft(drafts, case), json.dumps(answer.document(), indent=1, allow_nan=False))
    os.replace(drafts / case.name, folder / case.name)


def _draft(drafts: Path, case: Case) -> Path:
    return drafts / f"{case.name}.json"


def _strong_enough(case: Case, workshop: Workshop, first: int) -> list[Scaled]:
    """Each effect of a case at its size, or as near to it as a few draws get."""
    nuisance = nuisance_of(case.seed)
    yardstick = Yardstick(program(case.program, case.mount, case.given), nuisance, workshop.measured_on)
    chosen = []
    for place, (effect, size) in enumerate(zip(case.effects, case.sizes, strict=True)):
        wanted, best = target(size, nuisance.noise), None
        for attempt in range(first, DRAWS):
            law = draw(effect, np.random.default_rng([case.seed, 3, place, attempt]))
            try:
                scaled = scale_to_gap(law, wanted, yardstick, refit=True)
            except SimulationFailure:
                continue
            if best is None or abs(scaled.gap - wanted) < abs(best.gap - wanted):
                best = scaled
            if best.reached:
                break
        if best is None:
            raise SimulationFailure(f"{effect} cannot be simulated in {case.name}", None)
        chosen.append(best)
    return chosen


def _record(case: Case, drafts: Path, workshop: Workshop, chosen: Sequence[Scaled]) -> Answer:
    """Write the recordings of a case among the drafts."""
    nuisance = nuisance_of(case.seed)
    trials = program(case.program, case.mount, case.given)
    laws: list[Law] = [scaled.law for scaled in chosen]
    shutil.rmtree(drafts / case.name, ignore_errors=True)
    workshop.plants[case.plant].run(trials, laws, case.seed, drafts / case.name, nuisance)
    floor = 1e3 * noise_floor(nuisance.noise)
    gaps = [scaled.gap for scaled in chosen]
    if len(laws) > 1:
        gaps.append(Yardstick(trials, nuisance, workshop.measured_on).refitted_gap(*laws))
    about = {key: value for key, value in asdict(case).items() if key not in ("name", "kind", "effects")}
    facts = {
        **about,
        "laws": [law.describe() for law in laws],
        "reached": [scaled.reached for scaled in chosen],
        "gaps_mm": gaps,  # beyond the best K and C: of each law, and of a pair together
        "gaps_in_noise_floors": [gap / floor for gap in gaps],
        "nuisance": nuisance.describe(),
    }
    size = size_of(gaps[0] / floor) if len(laws) == 1 else ""
    return Answer(case.name, case.kind, case.effects, size, facts)


def size_of(floors: float) -> str:
    """The named size that is nearest to a gap in noise floors; ``below`` if that is nearer to half of the smallest."""
    steps = {"below": min(SIZES.values()) / 2, **SIZES}
    names, values = list(steps), [*steps.values(), inf]
    for name, value, bigger in zip(names, values, values[1:], strict=False):
        if floors < sqrt(value * bigger):
            return name
    return names[-1]

"""Where a case is made: from its plan to a folder with its recording, and its answer. Nothing but the case decides what comes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from math import inf, sqrt
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.background import Background, background
from hsr_pin.blind.cases import PROGRAMS, Case
from hsr_pin.blind.kinds import kinds_of, names_of
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws import draw
from hsr_pin.blind.plants.laws.law import Law
from hsr_pin.blind.plants.mess import QUIETEST, Mess, messy_nuisance
from hsr_pin.blind.plants.nuisance import Nuisance, noise_floor
from hsr_pin.blind.plants.plant import Plant, nuisance_of
from hsr_pin.blind.plants.program import Program, program
from hsr_pin.blind.plants.rod import RodPlant
from hsr_pin.blind.plants.scaling import SIZES, Scaled, Yardstick, scale_to_gap, target
from hsr_pin.blind.plants.space.chain import BallPlant
from hsr_pin.blind.plants.space.rod import SpaceRodPlant
from hsr_pin.errors import SimulationFailure

#: A law that cannot be as strong as it should, or at which the plant diverges, is drawn anew, so many times in all.
DRAWS = 5
#: Largest gap of a messy arm [mm], a twentieth of its length: beyond it a law would have to be stronger than on any arm.
BELIEVABLE = 12.0


@dataclass(frozen=True)
class Workshop:
    """What cases are made with: quicker plants for tests.

    Attributes:
        plants: "chain" and "rod", in space "balls" and "space_rod". messy: for messy arms, where 0.05 mm do not count.
        measured_on, measured_in_space: what gaps are measured on. programs: that are recorded.
        recordings: folder of the recordings of hardware, where real cases are made.
    """

    plants: Mapping[str, Plant] = field(  # the chain within 0.02 mm RMS of one twice as fine
        default_factory=lambda: {
            "chain": ChainPlant(elements=24, step=2e-4),
            "rod": RodPlant(),
            "balls": BallPlant(elements=20, step=4e-4),
            "space_rod": SpaceRodPlant(),
        }
    )
    messy: Plant = field(default_factory=lambda: ChainPlant(elements=16, step=4e-4))
    measured_on: Plant = field(default_factory=lambda: ChainPlant(elements=8, step=1e-3))  # gaps within 2 % of fine ones
    measured_in_space: Plant = field(default_factory=lambda: BallPlant(elements=8, step=1e-3))
    programs: tuple[str, ...] = PROGRAMS
    recordings: Path | None = None


def build(case: Case, folder: Path, workshop: Workshop, attempt: int = 0) -> Answer:
    """Write the recording of a case into a new folder; a later attempt draws its laws anew."""
    if case.tier == "real":
        from hsr_pin.blind.real.build import build_real

        return build_real(case, folder, workshop.recordings)
    if case.tier == "change":
        from hsr_pin.blind.pairs import build_pair

        return build_pair(case, folder, workshop, attempt)
    if case.tier == "space":
        from hsr_pin.blind.in_space import build_in_space

        return build_in_space(case, folder, workshop, attempt)
    if case.tier == "others":
        from hsr_pin.blind.others import build_other

        return build_other(case, folder, attempt)
    return (_build_messy if case.tier == "messy" else _build_clean)(case, folder, workshop, attempt)


def _build_clean(case: Case, folder: Path, workshop: Workshop, attempt: int) -> Answer:
    nuisance = nuisance_of(case.seed)
    trials = program(case.program, case.mount, case.given)
    yardstick = Yardstick(trials, nuisance, workshop.measured_on)
    chosen = [
        strong_enough(case, place, target(size, nuisance.noise), yardstick, attempt) for place, size in enumerate(case.sizes)
    ]
    laws = [scaled.law for scaled in chosen]
    workshop.plants[case.plant].run(trials, laws, case.seed, folder, nuisance)
    gaps = [scaled.gap for scaled in chosen]
    if len(laws) > 1:
        gaps.append(yardstick.refitted_gap(*laws))
    return answer_of(case, chosen, gaps, nuisance)


def _build_messy(case: Case, folder: Path, workshop: Workshop, attempt: int) -> Answer:
    arm = MessyArm.of(case, workshop, attempt)
    small = arm.background(case.effects)
    laws = [*(scaled.law for scaled in arm.main), *small.laws]
    workshop.messy.run(arm.program, laws, case.seed, folder, arm.nuisance, mess=arm.mess)
    return answer_of(case, arm.main, [scaled.gap for scaled in arm.main], arm.nuisance, small, arm.mess)


@dataclass(frozen=True)
class MessyArm:
    """A messy arm before its small effects are drawn.

    Attributes:
        case, workshop: it is made from. attempt: at it.
        mess, nuisance, program: how it is recorded. main: its main effect, if it has one.
    """

    case: Case
    workshop: Workshop
    attempt: int
    mess: Mess
    nuisance: Nuisance
    program: Program
    main: tuple[Scaled, ...] = ()

    @classmethod
    def of(cls, case: Case, workshop: Workshop, attempt: int) -> MessyArm:
        """As its case says, quieter if its main effect could not be seen otherwise."""
        rng = np.random.default_rng([case.seed, 5])
        mess, nuisance = Mess.draw(rng), messy_nuisance(rng)
        arm = cls(case, workshop, attempt, mess, nuisance, mess.staged(program(case.program, case.mount, case.given)))
        if not case.sizes:
            return arm
        main = strong_enough(case, 0, arm.wanted(case.sizes[0]), arm.yardstick(), attempt)
        return replace(arm, main=(main,), nuisance=quieter(nuisance, main.gap))

    @property
    def floor(self) -> float:
        """Noise floor [mm]."""
        return 1e3 * noise_floor(self.nuisance.noise)

    def wanted(self, size: str) -> float:
        """Gap [mm] of an effect of this size."""
        return min(target(size, self.nuisance.noise), BELIEVABLE)

    def yardstick(self, already: Sequence[Law] = ()) -> Yardstick:
        """Measures on this arm, as it is with the laws that it has already."""
        return Yardstick(self.program, self.nuisance, self.workshop.measured_on, tuple(already))

    def background(self, without: Sequence[str]) -> Background:
        """Its small effects, none of them of these names."""
        rng = np.random.default_rng([self.case.seed, 6, self.attempt])
        return background(rng, [name.partition(":")[0] for name in without], self.yardstick(), self.floor)


def quieter(nuisance: Nuisance, gap: float) -> Nuisance:
    """With so little noise that a gap [mm] is of medium size, if it is nearer to a barely visible one as it is."""
    if gap > 1e3 * noise_floor(nuisance.noise) * sqrt(SIZES["barely"] * SIZES["medium"]):
        return nuisance
    return replace(nuisance, noise=max(QUIETEST, 1e-3 * gap / noise_floor(1.0) / SIZES["medium"]))


def strong_enough(
    case: Case,
    place: int,
    wanted: float,
    yardstick: Yardstick,
    first: int,
    refit: bool = True,
    drawn: Callable[[str, np.random.Generator], Law] = draw,
) -> Scaled:
    """The effect in this place of a case with a gap [mm] that is wanted, or as near to it as a few draws get."""
    best = None
    for attempt in range(first, DRAWS):
        law = drawn(case.effects[place], np.random.default_rng([case.seed, 3, place, attempt]))
        try:
            scaled = scale_to_gap(law, wanted, yardstick, refit)
        except SimulationFailure:
            continue
        if best is None or abs(scaled.gap - wanted) < abs(best.gap - wanted):
            best = scaled
        if best.reached:
            break
    if best is None:
        raise SimulationFailure(f"{case.effects[place]} cannot be simulated in {case.name}", None)
    return best


def answer_of(
    case: Case,
    chosen: Sequence[Scaled],
    gaps: Sequence[float],
    nuisance: Nuisance,
    small: Background | None = None,
    mess: Mess | None = None,
    *,
    axes: int = 2,
) -> Answer:
    """What is in a case: gaps [mm] of each effect, and of a pair together."""
    floor = 1e3 * noise_floor(nuisance.noise, axes)
    about = {key: value for key, value in asdict(case).items() if key not in ("name", "tier", "kind", "effects")}
    facts: dict[str, Any] = {
        **about,
        "laws": [scaled.law.describe() for scaled in chosen],
        "reached": [scaled.reached for scaled in chosen],
        "gaps_mm": list(gaps),  # beyond the best K and C
        "gaps_in_noise_floors": [gap / floor for gap in gaps],
        "nuisance": nuisance.describe(),
    }
    if small is not None:
        facts["small"] = [{**law.describe(), "noise_floors": alone} for law, alone in zip(small.laws, small.alone, strict=True)]
        facts["small_together"] = small.together  # in noise floors, beyond the best K and C
    if mess is not None:
        facts["mess"] = mess.describe()
    return Answer(
        case.name,
        case.kind,
        tuple(effect.partition(":")[0] for effect in case.effects),
        size_of(gaps[0] / floor) if len(chosen) == 1 else "",
        facts,
        case.tier,
        tuple(map(names_of, case.effects)),
        tuple(map(kinds_of, case.effects)),
        () if small is None else small.noticeable,
    )


def size_of(floors: float) -> str:
    """The named size that is nearest to a gap in noise floors; ``below`` if that is nearer to half of the smallest."""
    steps = {"below": min(SIZES.values()) / 2, **SIZES}
    names, values = list(steps), [*steps.values(), inf]
    for name, value, bigger in zip(names, values, values[1:], strict=False):
        if floors < sqrt(value * bigger):
            return name
    return names[-1]

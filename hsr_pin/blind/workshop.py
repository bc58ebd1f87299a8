"""Case builder: from the plan of a case to a folder with its recording and to its answer, without any other random input."""

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
from hsr_pin.blind.plants.artefacts import MIN_NOISE, Artefacts, messy_nuisance
from hsr_pin.blind.plants.chain import ChainPlant
from hsr_pin.blind.plants.laws import draw
from hsr_pin.blind.plants.laws.law import Law
from hsr_pin.blind.plants.nuisance import Nuisance, noise_floor
from hsr_pin.blind.plants.plant import Plant, nuisance_of
from hsr_pin.blind.plants.program import Program, program
from hsr_pin.blind.plants.rod import RodPlant
from hsr_pin.blind.plants.scaling import SIZES, GapSimulator, Scaled, scale_to_gap, target
from hsr_pin.blind.plants.space.chain import BallPlant
from hsr_pin.blind.plants.space.rod import SpaceRodPlant
from hsr_pin.errors import SimulationFailure

#: Maximum number of draws of a law that cannot reach its size, or with which the plant diverges.
DRAWS = 5
#: Largest gap of a messy arm [mm], a twentieth of its length: a larger gap would need an implausibly strong law.
LARGEST_GAP = 12.0


@dataclass(frozen=True)
class Workshop:
    """Plants and settings of the case builder; tests replace them by quicker ones.

    Attributes:
        plants: plants "chain" and "rod", in space "balls" and "space_rod".
        messy: plant for messy arms, for which errors of 0.05 mm do not matter.
        measured_on: plant on which marker gaps are simulated.
        measured_in_space: plant on which marker gaps in space are simulated.
        programs: programs that are recorded.
        recordings: folder with recordings of hardware, needed for real cases.
    """

    plants: Mapping[str, Plant] = field(  # the chain differs by 0.02 mm RMS from one with twice as many elements
        default_factory=lambda: {
            "chain": ChainPlant(elements=24, step=2e-4),
            "rod": RodPlant(),
            "balls": BallPlant(elements=20, step=4e-4),
            "space_rod": SpaceRodPlant(),
        }
    )
    messy: Plant = field(default_factory=lambda: ChainPlant(elements=16, step=4e-4))
    measured_on: Plant = field(default_factory=lambda: ChainPlant(elements=8, step=1e-3))  # gaps within 2 % of fine chains
    measured_in_space: Plant = field(default_factory=lambda: BallPlant(elements=8, step=1e-3))
    programs: tuple[str, ...] = PROGRAMS
    recordings: Path | None = None


def build(case: Case, folder: Path, workshop: Workshop, attempt: int = 0) -> Answer:
    """Write the recording of a case into a new folder, and return its answer; a later attempt draws its laws again."""
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
    gap_simulator = GapSimulator(trials, nuisance, workshop.measured_on)
    chosen = [
        scaled_to_size(case, place, target(size, nuisance.noise), gap_simulator, attempt) for place, size in enumerate(case.sizes)
    ]
    laws = [scaled.law for scaled in chosen]
    workshop.plants[case.plant].run(trials, laws, case.seed, folder, nuisance)
    gaps = [scaled.gap for scaled in chosen]
    if len(laws) > 1:
        gaps.append(gap_simulator.refitted_gap(*laws))
    return answer_of(case, chosen, gaps, nuisance)


def _build_messy(case: Case, folder: Path, workshop: Workshop, attempt: int) -> Answer:
    arm = MessyArm.of(case, workshop, attempt)
    small = arm.background(case.effects)
    laws = [*(scaled.law for scaled in arm.main), *small.laws]
    workshop.messy.run(arm.program, laws, case.seed, folder, arm.nuisance, artefacts=arm.artefacts)
    return answer_of(case, arm.main, [scaled.gap for scaled in arm.main], arm.nuisance, small, arm.artefacts)


@dataclass(frozen=True)
class MessyArm:
    """A messy arm before its small effects are drawn.

    Attributes:
        case: plan of the case.
        workshop: plants and settings.
        attempt: number of the attempt.
        artefacts: recording artefacts.
        nuisance: errors of parameters, noise and tiny effects.
        program: trials that are recorded.
        main: main effect, if there is one.
    """

    case: Case
    workshop: Workshop
    attempt: int
    artefacts: Artefacts
    nuisance: Nuisance
    program: Program
    main: tuple[Scaled, ...] = ()

    @classmethod
    def of(cls, case: Case, workshop: Workshop, attempt: int) -> MessyArm:
        """Return the arm of a case, with less noise if its main effect could not be seen otherwise."""
        rng = np.random.default_rng([case.seed, 5])
        artefacts, nuisance = Artefacts.draw(rng), messy_nuisance(rng)
        arm = cls(
            case,
            workshop,
            attempt,
            artefacts,
            nuisance,
            artefacts.with_release_errors(program(case.program, case.mount, case.given)),
        )
        if not case.sizes:
            return arm
        main = scaled_to_size(case, 0, arm.wanted(case.sizes[0]), arm.gap_simulator(), attempt)
        return replace(arm, main=(main,), nuisance=quieter(nuisance, main.gap))

    @property
    def floor(self) -> float:
        """Noise floor [mm]."""
        return 1e3 * noise_floor(self.nuisance.noise)

    def wanted(self, size: str) -> float:
        """Return the marker gap of an effect of this size [mm]."""
        return min(target(size, self.nuisance.noise), LARGEST_GAP)

    def gap_simulator(self, present_laws: Sequence[Law] = ()) -> GapSimulator:
        """Return the simulator of marker gaps of this arm, with the laws that are present."""
        return GapSimulator(self.program, self.nuisance, self.workshop.measured_on, tuple(present_laws))

    def background(self, without: Sequence[str]) -> Background:
        """Return the small effects of the arm, without effects of these names."""
        rng = np.random.default_rng([self.case.seed, 6, self.attempt])
        return background(rng, [name.partition(":")[0] for name in without], self.gap_simulator(), self.floor)


def quieter(nuisance: Nuisance, gap: float) -> Nuisance:
    """Return the nuisances with less noise, such that a small gap [mm] is of medium size; unchanged for a larger gap."""
    if gap > 1e3 * noise_floor(nuisance.noise) * sqrt(SIZES["barely"] * SIZES["medium"]):
        return nuisance
    return replace(nuisance, noise=max(MIN_NOISE, 1e-3 * gap / noise_floor(1.0) / SIZES["medium"]))


def scaled_to_size(
    case: Case,
    place: int,
    wanted: float,
    gap_simulator: GapSimulator,
    first: int,
    refit: bool = True,
    draw_law: Callable[[str, np.random.Generator], Law] = draw,
) -> Scaled:
    """Return the effect at this place of a case with the wanted gap [mm], or the closest one of a few draws."""
    best = None
    for attempt in range(first, DRAWS):
        law = draw_law(case.effects[place], np.random.default_rng([case.seed, 3, place, attempt]))
        try:
            scaled = scale_to_gap(law, wanted, gap_simulator, refit)
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
    artefacts: Artefacts | None = None,
    *,
    axes: int = 2,
) -> Answer:
    """Return the answer of a case, with the gaps [mm] of each effect and of a pair together."""
    floor = 1e3 * noise_floor(nuisance.noise, axes)
    details = {key: value for key, value in asdict(case).items() if key not in ("name", "tier", "kind", "effects")}
    facts: dict[str, Any] = {
        **details,
        "laws": [scaled.law.describe() for scaled in chosen],
        "reached": [scaled.reached for scaled in chosen],
        "gaps_mm": list(gaps),  # after refitting stiffness and damping
        "gaps_in_noise_floors": [gap / floor for gap in gaps],
        "nuisance": nuisance.describe(),
    }
    if small is not None:
        facts["small"] = [{**law.describe(), "noise_floors": alone} for law, alone in zip(small.laws, small.alone, strict=True)]
        facts["small_together"] = small.together  # in noise floors, after refitting stiffness and damping
    if artefacts is not None:
        facts["mess"] = artefacts.describe()
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
    """Return the named size nearest to a gap in noise floors; ``below`` if it is nearer to half of the smallest size."""
    steps = {"below": min(SIZES.values()) / 2, **SIZES}
    names, values = list(steps), [*steps.values(), inf]
    for name, value, bigger in zip(names, values, values[1:], strict=False):
        if floors < sqrt(value * bigger):
            return name
    return names[-1]

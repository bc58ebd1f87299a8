"""Tiers of a check, each with its own kind of cases.

- ``clean``: an arm with one or two effects, none, or one outside the catalogue; tiny nuisances
- ``messy``: the same with at most one main effect, four to eight small effects, and recording artefacts
- ``forms``: a law in another form than the catalogue's, as clean as the first tier
- ``space``: arms that bend about two axes, with one effect, none, or one outside the catalogue
- ``others``: plants by other authors, clean, with one or two effects, none, or one outside (`hsr_pin.blind.others`)
- ``real``: recordings of hardware with a withheld cause (`hsr_pin.blind.real`)
- ``change``: two recordings of one messy arm, with or without a change between them
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hsr_pin.blind.cases import INPUTS, MOUNTS, PAIR_SIZES, PROGRAMS, Case, Content, balanced, contents_of, plan_clean, quotas
from hsr_pin.blind.plants.laws import CATALOGUE, FORMS, OUTSIDE, PARAMETERS
from hsr_pin.errors import InputError

#: Simulated tiers -> share of a check; the last two are recorded on request only.
TIERS: dict[str, float] = {"clean": 0.27, "messy": 0.53, "forms": 0.20, "space": 0.0, "others": 0.0}
#: Kind of case -> share of its tier.
MESSY_SHARES: dict[str, float] = {"single": 0.625, "none": 0.2, "outside": 0.175}
CHANGE_SHARES: dict[str, float] = {"appears": 0.35, "grows": 0.2, "parameter": 0.2, "nothing": 0.25}
#: Share of pairs whose two recordings have different programs.
DIFFERENT_PROGRAMS = 0.4


def plan(seed: int, counts: Mapping[str, int], programs: Sequence[str] = PROGRAMS) -> tuple[Case, ...]:
    """Return the simulated cases of a check, tier by tier.

    Args:
        seed: seed of the whole plan.
        counts: number of cases of each tier.
        programs: programs that may be recorded.
    """
    if unknown := set(counts) - set(TIERS):
        raise InputError("tier", expected=" or ".join(TIERS), received=min(unknown))
    cases: list[Case] = []
    for place, tier in enumerate(TIERS):
        count = counts.get(tier, 0)
        if count < 0:
            raise InputError(f"cases of {tier}", expected="zero or more", received=count)
        if count and tier == "clean":
            cases += plan_clean(seed, count, programs)
        elif count and tier == "space":
            from hsr_pin.blind.in_space import plan_in_space

            cases += plan_in_space(np.random.default_rng([seed, place]), count)
        elif count and tier == "others":
            from hsr_pin.blind.others import plan_others

            cases += plan_others(np.random.default_rng([seed, place]), count)
        elif count:
            rng = np.random.default_rng([seed, place])
            cases += _recorded(rng, tier, (_messy if tier == "messy" else _forms)(rng, count), programs)
    return tuple(cases)


def plan_changes(seed: int, count: int, programs: Sequence[str] = PROGRAMS) -> tuple[Case, ...]:
    """Return a plan of pairs of recordings, some of them with different programs."""
    if count < 1:
        raise InputError("pairs", expected="one or more", received=count)
    rng = np.random.default_rng([seed, 10])
    cases = _recorded(rng, "change", _changes(rng, count), programs)
    different = rng.permutation(count) < DIFFERENT_PROGRAMS * count
    return tuple(
        replace(case, later=_other(rng, case.program, programs) if other else case.program)
        for case, other in zip(cases, different, strict=True)
    )


def by_shares(count: int) -> dict[str, int]:
    """Return the number of cases of each tier for a total number of cases."""
    if count < 1:
        raise InputError("cases", expected="one or more", received=count)
    return quotas(count, TIERS)


def shuffled(seed: int, cases: Iterable[Case]) -> tuple[Case, ...]:
    """Return the cases in random order, named by their place in it."""
    found = list(cases)
    order = np.random.default_rng([seed, 20]).permutation(len(found))
    return tuple(replace(found[k], name=f"case_{place:03d}") for place, k in enumerate(order, start=1))


def _recorded(rng: np.random.Generator, tier: str, contents: Sequence[Content], programs: Sequence[str]) -> list[Case]:
    """Return cases recorded on the chain plant, which supports every law."""
    recordings = zip(*(balanced(rng, choices, len(contents)) for choices in (programs, MOUNTS, INPUTS)), strict=True)
    return [
        Case("", *content, "chain", mount, program, given, int(rng.integers(1 << 31)), tier)
        for content, (program, mount, given) in zip(contents, recordings, strict=True)
    ]


def _messy(rng: np.random.Generator, count: int) -> list[Content]:
    number = quotas(count, MESSY_SHARES)
    return contents_of(rng, number, {"none": (), "single": CATALOGUE, "outside": OUTSIDE}, PAIR_SIZES)


def _forms(rng: np.random.Generator, count: int) -> list[Content]:
    return contents_of(rng, {"form": count}, {"form": FORMS}, PAIR_SIZES)


def _changes(rng: np.random.Generator, count: int) -> list[Content]:
    laws = {"nothing": (), "appears": CATALOGUE, "grows": CATALOGUE, "parameter": PARAMETERS}
    return contents_of(rng, quotas(count, CHANGE_SHARES), laws, PAIR_SIZES)


def _other(rng: np.random.Generator, program: str, programs: Sequence[str]) -> str:
    return str(rng.choice([name for name in programs if name != program] or [program]))

"""Plan of a blind check: effects, sizes, plant and program of each case, all derived from one seed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeVar

import numpy as np

from hsr_pin.blind.plants.laws import CATALOGUE, OUTSIDE
from hsr_pin.blind.plants.scaling import SIZES
from hsr_pin.errors import InputError

T = TypeVar("T")
#: Kind of case, its effects, and their sizes.
Content = tuple[str, tuple[str, ...], tuple[str, ...]]

#: Kind of case -> its share of the clean tier; 57 of 100 cases are nineteen effects at three sizes each.
SHARES: dict[str, float] = {"single": 0.57, "pair": 0.15, "none": 0.12, "outside": 0.16}
#: Sizes of effects in pairs, and in all other cases in which barely visible effects could not be diagnosed.
PAIR_SIZES = ("medium", "large")
#: Programs: combinations of kinds of trials.
PROGRAMS = (
    "steps",
    "steps+releases",
    "steps+chirp",
    "steps+payload",
    "steps+staircase",
    "staircase+releases",
    "chirp+releases",
    "steps+chirp+releases",
)
MOUNTS = ("hanging", "upright")
INPUTS = ("pressures", "tau")
#: One of so many cases is recorded on the rod, which takes longer, with short programs and supported laws only.
ROD_EVERY, ROD_PROGRAMS, ROD_UNSUPPORTED = 8, ("steps", "steps+releases"), ("wall",)


@dataclass(frozen=True)
class Case:
    """Plan of one case.

    Attributes:
        name: name of the folder.
        kind: kind of case, a key of the shares of its tier.
        effects: names of laws, or ``name:variant``.
        sizes: names of `SIZES`, one for each effect.
        plant: "chain" or "rod"; in space "balls" or "space_rod".
        mount: mounting of the arm.
        program: trials that are recorded.
        given: recorded input, "pressures" or "tau".
        seed: seed of all random numbers of the case.
        tier: tier to which the case belongs.
        later: program of the second recording, for a pair of recordings.
    """

    name: str
    kind: str
    effects: tuple[str, ...]
    sizes: tuple[str, ...]
    plant: str
    mount: str
    program: str
    given: str
    seed: int
    tier: str = "clean"
    later: str = ""


def plan_clean(seed: int, count: int, programs: Sequence[str] = PROGRAMS) -> tuple[Case, ...]:
    """Return the cases of the clean tier, balanced for any count, in random order."""
    if count < 1:
        raise InputError("cases", expected="one or more", received=count)
    rng = np.random.default_rng(seed)
    contents = _contents(rng, count)
    recordings = zip(*(balanced(rng, choices, count) for choices in (programs, MOUNTS, INPUTS)), strict=True)
    rods = rng.integers(ROD_EVERY)
    cases = []
    for k, ((kind, effects, sizes), (program, mount, given)) in enumerate(zip(contents, recordings, strict=True)):
        rod = k % ROD_EVERY == rods and not set(effects) & set(ROD_UNSUPPORTED)
        if rod and program not in ROD_PROGRAMS:
            program = ROD_PROGRAMS[k // ROD_EVERY % 2] if set(ROD_PROGRAMS) <= set(programs) else programs[0]
        own = int(rng.integers(1 << 31))
        cases.append((kind, effects, sizes, "rod" if rod else "chain", mount, program, given, own))
    order = rng.permutation(count)
    return tuple(Case(f"case_{place:03d}", *cases[k]) for place, k in enumerate(order, start=1))


def _contents(rng: np.random.Generator, count: int) -> list[Content]:
    number = quotas(count, SHARES)
    found = contents_of(rng, number, {"none": (), "single": CATALOGUE, "outside": OUTSIDE})
    pairs = list(combinations(CATALOGUE, 2))
    order = rng.permutation(len(pairs))
    for k in range(number["pair"]):
        first, second = (str(rng.choice(PAIR_SIZES)) for _ in range(2))
        found.append(("pair", pairs[order[k % len(pairs)]], (first, second)))
    return found


def contents_of(
    rng: np.random.Generator, number: Mapping[str, int], laws: Mapping[str, Iterable[str]], among: Sequence[str] = tuple(SIZES)
) -> list[Content]:
    """Return the contents of a ``number`` of cases of each kind: one of its ``laws`` in one size, or nothing if it has none."""
    found: list[Content] = []
    for kind, names in laws.items():
        known = list(names)
        if known:
            found += [(kind, (law,), (size,)) for law, size in crossed(rng, known, number[kind], among)]
        else:
            found += [(kind, (), ())] * number[kind]
    return found


def quotas(count: int, shares: Mapping[str, float]) -> dict[str, int]:
    """Return the number of cases of each kind: shares rounded down, the remainder given to those that lost most."""
    exact = {kind: share * count for kind, share in shares.items()}
    number = {kind: int(share + 1e-9) for kind, share in exact.items()}
    rounded_down = sorted(shares, key=lambda kind: number[kind] - exact[kind])
    for kind in rounded_down[: count - sum(number.values())]:
        number[kind] += 1
    return number


def crossed(
    rng: np.random.Generator, names: Sequence[str], count: int, among: Sequence[str] = tuple(SIZES)
) -> list[tuple[str, str]]:
    """Return pairs of name and size: each round has every name once, and after one round per size each name had every size."""
    order, sizes = rng.permutation(names), rng.permutation(list(among))
    size = len(names)
    return [(str(order[k % size]), str(sizes[(k % size + k // size) % len(sizes)])) for k in range(count)]


def balanced(rng: np.random.Generator, choices: Sequence[T], count: int) -> list[T]:
    """Return choices in random order, each as often as the others."""
    return [choices[k % len(choices)] for k in rng.permutation(count)]

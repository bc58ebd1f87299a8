"""Pairs of recordings of one messy arm, with or without a change between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.cases import Case
from hsr_pin.blind.plants.laws import CATALOGUE, draw
from hsr_pin.blind.plants.laws.law import Law
from hsr_pin.blind.plants.nuisance import Nuisance
from hsr_pin.blind.plants.program import program
from hsr_pin.blind.plants.scaling import Scaled, scale_to_gap
from hsr_pin.blind.workshop import LARGEST_GAP, MessyArm, Workshop, answer_of, quieter, scaled_to_size
from hsr_pin.errors import SimulationFailure

#: Folders of the earlier and the later recording.
REFERENCE, CURRENT = "old", "new"
#: Factor by which an effect grows.
GROWTH = 1.5
#: Share of the arms with a clear effect that is present in both recordings.
PERSISTENT_SHARE = 0.3


@dataclass(frozen=True)
class Change:
    """Change between the two recordings of a pair.

    Attributes:
        before: laws before the change.
        after: laws after the change.
        gap: marker gap of the change [mm].
        reached: whether the gap is the one asked for.
    """

    before: tuple[Law, ...] = ()
    after: tuple[Law, ...] = ()
    gap: float = 0.0
    reached: bool = True


def build_pair(case: Case, folder: Path, workshop: Workshop, attempt: int) -> Answer:
    """Write both recordings of a pair into their own folders, and return the answer."""
    arm = MessyArm.of(replace(case, sizes=()), workshop, attempt)
    arm = replace(
        arm, program=arm.artefacts.with_release_errors(program(case.later, case.mount, case.given))
    )  # gaps are simulated in the second recording's program
    persistent = _persistent(case, arm, attempt)
    change = _change(case, arm, persistent, attempt)
    if change.after:
        arm = replace(arm, nuisance=quieter(arm.nuisance, change.gap))
    small = arm.background([*case.effects, *(law.name for law in persistent)])
    rng = np.random.default_rng([case.seed, 8])
    sessions = [
        (REFERENCE, case.program, arm.artefacts, change.before),
        (CURRENT, case.later, replace(arm.artefacts, seed=int(rng.integers(1 << 31))), change.after),
    ]
    for session, (name, kinds, artefacts, laws) in enumerate(sessions):
        others = [_redrawn(law, rng) if session else law for law in small.laws]
        trials = artefacts.with_release_errors(program(kinds, case.mount, case.given))
        workshop.messy.run(
            trials, (*laws, *persistent, *others), case.seed, folder / name, arm.nuisance, artefacts=artefacts, session=session
        )
    chosen = [Scaled(law, change.gap, change.reached) for law in change.after]
    answer = answer_of(case, chosen, [change.gap] * len(chosen), arm.nuisance, small, arm.artefacts)
    facts = {**answer.facts, "standing": [law.describe() for law in persistent], "change": _change_facts(change, arm.nuisance)}
    return replace(answer, facts=facts, background=())  # effects in both recordings are no change


def _persistent(case: Case, arm: MessyArm, attempt: int) -> tuple[Law, ...]:
    """Return a clear effect that is present in both recordings, or none."""
    rng = np.random.default_rng([case.seed, 7, attempt])
    if case.kind == "grows" or rng.random() > PERSISTENT_SHARE:
        return ()
    name = str(rng.choice([name for name in CATALOGUE if name not in case.effects]))
    return (scale_to_gap(draw(name, rng), arm.wanted("medium"), arm.gap_simulator(), refit=True, tolerance=0.3, steps=6).law,)


def _change(case: Case, arm: MessyArm, persistent: tuple[Law, ...], attempt: int) -> Change:
    if not case.effects:
        return Change()
    wanted, gap_simulator = arm.wanted(case.sizes[0]), arm.gap_simulator(persistent)
    if case.kind != "grows":
        plain = case.kind == "parameter"  # stiffness and damping are not refitted, because they may be what changes
        found = scaled_to_size(case, 0, wanted, gap_simulator, attempt, refit=not plain)
        return Change((), (found.law,), found.gap, found.reached)
    share = GROWTH / (GROWTH - 1)  # a third of an effect that grows by half is the change
    law = scaled_to_size(case, 0, min(share * wanted, 2 * LARGEST_GAP), gap_simulator, attempt).law
    before = law.scaled(1 / GROWTH)
    gap = gap_simulator.refitted_step(before, law)
    if not gap > 0:
        raise SimulationFailure(f"{law.name} does not show in {case.name}", None)
    return Change((before,), (law,), gap, bool(abs(gap / wanted - 1) < 0.5))


def _change_facts(change: Change, nuisance: Nuisance) -> dict[str, Any]:
    """Return the change of the parameter that gives the strength of the law; a plain parameter relative to its declared value."""
    if not change.after:
        return {}
    law = change.after[0]
    size = float(getattr(law, law.strength))
    base = {"keq_scale": nuisance.k, "damping_scale": nuisance.c, "mass_scale": 1.0, "torque_gain": 1.0}.get(law.name)
    if base is not None:
        return {"name": law.name, "strength": law.strength, "from": base, "to": base * (1 + size)}
    was = float(getattr(change.before[0], law.strength)) if change.before else 0.0
    return {"name": law.name, "strength": law.strength, "from": was, "to": size}


def _redrawn(law: Law, rng: np.random.Generator) -> Law:
    """Return the law for another session: the random phases of gusts and pulses are drawn again."""
    own: dict[str, Any] = {}
    names: Sequence[str] = [field.name for field in fields(law)]
    if "seed" in names:
        own["seed"] = int(rng.integers(1 << 31))
    if "phase" in names:
        own["phase"] = float(rng.uniform(0, 2 * np.pi))
    return replace(law, **own)

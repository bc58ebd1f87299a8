"""Two recordings of one messy arm, of which something is another in the second, or nothing is."""

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
from hsr_pin.blind.workshop import BELIEVABLE, MessyArm, Workshop, answer_of, quieter, strong_enough
from hsr_pin.errors import SimulationFailure

#: Folders of the two recordings.
OLD, NEW = "old", "new"
#: By how much an effect grows.
GROWTH = 1.5
#: Share of the arms that have a clear effect already, which stays as it is.
STANDING = 0.3


@dataclass(frozen=True)
class Change:
    """What happens between the two recordings: the laws before and after it, and the gap that it makes [mm]."""

    before: tuple[Law, ...] = ()
    after: tuple[Law, ...] = ()
    gap: float = 0.0
    reached: bool = True


def build_pair(case: Case, folder: Path, workshop: Workshop, attempt: int) -> Answer:
    """Write both recordings into folders of their own."""
    arm = MessyArm.of(replace(case, sizes=()), workshop, attempt)
    arm = replace(arm, program=arm.mess.staged(program(case.later, case.mount, case.given)))  # it shows in the second
    standing = _standing(case, arm, attempt)
    change = _change(case, arm, standing, attempt)
    if change.after:
        arm = replace(arm, nuisance=quieter(arm.nuisance, change.gap))
    small = arm.background([*case.effects, *(law.name for law in standing)])
    rng = np.random.default_rng([case.seed, 8])
    sessions = [
        (OLD, case.program, arm.mess, change.before),
        (NEW, case.later, replace(arm.mess, seed=int(rng.integers(1 << 31))), change.after),
    ]
    for session, (name, kinds, mess, laws) in enumerate(sessions):
        others = [_anew(law, rng) if session else law for law in small.laws]
        trials = mess.staged(program(kinds, case.mount, case.given))
        workshop.messy.run(
            trials, (*laws, *standing, *others), case.seed, folder / name, arm.nuisance, mess=mess, session=session
        )
    chosen = [Scaled(law, change.gap, change.reached) for law in change.after]
    answer = answer_of(case, chosen, [change.gap] * len(chosen), arm.nuisance, small, arm.mess)
    facts = {**answer.facts, "standing": [law.describe() for law in standing], "change": _told(change, arm.nuisance)}
    return replace(answer, facts=facts, background=())  # what is in both recordings is no change


def _standing(case: Case, arm: MessyArm, attempt: int) -> tuple[Law, ...]:
    """A clear effect that was there and stays, or none."""
    rng = np.random.default_rng([case.seed, 7, attempt])
    if case.kind == "grows" or rng.random() > STANDING:
        return ()
    name = str(rng.choice([name for name in CATALOGUE if name not in case.effects]))
    return (scale_to_gap(draw(name, rng), arm.wanted("medium"), arm.yardstick(), refit=True, tolerance=0.3, steps=6).law,)


def _change(case: Case, arm: MessyArm, standing: tuple[Law, ...], attempt: int) -> Change:
    if not case.effects:
        return Change()
    wanted, yardstick = arm.wanted(case.sizes[0]), arm.yardstick(standing)
    if case.kind != "grows":
        plain = case.kind == "parameter"  # stiffness and damping must not be refitted: they are what changes
        found = strong_enough(case, 0, wanted, yardstick, attempt, refit=not plain)
        return Change((), (found.law,), found.gap, found.reached)
    share = GROWTH / (GROWTH - 1)  # of what grows by half, a third is new
    law = strong_enough(case, 0, min(share * wanted, 2 * BELIEVABLE), yardstick, attempt).law
    before = law.scaled(1 / GROWTH)
    gap = yardstick.refitted_step(before, law)
    if not gap > 0:
        raise SimulationFailure(f"{law.name} does not show in {case.name}", None)
    return Change((before,), (law,), gap, bool(abs(gap / wanted - 1) < 0.5))


def _told(change: Change, nuisance: Nuisance) -> dict[str, Any]:
    """What changed, by the field that says how strong its law is; a plain parameter over its declared value."""
    if not change.after:
        return {}
    law = change.after[0]
    size = float(getattr(law, law.strength))
    base = {"keq_scale": nuisance.k, "damping_scale": nuisance.c, "mass_scale": 1.0, "torque_gain": 1.0}.get(law.name)
    if base is not None:
        return {"name": law.name, "strength": law.strength, "from": base, "to": base * (1 + size)}
    was = float(getattr(change.before[0], law.strength)) if change.before else 0.0
    return {"name": law.name, "strength": law.strength, "from": was, "to": size}


def _anew(law: Law, rng: np.random.Generator) -> Law:
    """The same law on another day: gusts and pulses do not repeat themselves."""
    own: dict[str, Any] = {}
    names: Sequence[str] = [field.name for field in fields(law)]  # type: ignore[arg-type]
    if "seed" in names:
        own["seed"] = int(rng.integers(1 << 31))
    if "phase" in names:
        own["phase"] = float(rng.uniform(0, 2 * np.pi))
    return replace(law, **own)  # type: ignore[type-var]

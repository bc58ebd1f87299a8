"""Sentences on a diagnosis and on what to do next, used on the screen and in the report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hsr_pin.diagnosis.where import Where
from hsr_pin.effects import EFFECTS
from hsr_pin.effects.effect import KINDS
from hsr_pin.effects.flexible import FLEXIBLE
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.estimates import number
from hsr_pin.inference.fit import Fit

if TYPE_CHECKING:
    from hsr_pin.diagnosis.result import Diagnosis

#: Standard experiment -> how to carry it out.
EXPERIMENTS = {
    "steps": "steps from rest to the largest torque",
    "steps aside": "the same steps towards y of the base",
    "staircase": "four equal steps up to the largest torque, and down again",
    "chirp": "a chirp between zero and the largest torque, with rising frequency",
    "release": "hold the arm bent without torque, and release it",
    "payload": "the same steps with 50 g at the tip",
    "tilted base": "the same steps with the base tilted by 20 degrees",
}


def readable(names: Sequence[str]) -> str:
    """Return names of effects as text: ``dry friction + tip mass``."""
    return " + ".join(name.replace("_", " ") for name in names)


def sentence(text: str) -> str:
    """Return a sentence in which the names of effects and kinds of physics are readable, not those in the code."""
    for name in (*EFFECTS, *SPATIAL, *FLEXIBLE, *KINDS):
        text = text.replace(name, name.replace("_", " "))
    return text[:1].upper() + text[1:]


def model_name(candidate: Candidate) -> str:
    """Return the name of a fitted model as text."""
    return readable(candidate.names) or "stiffness and damping only"


def advice(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Return what to do next, one sentence for each item."""
    status, search = diagnosis.verdict.status, diagnosis.search
    sentences = []
    if diagnosis.next_experiment:
        first = diagnosis.next_experiment[0]
        what = EXPERIMENTS.get(first.name, first.name)
        separates = "separates the explanations best" if status == "ambiguous" else "is the most informative one"
        sentences.append(f"Record next: {what}; this experiment {separates} (by {number(first.separation)} times the noise).")
    elif status == "ambiguous":
        sentences.append(
            "No standard experiment separates these explanations on this arm. Measure one of them directly, for example the mass."
        )
    if status in ("identified", "parameters") and search is not None:
        sentences.append(f"Simulate with {scales(search.best.fit)}{', and the identified effects' * (status == 'identified')}.")
    if status == "unexplained":
        sentences.append(
            "Do not trust the values of a model that does not explain the gap; the maps show where and when it occurs."
        )
    if status == "partly_identified":
        sentences.append("Simulate with the reported effects; the gap that remains makes their values less certain.")
    if search is not None and (bounds := search.best.fit.on_bound()):
        sentences.append(f"{', '.join(bounds)} ended on a bound: the true value lies beyond it, or another effect is the cause.")
    if status == "no_gap":
        sentences.append("Use the declared model, discretised finely enough (joints in the middle of the elements).")
    return tuple(sentences)


def where_sentence(where: Where) -> str:
    """Return where the gap lies, and its frequency if it oscillates."""
    return where.sentence if where.frequency is None else f"{where.sentence} Strongest frequency: {where.frequency:g} Hz."


def supply_sentence(diagnosis: Diagnosis) -> str:
    """Return how the measured inputs follow their commands, and whether supply or arm are late; empty without both series."""
    found = diagnosis.supply
    if not found:
        return ""
    each = "; ".join(f"{supply.name} {supply}" if len(found) > 1 else str(supply) for supply in found)
    named = {*diagnosis.verdict.effects, *(name for names in diagnosis.verdict.alternatives for name in names)}
    slow = [name for name, effect in (EFFECTS | SPATIAL).items() if name in named and effect.kind == "actuation_time"]
    if any(supply.is_late for supply in found):
        late = f"The supply is late, and so is the arm ({' or '.join(slow)})" if slow else "The supply is late"
    else:
        late = f"The arm is late ({' or '.join(slow)}), not the supply" if slow else "The supply is not late"
    return f"{each}. {late}; the model of the arm is driven by what was measured."


def scales(fit: Fit) -> str:
    """Return the fitted factors on declared parameters of the arm: ``Keq times 1.07, C times 1.1``."""
    counterparts = {"keq_scale": "Keq", "damping_scale": "C", "mass_scale": "the mass", "torque_gain": "the torque"}
    return ", ".join(f"{what} times {number(fit.named[name])}" for name, what in counterparts.items() if name in fit.named)


def effect_options(fit: Fit, levels: Sequence[float]) -> dict[str, str]:
    """Return the fitted effects as options of ``hsr-sim`` (``--effect dry_friction:level=0.05``), by the Keq at which they hold.

    If an effect has another size at each declared level [Nm/rad], the keys are "1.11 Nm/rad" and so on; otherwise the only key is
    "".
    """
    if not any(part.levels or part.resized for part in fit.hypothesis.parts):
        return {"": _options(fit, levels[0], 1.0)}
    return {f"{keq:g} Nm/rad": _options(fit, keq, keq / min(levels)) for keq in sorted(levels)}


def _options(fit: Fit, keq: float, level: float) -> str:
    return " ".join(
        f"--effect {effect.name}:"
        + ",".join(
            [f"{fact.name}={getattr(effect, fact.name):.4g}" for fact in effect.parameters()]
            + [f"{name}={value}" for name, value in effect.options]
        )
        for effect in fit.hypothesis.effects_at(fit.values, level, keq)
    )

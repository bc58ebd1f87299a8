"""A model with some of its numbers left open: what a fit searches, and what a diagnosis compares."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, formless, with_values
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.part import ARM, PLAIN, SESSION, Part
from hsr_pin.identification.prepared import Prepared, Run
from hsr_pin.inference.problem import ALWAYS
from hsr_pin.parameters import Parameter
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.specification import ArmSpecification, Placement
from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array, Dataset

#: Those that are factors on a number of the arm.
_FACTORS = {"keq_scale": "keq", "damping_scale": "damping", "mass_scale": "mass"}
#: Open number of the arm -> by what it changes over the session.
_DRIFTS = {"keq_scale": "keq_drift", "torque_gain": "gain_drift"}
#: Links of the chain that models an arm: its tip is within 0.05 % of the length of the continuous arm's.
LINKS = 16
#: Error of a step in fits [m at the tip].
TOLERANCE = 2e-4
#: Links and error of a step [m at the tip] of the chain that many models are tried with.
_LINKS, _TOLERANCE = 8, 5e-4
#: Factors on the damping and the amplitude of an initial estimate at which it is tried too: an effect may grow faster than its
#: amplitude; without it, the damping stood in for it, and a fit may stay in that valley.
_VALLEYS = ((1.0, 1.0), (1.0, 0.5), (0.5, 2.0), (0.2, 6.0))
#: Factors on the damping, and sizes over their scale up to the width of the prior, of laws that make the torque late.
_LATE = ((0.5, 0.2), (0.6, 1.5, 5.0))


def chain_of(dataset: Dataset, links: int | None, placement: Placement | None) -> dict[str, Any]:
    """Keyword arguments ``links`` and ``placement`` of the chain that models a dataset.

    Each is the one that is asked for, else that of the model which simulated the dataset, else :data:`LINKS` in the middle.
    """
    own_links, own_placement = dataset.chain or (LINKS, "mid")
    return {"links": links or own_links, "placement": placement or own_placement}


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model of the arm with open parameters.

    Attributes:
        effects: what acts beside the nominal model; their values are where a fit starts.
        free: names of the open parameters: "keq_scale", "damping_scale", "mass_scale", "torque_gain", "effect.parameter" (with
            "@1.11" behind it: for the trials declared with that Keq only), those of :data:`SESSION`.
        links, placement: the chain.
        tolerance: error of a step [m at the tip]; where little moves, it is smaller still.
        resized: names of effects whose amplitude is that of the softest level, and changes with the level against their law.
    """

    effects: tuple[Effect, ...] = ()
    free: tuple[str, ...] = ("keq_scale", "damping_scale")
    links: int = LINKS
    placement: Placement = "mid"
    tolerance: float = TOLERANCE
    resized: tuple[str, ...] = ()

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Unit, bounds and scale of each open parameter.

        Raises:
            IdentificationError: a name that there is not.
        """
        known = ARM | SESSION
        known |= {f"{e.name}.{p.name}": replace(p, name=f"{e.name}.{p.name}") for e in self.effects for p in e.parameters()}
        facts = []
        for name in self.free:
            base, at, level = name.partition("@")
            if base not in known or (at and (base in SESSION or not _is_number(level))):
                raise IdentificationError("parameter", expected=", ".join(known), received=repr(name))
            facts.append(replace(known[base], name=name))
        return tuple(facts)

    @cached_property
    def start(self) -> Array:
        """(P,) values to start from."""
        own = {f"{e.name}.{p.name}": float(getattr(e, p.name)) for e in self.effects for p in e.parameters()}
        return np.array([own.get(fact.name.partition("@")[0], fact.neutral) for fact in self.parameters])

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """(P,) each: lowest and highest values."""
        return np.array([fact.lower for fact in self.parameters]), np.array([fact.upper for fact in self.parameters])

    @cached_property
    def scale(self) -> Array:
        """(P,) changes of practical size."""
        return np.array([fact.scale for fact in self.parameters])

    def with_effects(self, *effects: Effect) -> Hypothesis:
        """The same with further effects, all their parameters open."""
        names = tuple(f"{e.name}.{p.name}" for e in effects for p in e.parameters())
        return replace(self, effects=(*self.effects, *effects), free=(*self.free, *names))

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The effects, and the open numbers of the arm beside stiffness and damping."""
        effects = tuple(Part(e.name, e, e.name in self.resized, self._opens(e), self._levels(e)) for e in self.effects)
        return (*(Part(name) for name in PLAIN if name in self.free), *effects)

    @property
    def key(self) -> tuple[tuple[object, ...], ...]:
        """What it has beside stiffness and damping, in which variant: name, options, size and open amplitudes of each part."""
        readings = tuple(sorted((part.reading for part in self.parts), key=repr))
        return readings + tuple((name,) for name in self.free if name.partition("@")[0] in ARM and "@" in name)

    @property
    def labour(self) -> tuple[bool]:
        """Larger where a law has a memory, which wants short steps."""
        return (any(effect.states for effect in self.effects),)

    @property
    def rough(self) -> Hypothesis:
        """The same with few links and larger steps."""
        return replace(self, links=min(_LINKS, self.links), tolerance=max(_TOLERANCE, self.tolerance))

    def tried_from(self, starts: Sequence[Array]) -> list[tuple[int, Array]]:
        """Values (P,) from which a fit might start, each with its group.

        The proposed ones are among them, and the same in the next valleys. Of a law that makes the torque late there are values
        with much less damping, and with the declared arm: a strongly damped arm looks late by itself. Seen from there lateness is
        worth next to nothing, so that its size is none of the proposal's.
        """
        found = [(k, self._moved(start, *factors)) for k, start in enumerate(starts) for factors in _VALLEYS]
        facts, part, start = self.parameters, self.parts[-1], starts[0]
        if part.kind != "actuation_time":
            return found
        own = [k for k, fact in enumerate(facts) if fact.amplitude and fact.name.startswith(f"{part.name}.")]
        is_arms = [fact.name.partition("@")[0] in ARM for fact in facts]
        arms = [(len(starts), self._moved(start, damping, 1.0)) for damping in _LATE[0]]
        arms.append((ALWAYS, np.where(is_arms, [fact.neutral for fact in facts], start)))
        for (group, arm), size in itertools.product(arms, _LATE[1]):
            point = arm.copy()
            sizes = [(facts[k], facts[k].neutral + size * facts[k].scale / len(own)) for k in own]
            point[own] = [np.clip(value, fact.lower, fact.upper) for fact, value in sizes]
            found.append((group, point))
        return found

    def _moved(self, values: Array, damping: float, amplitude: float) -> Array:
        """Values (P,), the damping times one factor, and amplitudes of the last part as far from neutral times another."""
        moved, last = values.copy(), self.parts[-1].name
        for index, fact in enumerate(self.parameters):
            if fact.name.partition("@")[0] == "damping_scale":
                moved[index] *= damping
            elif fact.amplitude and fact.name.startswith(f"{last}."):
                moved[index] = fact.neutral + amplitude * (moved[index] - fact.neutral)
            moved[index] = np.clip(moved[index], fact.lower, fact.upper)
        return moved

    def _opens(self, effect: Effect) -> str:
        """The one amplitude that is open, of an effect that has them apart."""
        free = {name.partition("@")[0] for name in self.free}
        open_ = [name for name in effect.apart if f"{effect.name}.{name}" in free]
        return open_[0] if len(open_) == 1 else ""

    def _levels(self, effect: Effect) -> tuple[float, ...]:
        """The Keq at which an effect has sizes of its own."""
        apart = (name.partition("@")[2] for name in self.free if name.startswith(f"{effect.name}."))
        return tuple(sorted({float(level) for level in apart if level}))

    def with_part(self, part: Part) -> Hypothesis:
        """The same with one more."""
        if part.effect is None:
            return replace(self, free=(*self.free, *(name for name in (ARM | SESSION) if name.partition(".")[0] == part.name)))
        more = self.with_effects(part.effect)
        if part.opens:
            more = replace(more, free=(*self.free, f"{part.name}.{part.opens}"))
        if part.levels:
            own = [f"{part.name}.{fact.name}@{keq:g}" for fact in part.effect.parameters() for keq in part.levels]
            more = replace(more, free=(*self.free, *own))
        return replace(more, resized=(*self.resized, part.name)) if part.resized else more

    def without_part(self, name: str) -> tuple[Hypothesis, list[int]]:
        """The same with one less, and which of the open parameters are left."""
        kept = [k for k, free in enumerate(self.free) if free != name and not free.startswith(f"{name}.")]
        fewer = replace(
            self,
            effects=tuple(effect for effect in self.effects if effect.name != name),
            free=tuple(self.free[k] for k in kept),
            resized=tuple(other for other in self.resized if other != name),
        )
        return fewer, kept

    def effects_at(self, values: Array, level: float = 1.0, keq: float | None = None) -> tuple[Effect, ...]:
        """The effects with the open parameters at ``values`` (P,), or stacked for (C, P).

        Args:
            values: as above.
            level: declared Keq of the run over that of the softest.
            keq: that declared Keq; a parameter that is open at other levels alone has the value of the first of them.
        """
        named: dict[str, Array] = {}
        for name, column in zip(self.free, np.moveaxis(values, -1, 0), strict=True):
            base, at, _ = name.partition("@")
            if base not in named or (at and keq is not None and _holds_at(name, keq)):
                named[base] = column

        def numbers(effect: Effect) -> dict[str, Any]:
            found = {}
            for fact in effect.parameters():
                value = np.broadcast_to(named.get(f"{effect.name}.{fact.name}", getattr(effect, fact.name)), values.shape[:-1])
                if fact.amplitude and effect.name in self.resized:
                    value = np.clip(value * level**fact.resizes, fact.lower, fact.upper)
                found[fact.name] = np.array(value) if value.ndim else float(value)
            return found

        return tuple(with_values(effect, **numbers(effect)) for effect in self.effects)

    def acts(self, name: str, run: Run) -> bool:
        """Whether an open parameter plays a part in a run."""
        return _holds_at(name, run.trial.keq)

    def factor(self, base: str, run: Run, values: Array) -> Array:
        """(C,) the value of an open number of the arm in a run, for values (C, P); 1 where it is not open."""
        columns = [k for k, name in enumerate(self.free) if name.partition("@")[0] == base and self.acts(name, run)]
        factor = values[:, columns[0]] if columns else np.ones(len(values))
        if (drift := _DRIFTS.get(base)) in self.free:
            factor = factor * (1 + values[:, self.free.index(str(drift))] * self._gone(str(drift), run, values))
        return factor

    def _gone(self, drift: str, run: Run, values: Array) -> Array:
        """(C,) how much of what changes over the session has come in a run: evenly, or settling."""
        name = f"{drift}.settling"
        if name not in SESSION:
            return np.full(len(values), run.place)
        settling = values[:, self.free.index(name)] if name in self.free else SESSION[name].neutral
        return np.asarray(np.expm1(-run.place / settling) / np.expm1(-1 / settling))

    def columns(self, experiment: Prepared, run: Run, values: Array) -> Columns:
        """The arms of one run with the open parameters at ``values`` (C, P).

        Raises:
            IdentificationError: a law has no form for arms in space, or for those in a plane.
        """
        if wrong := formless(self.effects, space=len(experiment.axes) == 3):
            expected = "laws that hold about two axes" if len(experiment.axes) == 3 else "laws of an arm in a plane"
            raise IdentificationError("effects", expected=expected, received=wrong)
        declared = self.declared(experiment, run)
        numbers = {name: np.full(len(values), float(getattr(declared, name))) for name in Arms.NUMBERS}
        for name, number in _FACTORS.items():
            numbers[number] = numbers[number] * self.factor(name, run, values)
        return Columns(
            Arms(
                declared.links,
                declared.placement,
                declared.mount,
                bending=declared.bending,
                sections=declared.sections,
                **numbers,
            ),
            self.effects_at(values, run.trial.keq / experiment.levels[0], run.trial.keq),
        )

    def declared(self, experiment: Prepared, run: Run) -> ArmSpecification:
        """The arm as a run declares it, on this chain; fits may bend it further than an arm should be."""
        chain = (self.links, self.placement)
        if chain not in run.declared:
            run.declared[chain] = ArmSpecification.from_trial(
                experiment.dataset, run.trial, links=self.links, placement=self.placement, bending_limit=2 * np.pi
            )
        return run.declared[chain]


def _holds_at(name: str, keq: float) -> bool:
    """Whether an open parameter is one of all levels, or of the trials declared with this Keq."""
    level = name.partition("@")[2]
    return not level or bool(np.isclose(float(level), keq))


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False

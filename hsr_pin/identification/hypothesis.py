"""A model with some of its numbers left open: what a fit searches, and what a diagnosis compares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, formless, neutral, with_values
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment, Run
from hsr_pin.parameters import Parameter
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.specification import ArmSpecification, Placement
from hsr_pin.simulation.columns import Columns
from hsr_pin.trajectory import Array, Dataset

#: Stiffness, mass and gain are usually measured to within a third or so; damping is often guessed, within a factor of three. As
#: standard deviations of the logarithm of what is true over what was declared.
_MEASURED, _GUESSED = 0.3, 1.0
#: Open numbers of the arm itself, as factors on what was declared.
ARM = {
    fact.name: fact
    for fact in (
        Parameter("keq_scale", "1", 1.0, 0.1, 10.0, 0.1, False, "stiffness over the declared one", ratio_width=_MEASURED),
        Parameter("damping_scale", "1", 1.0, 0.02, 50.0, 0.2, False, "damping over the declared one", ratio_width=_GUESSED),
        Parameter("mass_scale", "1", 1.0, 0.1, 10.0, 0.1, False, "mass of the arm over the declared one", ratio_width=_MEASURED),
        Parameter(
            "torque_gain", "1", 1.0, 0.1, 10.0, 0.1, False, "torque that arrives over the commanded", ratio_width=_MEASURED
        ),
    )
}
#: Those that are factors on a number of the arm.
_FACTORS = {"keq_scale": "keq", "damping_scale": "damping", "mass_scale": "mass"}
#: Of the session: by how much the arm's stiffness differs in the last trial from the first (L. Mullins, Rubber Chem. Technol. 42,
#: 1969), and after what part of the session most of that has come; and by how much the torque does, evenly.
SESSION = {
    "keq_drift": Parameter("keq_drift", "1", 0.0, -0.9, 2.0, 0.1, True, "stiffness gained from the first trial to the last"),
    "keq_drift.settling": Parameter(
        "keq_drift.settling", "1", 0.5, 0.05, 5.0, 0.2, False, "part of the session over which it is gained"
    ),
    "gain_drift": Parameter("gain_drift", "1", 0.0, -0.9, 2.0, 0.1, True, "torque gained from the first trial to the last"),
}
#: Open number of the arm -> by what it changes over the session.
_DRIFTS = {"keq_scale": "keq_drift", "torque_gain": "gain_drift"}
#: Candidates beside the effects, which stiffness and damping leave open, and the kind of physics that each belongs to.
PLAIN = {"torque_gain": "actuation_map", "mass_scale": "mass_gravity", "keq_drift": "elastic", "gain_drift": "actuation_map"}
#: Those that are the same in every trial.
ACTING = tuple(name for name in PLAIN if name not in SESSION)
#: Trials from which on a change over the session may be asked for.
TRIALS = 4
#: Kinds whose sizes may differ from one set-up of an arm to the next: how it is mounted and loaded, supplied and seen. What it
#: is made of stays, or goes with the stiffness level.
SET_UP = ("actuation_map", "mass_gravity", "measurement")
#: Links of the chain that models an arm: its tip is within 0.05 % of the length of the continuous arm's.
LINKS = 16
#: Error of a step in fits [m at the tip].
TOLERANCE = 2e-4


def chain_of(dataset: Dataset, links: int | None, placement: Placement | None) -> dict[str, Any]:
    """Keyword arguments ``links`` and ``placement`` of the chain that models a dataset.

    Each is the one that is asked for, else that of the model which simulated the dataset, else :data:`LINKS` in the middle.
    """
    own_links, own_placement = dataset.chain or (LINKS, "mid")
    return {"links": links or own_links, "placement": placement or own_placement}


@dataclass(frozen=True)
class Part:
    """What a model may have more than stiffness and damping: an effect, or another open number of the arm.

    Attributes:
        name: of the effect, or of the number: one of :data:`PLAIN`.
        effect: with its options; None for a number.
        resized: whether the effect's amplitude goes with the stiffness level where its law says that it stays, and stays
            where its law says that it goes with it.
        opens: of an effect that has its amplitudes ``apart`` the one that is open; empty: all parameters are.
        levels: declared Keq [Nm/rad] at which it has a size of its own each; empty: one size for all.
    """

    name: str
    effect: Effect | None = None
    resized: bool = False
    opens: str = ""
    levels: tuple[float, ...] = ()

    @property
    def kind(self) -> str:
        """Of physics that it belongs to."""
        return self.effect.kind if self.effect else PLAIN[self.name]

    @property
    def flexible(self) -> bool:
        """Whether it stands for its kind only."""
        return self.effect is not None and self.effect.flexible

    def contains(self, other: Part) -> bool:
        """Whether the other is a special case of this one, which has more numbers to bend."""
        if self.effect is None:
            return False
        if self.name == other.name:
            return (
                bool(self.levels) and replace(other, resized=False, levels=self.levels).reading == self.reading != other.reading
            )
        return (self.flexible and not other.flexible and other.kind == self.kind) or other.name in self.effect.contains

    @property
    def reading(self) -> tuple[object, ...]:
        """Name, options, size and what is open: what tells it from other readings of the same law."""
        return self.name, self.effect.options if self.effect else (), self.resized, self.opens, self.levels


def readings(kind: type[Effect], *, space: bool = False, levels: int = 1, each: Sequence[float] = ()) -> list[Part]:
    """Every reading of a law that holds for arms in a plane, or in space, and that so many stiffness levels tell.

    Where there are levels (declared Keq [Nm/rad]) that tell a size ``each``, laws of a single number have that reading too, if
    it is of the kinds of :data:`SET_UP`.
    """
    effects = [neutral(kind, **options) for options in kind.variants()]
    return [
        Part(kind.name, effect, resized, opens, own)
        for effect in effects
        if not formless([effect], space=space)
        for opens in kind.apart or ("",)
        for resized, own in _sizes(kind, opens, levels, tuple(float(f"{keq:g}") for keq in each))  # as names tell them
    ]


def _sizes(kind: type[Effect], opens: str, levels: int, each: tuple[float, ...]) -> list[tuple[bool, tuple[float, ...]]]:
    """As the law says, the other way, and for each level its own: ``resized`` and ``levels`` of its readings."""
    found: list[tuple[bool, tuple[float, ...]]] = [(False, ())]
    if levels > 1 and _resizes(kind, opens):
        found.append((True, ()))
    if each and kind.kind in SET_UP and len(kind.parameters()) == 1 and not kind.flexible:
        found.append((False, each))
    return found


def _resizes(kind: type[Effect], opens: str) -> bool:
    return any(fact.resizes for fact in kind.parameters() if opens in ("", fact.name))


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

    def columns(self, experiment: Experiment, run: Run, values: Array) -> Columns:
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

    def declared(self, experiment: Experiment, run: Run) -> ArmSpecification:
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

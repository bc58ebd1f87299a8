"""Models with open parameters, which a fit estimates and a diagnosis compares."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Effect, unsupported_laws, with_values
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.part import ARM, PLAIN, SESSION, Part
from hsr_pin.identification.prepared import Prepared, Run
from hsr_pin.inference.problem import ALWAYS
from hsr_pin.parameters import Parameter
from hsr_pin.robot.chain import Arms
from hsr_pin.robot.specification import ArmSpecification, Placement
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.trajectory import Array, Dataset

#: Open parameters that are factors on a number of the arm.
_FACTORS = {"keq_scale": "keq", "damping_scale": "damping", "mass_scale": "mass"}
#: Open number of the arm -> the parameter of its change over the session.
_DRIFTS = {"keq_scale": "keq_drift", "torque_gain": "gain_drift"}
#: Default number of links: the tip is then within 0.05 % of the length from that of the continuous arm.
LINKS = 16
#: Tolerance of a step in fits [m at the tip].
TOLERANCE = 2e-4
#: Number of links and tolerance of a step [m at the tip] of the coarse chain with which many models are tried.
_LINKS, _TOLERANCE = 8, 5e-4
#: Factors on the damping and on the amplitude of an initial estimate, for additional initial values: an effect may grow faster
#: than its amplitude, and without the effect the damping compensates for it, so that a fit could end in a local minimum.
_START_FACTORS = ((1.0, 1.0), (1.0, 0.5), (0.5, 2.0), (0.2, 6.0))
#: Factors on the damping, and amplitudes relative to their scales, for additional initial values of laws that delay the torque.
_DELAY_STARTS = ((0.5, 0.2), (0.6, 1.5, 5.0))


def chain_of(dataset: Dataset, links: int | None, placement: Placement | None) -> dict[str, Any]:
    """Return the keyword arguments ``links`` and ``placement`` of the chain that models a dataset.

    Each is the requested value, else that of the model which simulated the dataset, else :data:`LINKS` or "mid".
    """
    own_links, own_placement = dataset.chain or (LINKS, "mid")
    return {"links": links or own_links, "placement": placement or own_placement}


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model of the arm with open parameters.

    Attributes:
        effects: effects in addition to the nominal model; their values are the initial values of a fit.
        free: names of the open parameters: "keq_scale", "damping_scale", "mass_scale", "torque_gain", "effect.parameter"
            (followed by "@1.11" for the trials declared with that Keq only), or those of :data:`SESSION`.
        links, placement: number of links and joint placement of the chain.
        tolerance: tolerance of a step [m at the tip]; it is reduced for small motions.
        resized: names of effects whose amplitude is that of the softest level and scales with the level differently from their
            law.
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
            IdentificationError: there is no parameter of a given name.
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
        """Initial values (P,) of the open parameters."""
        own = {f"{e.name}.{p.name}": float(getattr(e, p.name)) for e in self.effects for p in e.parameters()}
        return np.array([own.get(fact.name.partition("@")[0], fact.neutral) for fact in self.parameters])

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest values of the open parameters, (P,) each."""
        return np.array([fact.lower for fact in self.parameters]), np.array([fact.upper for fact in self.parameters])

    @cached_property
    def scale(self) -> Array:
        """Changes of practical size of the open parameters (P,)."""
        return np.array([fact.scale for fact in self.parameters])

    def with_effects(self, *effects: Effect) -> Hypothesis:
        """Return the hypothesis with further effects, all their parameters open."""
        names = tuple(f"{e.name}.{p.name}" for e in effects for p in e.parameters())
        return replace(self, effects=(*self.effects, *effects), free=(*self.free, *names))

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The effects, and the open numbers of the arm in addition to stiffness and damping."""
        effects = tuple(Part(e.name, e, e.name in self.resized, self._opens(e), self._levels(e)) for e in self.effects)
        return (*(Part(name) for name in PLAIN if name in self.free), *effects)

    @property
    def key(self) -> tuple[tuple[object, ...], ...]:
        """Name, options, size variant and open amplitudes of each part: a key that identifies the model."""
        variants = tuple(sorted((part.variant for part in self.parts), key=repr))
        return variants + tuple((name,) for name in self.free if name.partition("@")[0] in ARM and "@" in name)

    @property
    def cost(self) -> tuple[bool]:
        """Order of computing cost: larger if a law has a memory, which requires short steps."""
        return (any(effect.states for effect in self.effects),)

    @property
    def rough(self) -> Hypothesis:
        """The hypothesis with fewer links and larger steps."""
        return self.coarser(_LINKS, _TOLERANCE)

    def coarser(self, links: int, tolerance: float) -> Hypothesis:
        """Return the hypothesis with at most this many links, and at least this tolerance of a time step [m at the tip]."""
        return replace(self, links=min(links, self.links), tolerance=max(tolerance, self.tolerance))

    def start_points(self, starts: Sequence[Array]) -> list[tuple[int, Array]]:
        """Return values (P,) from which a fit may start, each with its group.

        They contain the proposed values, and variations of them that lead to neighbouring minima. For a law that delays the
        torque there are also values with much less damping, and with the declared arm, because strong damping alone resembles a
        delay. The sensitivity to the delay is very small at those values, so the proposed amplitude is not used there.
        """
        found = [(k, self._moved(start, *factors)) for k, start in enumerate(starts) for factors in _START_FACTORS]
        facts, part, start = self.parameters, self.parts[-1], starts[0]
        if part.kind != "actuation_time":
            return found
        own = [k for k, fact in enumerate(facts) if fact.amplitude and fact.name.startswith(f"{part.name}.")]
        is_arms = [fact.name.partition("@")[0] in ARM for fact in facts]
        arms = [(len(starts), self._moved(start, damping, 1.0)) for damping in _DELAY_STARTS[0]]
        arms.append((ALWAYS, np.where(is_arms, [fact.neutral for fact in facts], start)))
        for (group, arm), size in itertools.product(arms, _DELAY_STARTS[1]):
            point = arm.copy()
            sizes = [(facts[k], facts[k].neutral + size * facts[k].scale / len(own)) for k in own]
            point[own] = [np.clip(value, fact.lower, fact.upper) for fact, value in sizes]
            found.append((group, point))
        return found

    def _moved(self, values: Array, damping: float, amplitude: float) -> Array:
        """Return values (P,) with factors on the damping and on the deviation of the last part's amplitudes from neutral."""
        moved, last = values.copy(), self.parts[-1].name
        for index, fact in enumerate(self.parameters):
            if fact.name.partition("@")[0] == "damping_scale":
                moved[index] *= damping
            elif fact.amplitude and fact.name.startswith(f"{last}."):
                moved[index] = fact.neutral + amplitude * (moved[index] - fact.neutral)
            moved[index] = np.clip(moved[index], fact.lower, fact.upper)
        return moved

    def _opens(self, effect: Effect) -> str:
        """Return the single open amplitude of an effect with alternative amplitudes."""
        free = {name.partition("@")[0] for name in self.free}
        open_ = [name for name in effect.alternative_amplitudes if f"{effect.name}.{name}" in free]
        return open_[0] if len(open_) == 1 else ""

    def _levels(self, effect: Effect) -> tuple[float, ...]:
        """Return the Keq at which an effect has separate amplitudes."""
        separate = (name.partition("@")[2] for name in self.free if name.startswith(f"{effect.name}."))
        return tuple(sorted({float(level) for level in separate if level}))

    def with_part(self, part: Part) -> Hypothesis:
        """Return the hypothesis with one more part."""
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
        """Return the hypothesis without a part, and the indices of the remaining open parameters."""
        kept = [k for k, free in enumerate(self.free) if free != name and not free.startswith(f"{name}.")]
        fewer = replace(
            self,
            effects=tuple(effect for effect in self.effects if effect.name != name),
            free=tuple(self.free[k] for k in kept),
            resized=tuple(other for other in self.resized if other != name),
        )
        return fewer, kept

    def effects_at(self, values: Array, level: float = 1.0, keq: float | None = None) -> tuple[Effect, ...]:
        """Return the effects with the open parameters at ``values`` (P,), or stacked for (C, P).

        Args:
            values: (P,) or (C, P) values of the open parameters.
            level: declared Keq of the run relative to that of the softest level.
            keq: declared Keq of the run; a parameter that is open at other levels only has the value of the first of them.
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
                    value = np.clip(value * level**fact.level_exponent, fact.lower, fact.upper)
                found[fact.name] = np.array(value) if value.ndim else float(value)
            return found

        return tuple(with_values(effect, **numbers(effect)) for effect in self.effects)

    def acts(self, name: str, run: Run) -> bool:
        """Return whether an open parameter affects a run."""
        return _holds_at(name, run.trial.keq)

    def factor(self, base: str, run: Run, values: Array) -> Array:
        """Return the values (C,) of a factor on a number of the arm in a run, for values (C, P); 1 if it is not open."""
        columns = [k for k, name in enumerate(self.free) if name.partition("@")[0] == base and self.acts(name, run)]
        factor = values[:, columns[0]] if columns else np.ones(len(values))
        if (drift := _DRIFTS.get(base)) in self.free:
            factor = factor * (1 + values[:, self.free.index(str(drift))] * self._progress(str(drift), run, values))
        return factor

    def _progress(self, drift: str, run: Run, values: Array) -> Array:
        """Return the shares (C,) of the change over the session that have occurred before a run, linearly or exponentially."""
        name = f"{drift}.settling"
        if name not in SESSION:
            return np.full(len(values), run.place)
        settling = values[:, self.free.index(name)] if name in self.free else SESSION[name].neutral
        return np.asarray(np.expm1(-run.place / settling) / np.expm1(-1 / settling))

    def arm_batch(self, experiment: Prepared, run: Run, values: Array) -> ArmBatch:
        """Return the arms of one run with the open parameters at ``values`` (C, P).

        Raises:
            IdentificationError: a law is not defined for arms in space, or for planar arms.
        """
        if wrong := unsupported_laws(self.effects, space=len(experiment.axes) == 3):
            expected = (
                "laws that are defined for arms in space"
                if len(experiment.axes) == 3
                else "laws that are defined for planar arms"
            )
            raise IdentificationError("effects", expected=expected, received=wrong)
        arms = Arms.of([self.declared(experiment, run)] * len(values))
        scaled = {number: getattr(arms, number) * self.factor(name, run, values) for name, number in _FACTORS.items()}
        return ArmBatch(replace(arms, **scaled), self.effects_at(values, run.trial.keq / experiment.levels[0], run.trial.keq))

    def declared(self, experiment: Prepared, run: Run) -> ArmSpecification:
        """Return the arm as declared for a run, on this chain, with an extended bending limit for fits."""
        chain = (self.links, self.placement)
        if chain not in run.declared:
            run.declared[chain] = ArmSpecification.from_trial(
                experiment.dataset, run.trial, links=self.links, placement=self.placement, bending_limit=2 * np.pi
            )
        return run.declared[chain]


def _holds_at(name: str, keq: float) -> bool:
    """Return whether an open parameter applies to trials that are declared with this Keq."""
    level = name.partition("@")[2]
    return not level or bool(np.isclose(float(level), keq))


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False

"""Parts that a model of an arm may have in addition to stiffness and damping: effects, and further open numbers of the arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hsr_pin.effects.effect import Effect, neutral, unsupported_laws
from hsr_pin.parameters import Parameter

#: Prior standard deviations of the logarithm of the true value over the declared one: stiffness, mass and gain are usually
#: measured to within a third; damping is often guessed within a factor of three.
_MEASURED, _GUESSED = 0.3, 1.0
#: Open numbers of the arm, as factors on declared values.
ARM = {
    fact.name: fact
    for fact in (
        Parameter(
            "keq_scale", "1", 1.0, 0.1, 10.0, 0.1, False, "stiffness relative to the declared value", ratio_width=_MEASURED
        ),
        Parameter(
            "damping_scale", "1", 1.0, 0.02, 50.0, 0.2, False, "damping relative to the declared value", ratio_width=_GUESSED
        ),
        Parameter(
            "mass_scale", "1", 1.0, 0.1, 10.0, 0.1, False, "mass of the arm relative to the declared value", ratio_width=_MEASURED
        ),
        Parameter(
            "torque_gain", "1", 1.0, 0.1, 10.0, 0.1, False, "delivered torque relative to the command", ratio_width=_MEASURED
        ),
    )
}
#: Open numbers of the session: the relative change of the arm's stiffness from the first to the last trial (L. Mullins, Rubber
#: Chem. Technol. 42, 1969), the part of the session after which most of it has occurred, and the relative change of the torque,
#: which is uniform.
SESSION = {
    "keq_drift": Parameter(
        "keq_drift", "1", 0.0, -0.9, 2.0, 0.1, True, "relative change of the stiffness from the first trial to the last"
    ),
    "keq_drift.settling": Parameter(
        "keq_drift.settling", "1", 0.5, 0.05, 5.0, 0.2, False, "part of the session over which the stiffness changes"
    ),
    "gain_drift": Parameter(
        "gain_drift", "1", 0.0, -0.9, 2.0, 0.1, True, "relative change of the torque from the first trial to the last"
    ),
}
#: Candidates in addition to the effects and to stiffness and damping, with their kinds of physics.
PLAIN = {"torque_gain": "actuation_map", "mass_scale": "mass_gravity", "keq_drift": "elastic", "gain_drift": "actuation_map"}
#: Candidates that are the same in every trial.
ACTING = tuple(name for name in PLAIN if name not in SESSION)
#: Smallest number of trials for which a change over the session is considered.
TRIALS = 4
#: Kinds of physics whose size may differ from one set-up of an arm to the next (mounting, load, supply, measurement). Properties
#: of the material are constant, or scale with the stiffness level.
SET_UP = ("actuation_map", "mass_gravity", "measurement")


@dataclass(frozen=True)
class Part:
    """An addition to stiffness and damping: an effect, or another open number of the arm.

    Attributes:
        name: name of the effect or of the number (one of :data:`PLAIN`).
        effect: the effect with its options; None for a number.
        resized: whether the amplitude scales with the stiffness level where the law keeps it constant, and is constant where the
            law scales it.
        opens: the open amplitude of an effect with ``alternative_amplitudes``; empty if all parameters are open.
        levels: declared Keq [Nm/rad] at which the part has separate sizes; empty for one size at all levels.
    """

    name: str
    effect: Effect | None = None
    resized: bool = False
    opens: str = ""
    levels: tuple[float, ...] = ()

    @property
    def kind(self) -> str:
        """Kind of physics of the part."""
        return self.effect.kind if self.effect else PLAIN[self.name]

    @property
    def flexible(self) -> bool:
        """Whether the part represents its kind only."""
        return self.effect is not None and self.effect.flexible

    @property
    def base_variant(self) -> Part:
        """The part with one size that follows its law; other size variants have proportional effects on a run."""
        return replace(self, resized=False, levels=())

    @property
    def special_cases(self) -> tuple[str, ...]:
        """Names of simpler effects that are special cases of this one."""
        return self.effect.contains if self.effect else ()

    def contains(self, other: Part) -> bool:
        """Return whether another part is a special case of this one, which has more parameters."""
        if self.effect is None:
            return False
        if self.name == other.name:
            return (
                bool(self.levels) and replace(other, resized=False, levels=self.levels).variant == self.variant != other.variant
            )
        return (self.flexible and not other.flexible and other.kind == self.kind) or other.name in self.effect.contains

    @property
    def variant(self) -> tuple[object, ...]:
        """Name, options, size variant and open amplitudes, which distinguish the part from other variants of the same law."""
        return self.name, self.effect.options if self.effect else (), self.resized, self.opens, self.levels


def part_variants(kind: type[Effect], *, space: bool = False, levels: int = 1, each: Sequence[float] = ()) -> list[Part]:
    """Return all variants of a law that are defined for planar arms, or in space, and that the stiffness levels can distinguish.

    If levels (declared Keq [Nm/rad]) can distinguish a separate size ``each``, laws of a single parameter have that variant too,
    provided they are of the kinds of :data:`SET_UP`.
    """
    effects = [neutral(kind, **options) for options in kind.variants()]
    return [
        Part(kind.name, effect, resized, opens, own)
        for effect in effects
        if not unsupported_laws([effect], space=space)
        for opens in kind.alternative_amplitudes or ("",)
        for resized, own in _sizes(kind, opens, levels, tuple(float(f"{keq:g}") for keq in each))  # rounded as in parameter names
    ]


def _sizes(kind: type[Effect], opens: str, levels: int, each: tuple[float, ...]) -> list[tuple[bool, tuple[float, ...]]]:
    """Return ``resized`` and ``levels`` of the size variants: as the law says, the opposite, and separate for each level."""
    found: list[tuple[bool, tuple[float, ...]]] = [(False, ())]
    if levels > 1 and _resizes(kind, opens):
        found.append((True, ()))
    if each and kind.kind in SET_UP and len(kind.parameters()) == 1 and not kind.flexible:
        found.append((False, each))
    return found


def _resizes(kind: type[Effect], opens: str) -> bool:
    return any(fact.level_exponent for fact in kind.parameters() if opens in ("", fact.name))

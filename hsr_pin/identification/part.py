"""What a model of an arm may have more than stiffness and damping: effects, and further open numbers of the arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from hsr_pin.effects.effect import Effect, formless, neutral
from hsr_pin.parameters import Parameter

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
#: Of the session: by how much the arm's stiffness differs in the last trial from the first (L. Mullins, Rubber Chem. Technol. 42,
#: 1969), and after what part of the session most of that has come; and by how much the torque does, evenly.
SESSION = {
    "keq_drift": Parameter("keq_drift", "1", 0.0, -0.9, 2.0, 0.1, True, "stiffness gained from the first trial to the last"),
    "keq_drift.settling": Parameter(
        "keq_drift.settling", "1", 0.5, 0.05, 5.0, 0.2, False, "part of the session over which it is gained"
    ),
    "gain_drift": Parameter("gain_drift", "1", 0.0, -0.9, 2.0, 0.1, True, "torque gained from the first trial to the last"),
}
#: Candidates beside the effects, which stiffness and damping leave open, and the kind of physics that each belongs to.
PLAIN = {"torque_gain": "actuation_map", "mass_scale": "mass_gravity", "keq_drift": "elastic", "gain_drift": "actuation_map"}
#: Those that are the same in every trial.
ACTING = tuple(name for name in PLAIN if name not in SESSION)
#: Trials from which on a change over the session may be asked for.
TRIALS = 4
#: Kinds whose sizes may differ from one set-up of an arm to the next: how it is mounted and loaded, supplied and seen. What it
#: is made of stays, or goes with the stiffness level.
SET_UP = ("actuation_map", "mass_gravity", "measurement")


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

    @property
    def plain(self) -> Part:
        """The same with one size, as its law says: of one size or another a law changes as much more or less, here or there."""
        return replace(self, resized=False, levels=())

    @property
    def special_cases(self) -> tuple[str, ...]:
        """Names of simpler effects that its own numbers can make of it."""
        return self.effect.contains if self.effect else ()

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

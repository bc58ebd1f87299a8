"""Which MuJoCo elements stand for which effect of an arm.

MuJoCo 4 has springs and dampers with polynomials and springs that yield (ideal elasto-plasticity), and actuators that come late;
MuJoCo 3 has none of these. Springs with a dead band hang on fixed tendons, one for each joint, in both.

In space two hinges stand for a joint. What acts on each by itself is a law about two axes only where that is linear: all others
are called.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from hsr_pin.effects.dry_friction import presliding
from hsr_pin.effects.effect import Effect
from hsr_pin.effects.hysteresis import SLIDERS
from hsr_pin.effects.quadratic_damping import FASTEST
from hsr_pin.effects.stiffening import SOFTEST, STIFFEST
from hsr_pin.export.model import CorrectedModel
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Strand:
    """A spring on one joint, as a fixed tendon.

    Attributes:
        name: of the tendon.
        joint: number of the joint, from 1.
        stiffness: [Nm/rad].
        dead: [rad] half of the range in which it does not act.
        yields: [rad] the largest stretch that it bears; 0: any.
        pulls: how its stretch depends on the joint's hinges.
    """

    name: str
    joint: int
    stiffness: float
    dead: float = 0.0
    yields: float = 0.0
    pulls: tuple[float, ...] = (1.0,)


@dataclass(frozen=True, eq=False)
class Elements:
    """What a joint has beside a linear spring and damper.

    Attributes:
        strands: springs of their own.
        springless: the joints' own springs are among the strands.
        cubic: (N,) [Nm/rad^3] of the joints' springs.
        quadratic: (N,) [Nm s^2/rad^2] of the joints' dampers.
        ease: [rad] the angle at which the joints' springs are at ease; in space complex, towards x and towards y.
        soft: factor on the joints' springs.
        stiffest: [Nm/rad] (N,) what all this adds at most to the stiffness of the joints.
        remark: what it is, for people.
    """

    strands: tuple[Strand, ...] = ()
    springless: bool = False
    cubic: Array = field(default_factory=lambda: np.zeros(0))
    quadratic: Array = field(default_factory=lambda: np.zeros(0))
    ease: complex = 0.0
    soft: float = 1.0
    stiffest: Array = field(default_factory=lambda: np.zeros(0))
    remark: str = ""


def elements_of(effect: Effect, model: CorrectedModel, *, major: int) -> Elements | None:
    """The elements that stand for an effect in MuJoCo of a major version; None: there are none, its law must be called."""
    maker = (_IN_SPACE if model.columns.space else _MAKERS).get(effect.name)
    return None if maker is None else maker(effect, model, major)


def _backlash(effect: Any, model: CorrectedModel, major: int) -> Elements:
    links = model.arm.links
    springs = model.columns.arrays.spring[0]
    dead = effect.gap / 2 / links
    strands = tuple(Strand(f"play_{i + 1}", i + 1, float(k), dead=dead) for i, k in enumerate(springs))
    return Elements(strands, springless=True, remark="springs with a dead band")


def _bending_stop(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    if effect.side != "both":
        return None
    links, keq = model.arm.links, model.arm.keq
    k, dead = links * keq * effect.ratio, effect.angle / links
    strands = tuple(Strand(f"stop_{i + 1}", i + 1, k, dead=dead) for i in range(links))
    return Elements(strands, stiffest=np.full(links, k), remark="further springs with a dead band")


def _dry_friction(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    if major < 4 or effect.form != "even":
        return None
    links, keq, give = model.arm.links, model.arm.keq, presliding(effect.level)
    return _sliders(model, [("friction", links * keq * effect.level / give, give / links)], "springs that yield")


def _hysteresis(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    if major < 4 or effect.form != "maxwell_slip":
        return None
    links, keq = model.arm.links, model.arm.keq
    k = links * keq * effect.amplitude / effect.yield_angle / len(SLIDERS)
    rows = [(f"slider_{n + 1}", k, slip * effect.yield_angle / links) for n, slip in enumerate(SLIDERS)]
    return _sliders(model, rows, "springs that yield, one by one")


def _sliders(model: CorrectedModel, rows: list[tuple[str, float, float]], remark: str) -> Elements:
    links = model.arm.links
    strands = tuple(Strand(f"{name}_{i + 1}", i + 1, float(k), yields=float(y)) for name, k, y in rows for i in range(links))
    return Elements(strands, stiffest=np.full(links, sum(k for _, k, _ in rows)), remark=remark)


def _stiffening(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    last = np.sqrt((SOFTEST if effect.cubic < 0 else STIFFEST) / (3 * max(abs(effect.cubic), 1e-9)))
    if major < 4 or last < model.arm.bending_limit:  # beyond, the law goes on as a straight line, and no polynomial does
        return None
    links = model.arm.links
    spring = model.columns.arrays.keq[0] * model.columns.arrays.profile[0]
    rise = np.maximum(3 * links * spring * effect.cubic * model.arm.bending_limit**2, 0.0)
    return Elements(cubic=links**3 * spring * effect.cubic, stiffest=rise, remark="cubic springs")


def _preset_bend(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    if model.effect("backlash") or model.effect("stiffening"):  # their springs are counted from the straight arm
        return None
    return Elements(ease=float(effect.angle) / model.arm.links, remark="the angle at which the springs are at ease")


def _quadratic_damping(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    if major < 4:
        return None
    links = model.arm.links
    remark = f"quadratic dampers (the law itself goes on as a straight line beyond {FASTEST:g} rad/s of bending)"
    return Elements(quadratic=np.full(links, links**2 * effect.coefficient), remark=remark)


def _bend_at_rest(effect: Any, model: CorrectedModel, major: int) -> Elements:
    bend = complex(effect.angle) if effect.name == "preset_bend" else complex(effect.towards_x, effect.towards_y)
    return Elements(ease=bend / model.arm.links, remark="the angles at which the springs are at ease")


def _unequal_stiffness(effect: Any, model: CorrectedModel, major: int) -> Elements:
    """Equal springs of the softest stiffness, and what there is more towards the stiffest side."""
    more = complex(effect.along_x, effect.diagonal)
    way = np.exp(0.5j * np.angle(more))
    springs = model.columns.arrays.keq[0] * model.arm.links * model.columns.arrays.profile[0]
    strands = tuple(
        Strand(f"stiffer_{i + 1}", i + 1, float(2 * abs(more) * k), pulls=(float(way.real), float(way.imag)))
        for i, k in enumerate(springs)
    )
    return Elements(
        strands, soft=1 - abs(more), stiffest=2 * abs(more) * springs, remark="further springs towards the stiffest side"
    )


_MAKERS: dict[str, Callable[[Any, CorrectedModel, int], Elements | None]] = {
    "backlash": _backlash,
    "bending_stop": _bending_stop,
    "dry_friction": _dry_friction,
    "hysteresis": _hysteresis,
    "preset_bend": _preset_bend,
    "quadratic_damping": _quadratic_damping,
    "stiffening": _stiffening,
}
_IN_SPACE: dict[str, Callable[[Any, CorrectedModel, int], Elements | None]] = {
    "bend_at_rest": _bend_at_rest,
    "preset_bend": _bend_at_rest,
    "unequal_stiffness": _unequal_stiffness,
}

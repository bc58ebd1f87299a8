"""Representation of effects of an arm by MuJoCo elements.

MuJoCo 4 has polynomial springs and dampers, springs that yield (ideal elasto-plasticity), and actuators with a delay; MuJoCo 3
has none of these. In both versions, springs with a dead band are fixed tendons, one for each joint.

In space a joint consists of two hinges. Elements that act on each hinge separately represent a law about two axes only if the law
is linear. All other laws are called from the module.
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
    """Spring on one joint, represented by a fixed tendon.

    Attributes:
        name: name of the tendon.
        joint: number of the joint, from 1.
        stiffness: stiffness [Nm/rad].
        dead: half-width of the dead band [rad].
        yields: largest elastic stretch [rad]; 0: unlimited.
        pulls: coefficients of the joint's hinges in its stretch.
    """

    name: str
    joint: int
    stiffness: float
    dead: float = 0.0
    yields: float = 0.0
    pulls: tuple[float, ...] = (1.0,)


@dataclass(frozen=True, eq=False)
class Elements:
    """MuJoCo elements of an effect in addition to the linear springs and dampers of the joints.

    Attributes:
        strands: separate springs.
        springless: whether the strands replace the springs of the joints.
        cubic: (N,) cubic stiffness of the springs of the joints [Nm/rad^3].
        quadratic: (N,) quadratic damping of the dampers of the joints [Nm s^2/rad^2].
        equilibrium: equilibrium angle of the springs of the joints [rad]; in space complex, towards x and towards y.
        soft: factor on the springs of the joints.
        stiffest: (N,) largest additional stiffness of the joints due to the elements [Nm/rad].
        remark: description of the elements.
    """

    strands: tuple[Strand, ...] = ()
    springless: bool = False
    cubic: Array = field(default_factory=lambda: np.zeros(0))
    quadratic: Array = field(default_factory=lambda: np.zeros(0))
    equilibrium: complex = 0.0
    soft: float = 1.0
    stiffest: Array = field(default_factory=lambda: np.zeros(0))
    remark: str = ""


def elements_of(effect: Effect, model: CorrectedModel, *, major: int) -> Elements | None:
    """Return the elements that represent an effect in a major version of MuJoCo; None if its law must be called instead."""
    maker = (_IN_SPACE if model.batch.space else _MAKERS).get(effect.name)
    return None if maker is None else maker(effect, model, major)


def _backlash(effect: Any, model: CorrectedModel, major: int) -> Elements:
    links = model.arm.links
    springs = model.batch.arrays.spring[0]
    dead = effect.gap / 2 / links
    strands = tuple(Strand(f"play_{i + 1}", i + 1, float(k), dead=dead) for i, k in enumerate(springs))
    return Elements(strands, springless=True, remark="springs with a dead band")


def _bending_stop(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    if effect.side != "both":
        return None
    links, keq = model.arm.links, model.arm.keq
    k, dead = links * keq * effect.ratio, effect.angle / links
    strands = tuple(Strand(f"stop_{i + 1}", i + 1, k, dead=dead) for i in range(links))
    return Elements(strands, stiffest=np.full(links, k), remark="additional springs with a dead band")


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
    return _sliders(model, rows, "springs that yield at different angles")


def _sliders(model: CorrectedModel, rows: list[tuple[str, float, float]], remark: str) -> Elements:
    links = model.arm.links
    strands = tuple(Strand(f"{name}_{i + 1}", i + 1, float(k), yields=float(y)) for name, k, y in rows for i in range(links))
    return Elements(strands, stiffest=np.full(links, sum(k for _, k, _ in rows)), remark=remark)


def _stiffening(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    last = np.sqrt((SOFTEST if effect.cubic < 0 else STIFFEST) / (3 * max(abs(effect.cubic), 1e-9)))
    if major < 4 or last < model.arm.bending_limit:  # beyond this angle the law is linear, which no polynomial represents
        return None
    links = model.arm.links
    spring = model.batch.arrays.keq[0] * model.batch.arrays.profile[0]
    rise = np.maximum(3 * links * spring * effect.cubic * model.arm.bending_limit**2, 0.0)
    return Elements(cubic=links**3 * spring * effect.cubic, stiffest=rise, remark="cubic springs")


def _preset_bend(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    if model.effect("backlash") or model.effect("stiffening"):  # their springs refer to the straight arm
        return None
    return Elements(equilibrium=float(effect.angle) / model.arm.links, remark="equilibrium angle of the springs")


def _quadratic_damping(effect: Any, model: CorrectedModel, major: int) -> Elements | None:
    if major < 4:
        return None
    links = model.arm.links
    remark = f"quadratic dampers (the law itself is linear beyond {FASTEST:g} rad/s of bending)"
    return Elements(quadratic=np.full(links, links**2 * effect.coefficient), remark=remark)


def _bend_at_rest(effect: Any, model: CorrectedModel, major: int) -> Elements:
    bend = complex(effect.angle) if effect.name == "preset_bend" else complex(effect.towards_x, effect.towards_y)
    return Elements(equilibrium=bend / model.arm.links, remark="equilibrium angles of the springs")


def _unequal_stiffness(effect: Any, model: CorrectedModel, major: int) -> Elements:
    """Return equal springs with the smallest stiffness, and additional springs towards the stiffest side."""
    more = complex(effect.along_x, effect.diagonal)
    way = np.exp(0.5j * np.angle(more))
    springs = model.batch.arrays.keq[0] * model.arm.links * model.batch.arrays.profile[0]
    strands = tuple(
        Strand(f"stiffer_{i + 1}", i + 1, float(2 * abs(more) * k), pulls=(float(way.real), float(way.imag)))
        for i, k in enumerate(springs)
    )
    return Elements(
        strands, soft=1 - abs(more), stiffest=2 * abs(more) * springs, remark="additional springs towards the stiffest side"
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

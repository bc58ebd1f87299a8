"""The energy account of a motion: what a passive arm holds, less what the torque brought in, never rises."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect, middles
from hsr_pin.errors import InputError
from hsr_pin.robot.chain import chain_of
from hsr_pin.simulation.columns import Columns
from hsr_pin.simulation.command import deliver
from hsr_pin.simulation.integrator import TOLERANCE
from hsr_pin.simulation.reference import touched
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Array, Trajectory

#: A rise by more than this share of the energy that moves is none that a tolerance explains.
SUSPICIOUS = 0.05
#: A tip that moves by less than so many times the default tolerance of a step moves too little for its energy to be judged.
_SMALL = 100
#: Gauss-Legendre points on [0, 1] over which a law's moment is integrated from sample to sample.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(32)
_POINTS, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies of an arm at the samples, (T,) [J] each.

    Attributes:
        kinetic: of the links.
        stored: in gravity, springs and laws, from the straight arm.
        work: of the torque since the start.
        least: [J] that the springs hold when the tip is moved so little that a tolerance is a good part of it.
    """

    kinetic: Array
    stored: Array
    work: Array
    least: float

    @property
    def account(self) -> Array:
        """(T,) [J] what is not lost yet; it never rises where all laws are passive."""
        return self.kinetic + self.stored - self.work

    @property
    def rise(self) -> float:
        """Largest rise of the account, over the largest kinetic energy, all that was lost, or ``least``, whichever is most."""
        account = self.account
        rise = (account - np.minimum.accumulate(account)).max()
        return float(rise / max(self.kinetic.max(), account[0] - account.min(), self.least))


def energy(scenario: Scenario, motion: Trajectory) -> Energy:
    """The account of a simulated motion of a scenario.

    Raises:
        InputError: an effect remembers (what it stores cannot be told from the motion), or the torque is not even from sample to
            sample.
    """
    if unknown := untold(scenario):
        raise InputError("energy", expected="effects without memory under a held command", received=unknown)
    columns = Columns.of([scenario])
    q, v = motion.joint_angles, motion.joint_rates
    assert q is not None and v is not None  # of a simulation
    least = scenario.arm.keq * (_SMALL * TOLERANCE / scenario.arm.length) ** 2 / 2
    if columns.space:
        return _in_space(scenario, columns, q, v, least)
    start: Any = scenario.start.torque if isinstance(scenario.start, Settled) else scenario.torque[0]
    with np.errstate(over="ignore", invalid="ignore"):  # a torque that no arm bears
        given = _arriving(columns, scenario, scenario.torque, start)[: len(q) - 1]
        brought = given * (np.diff(q, axis=0) @ columns.arrays.share[0])
    arrays, chain = columns.arrays, chain_of(columns.arms)
    theta, omega = q.cumsum(axis=1), v.cumsum(axis=1)
    ahead = np.stack([np.cos(theta), np.sin(theta)])
    turning = np.stack([-ahead[1], ahead[0]]) * omega
    places, speeds = ((part * chain.reach).cumsum(axis=2) + part * (chain.lever - chain.reach) for part in (ahead, turning))
    kinetic = (chain.mass * (speeds**2).sum(axis=0) + chain.inertia * omega**2).sum(axis=1) / 2
    springs = (arrays.spring * q**2).sum(axis=1) / 2 + sum(_stored(columns, law, q) for law in columns.laws)
    height = (chain.mass * (chain.gravity[0] @ places.swapaxes(0, 1).reshape(len(q), 2, -1))).sum(axis=1)
    return Energy(kinetic, springs - height, np.append(0.0, brought.cumsum()), least)


def _arriving(columns: Columns, scenario: Scenario, torque: Array, start: complex) -> Array:
    """(T - 1,) [N m] the mean of what arrives between the samples."""
    return np.asarray(np.diff(deliver(columns, torque[:, None], np.array([start]), scenario.step).impulse[0]))


def _in_space(scenario: Scenario, columns: Columns, q: Array, v: Array, least: float) -> Energy:
    from hsr_pin.simulation.space.account import kinetic_and_height, twisting, work_of_loads

    bends = q[:, :, 0] + 1j * q[:, :, 1]
    kinetic, height = kinetic_and_height(columns, q, v)
    springs = (columns.arrays.spring * np.abs(bends) ** 2).sum(axis=1) / 2 + twisting(columns, q)
    springs = springs + sum(_stored(columns, law, bends) for law in columns.laws)
    ways = (np.diff(bends, axis=0) * columns.arrays.share[0]) @ columns.arrays.inputs
    brought = work_of_loads(scenario, columns, q)
    for section, start in enumerate(scenario.held_under):
        given = _arriving(columns, scenario, scenario.command[:, section], start)[: len(q) - 1]
        brought = brought + (given.conj() * ways[:, section]).real
    return Energy(kinetic, springs + height, np.append(0.0, brought.cumsum()), least)


def untold(scenario: Scenario) -> str:
    """What keeps the account of a scenario from being told; empty if nothing does."""
    remembering = [effect.name for effect in scenario.effects if effect.states or effect.memories or effect.acts_through("late")]
    turned = any(np.any(np.asarray(load.moment)) for load in scenario.loads)  # whose work is none of the samples'
    return ", ".join(remembering) or ("an interpolated command" if scenario.interpolated else "moments of loads" * turned)


def _stored(columns: Columns, law: Effect, q: Array) -> Array:
    """(T,) [J] the work of a law's moment, at rest, on the way from the straight arm to q (T, N), in space complex."""
    total, links = np.zeros(len(q)), columns.links
    for point, weight in zip(_POINTS, _WEIGHTS, strict=True):
        bending = Bending(point * links * q, 0.0 * q, columns.arms.keq[:, None], columns.arrays.profile, middles(links), ())
        resisting = law.moment(law.p, bending)
        if law.acts_through("touch"):
            resisting = resisting + touched(law, point * q, columns.arrays.reach)
        total += weight * (np.conj(resisting) * q).sum(axis=1).real
    return total

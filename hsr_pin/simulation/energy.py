"""The energy balance of a motion: the energy of a passive arm, minus the work of the torque, never increases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from hsr_pin.effects.effect import Bending, Effect, middles
from hsr_pin.errors import InputError
from hsr_pin.robot.chain import chain_of
from hsr_pin.simulation.arm_batch import ArmBatch
from hsr_pin.simulation.command import deliver
from hsr_pin.simulation.contact import POSES, START, elastic_energy, poses_in_plane, poses_in_space
from hsr_pin.simulation.integrator import TOLERANCE
from hsr_pin.simulation.reference import contact_moments
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Array, Trajectory

#: Largest relative increase of the balance that the integration tolerance can explain.
SUSPICIOUS = 0.05
#: A tip that moves by less than this multiple of the default tolerance moves too little to judge its energy.
_SMALL = 100
#: Gauss-Legendre points on [0, 1] for the integral of a law's moment along the straight path to a pose.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(32)
_POINTS, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies of an arm at the samples, (T,) [J] each.

    Attributes:
        kinetic: kinetic energy of the links.
        stored: potential energy in gravity, springs, laws and contacts, relative to the straight arm.
        work: work of the torque since the start.
        least: energy of the springs at a displacement for which the tolerance is a considerable share [J].
    """

    kinetic: Array
    stored: Array
    work: Array
    least: float

    @property
    def account(self) -> Array:
        """Energy that is not dissipated yet (T,) [J]; it never increases if all laws are passive."""
        return self.kinetic + self.stored - self.work

    @property
    def rise(self) -> float:
        """Largest increase of the balance, relative to the energy of the motion.

        The energy of the motion is the largest of the kinetic energy, the dissipated energy and ``least``.
        """
        account = self.account
        rise = (account - np.minimum.accumulate(account)).max()
        return float(rise / max(self.kinetic.max(), account[0] - account.min(), self.least))


def energy(scenario: Scenario, motion: Trajectory) -> Energy:
    """Return the energy balance of a simulated motion of a scenario.

    Raises:
        InputError: an effect has a memory (the motion does not determine its stored energy), or the torque is not constant
            between samples.
    """
    if unknown := energy_obstacle(scenario):
        raise InputError("energy", expected="effects without memory under a held command", received=unknown)
    batch = ArmBatch.of([scenario])
    q, v = motion.joint_angles, motion.joint_rates
    assert q is not None and v is not None  # always present in a simulated motion
    least = scenario.arm.keq * (_SMALL * TOLERANCE / scenario.arm.length) ** 2 / 2
    touching = _in_contacts(batch, q) if batch.world.shape[1] else 0.0
    if batch.space:
        return _in_space(scenario, batch, q, v, least, touching)
    start: Any = scenario.start.torque if isinstance(scenario.start, Settled) else scenario.torque[0]
    with np.errstate(over="ignore", invalid="ignore"):  # excessive torque
        given = _arriving(batch, scenario, scenario.torque, start)[: len(q) - 1]
        brought = given * (np.diff(q, axis=0) @ batch.arrays.share[0])
    arrays, chain = batch.arrays, chain_of(batch.arms)
    theta, omega = q.cumsum(axis=1), v.cumsum(axis=1)
    ahead = np.stack([np.cos(theta), np.sin(theta)])
    turning = np.stack([-ahead[1], ahead[0]]) * omega
    places, speeds = ((part * chain.reach).cumsum(axis=2) + part * (chain.lever - chain.reach) for part in (ahead, turning))
    kinetic = (chain.mass * (speeds**2).sum(axis=0) + chain.inertia * omega**2).sum(axis=1) / 2
    springs = (arrays.spring * q**2).sum(axis=1) / 2 + sum(_stored(batch, law, q) for law in batch.laws)
    height = (chain.mass * (chain.gravity[0] @ places.swapaxes(0, 1).reshape(len(q), 2, -1))).sum(axis=1)
    return Energy(kinetic, springs + touching - height, np.append(0.0, brought.cumsum()), least)


def _arriving(batch: ArmBatch, scenario: Scenario, torque: Array, start: complex) -> Array:
    """Return the mean torque that arrives in each sampling interval, (T - 1,) [N m]."""
    return np.asarray(np.diff(deliver(batch, torque[:, None], np.array([start]), scenario.step).impulse[0]))


def _in_space(scenario: Scenario, batch: ArmBatch, q: Array, v: Array, least: float, touching: Any) -> Energy:
    from hsr_pin.simulation.space.account import kinetic_and_height, twisting, work_of_loads

    bends = q[:, :, 0] + 1j * q[:, :, 1]
    kinetic, height = kinetic_and_height(batch, q, v)
    springs = (batch.arrays.spring * np.abs(bends) ** 2).sum(axis=1) / 2 + twisting(batch, q)
    springs = springs + sum(_stored(batch, law, bends) for law in batch.laws)
    ways = (np.diff(bends, axis=0) * batch.arrays.share[0]) @ batch.arrays.inputs
    brought = work_of_loads(scenario, batch, q)
    for section, start in enumerate(scenario.initial_torque):
        given = _arriving(batch, scenario, scenario.command[:, section], start)[: len(q) - 1]
        brought = brought + (given.conj() * ways[:, section]).real
    return Energy(kinetic, springs + touching + height, np.append(0.0, brought.cumsum()), least)


def energy_obstacle(scenario: Scenario) -> str:
    """Return the reason why a scenario has no energy balance; an empty text if it has one."""
    remembering = [
        effect.name for effect in scenario.effects if effect.states or effect.memories or effect.acts_through("command_delay")
    ]
    if ArmBatch.of([scenario]).touch[2] >= 0:
        remembering.append("friction with obstacles")
    turned = any(np.any(np.asarray(load.moment)) for load in scenario.loads)  # their work does not follow from the samples
    return ", ".join(remembering) or ("an interpolated command" if scenario.interpolated else "moments of loads" * turned)


def _in_contacts(batch: ArmBatch, q: Array) -> Array:
    """Return the elastic energy of contacts with obstacles (T,) [J]."""
    g, reach, world, points = np.empty((POSES, batch.links)), batch.arrays.reach[0], batch.world[0], int(batch.touch[3])
    poses, found = poses_in_space if batch.space else poses_in_plane, np.zeros(len(q))
    for t, pose in enumerate(q.reshape(len(q), -1)):
        poses(pose, np.zeros_like(pose), world[0, START], reach, g)
        found[t] = elastic_energy(g, reach, world, points)
    return found


def _stored(batch: ArmBatch, law: Effect, q: Array) -> Array:
    """Return the work (T,) [J] of a law's moment, quasi-statically, from the straight arm to q (T, N), complex in space."""
    total, links = np.zeros(len(q)), batch.links
    for point, weight in zip(_POINTS, _WEIGHTS, strict=True):
        bending = Bending(point * links * q, 0.0 * q, batch.arms.keq[:, None], batch.arrays.profile, middles(links), ())
        resisting = law.moment(law.p, bending)
        if law.acts_through("contact_force"):
            resisting = resisting + contact_moments(law, point * q, batch.arrays.reach)
        total += weight * (np.conj(resisting) * q).sum(axis=1).real
    return total

"""Simulate many scenarios at once, each with the same result as on its own."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from functools import partial

import numpy as np

from hsr_pin.simulation.arm_batch import ArmBatch, batch_key
from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.integrator import TOLERANCE, Integrator
from hsr_pin.simulation.motion import Dynamics, Engine, Motion
from hsr_pin.simulation.result import Outcome, SimulationResult, furthest_joint, reason_of
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.trajectory import Array, Trajectory


def simulate_batch(
    scenarios: Sequence[Scenario],
    *,
    dynamics: Dynamics = "compiled",
    integrator: str | None = None,
    tolerance: float = TOLERANCE,
    step: float | None = None,
    threads: int = 1,
) -> list[SimulationResult]:
    """Simulate many scenarios; a failed scenario is marked in its result and does not affect the others.

    Args:
        scenarios: any mixture of arms, effects, inputs, initial states and durations.
        dynamics: "compiled", or "aba" or "rnea" with Pinocchio.
        integrator: a name from ``hsr_pin.simulation.integrator``; default: the method that suits each arm.
        tolerance: largest error of a step, at the tip [m].
        step: largest step length [s], used instead of a tolerance; the steps divide the sampling interval evenly.
        threads: number of threads among which the scenarios are divided; the compiled loops run in parallel.

    Returns:
        One result per scenario, in the order of the scenarios; each is identical to that of the scenario simulated alone (with
        obstacles up to the tolerance of the initial equilibrium).
    """
    method = Integrator(integrator, tolerance, step)
    groups: dict[object, list[int]] = defaultdict(list)
    for index, scenario in enumerate(scenarios):
        groups[batch_key(scenario), len(scenario.time), scenario.step, scenario.interpolated].append(index)
    results: dict[int, SimulationResult] = {}
    for members, batch in _of_one_method(scenarios, groups.values()):
        group = [scenarios[i] for i in members]
        motion = simulate_together(group, batch, method, dynamics, separately=True, threads=threads)
        beside = [scenario.beside for scenario in group] if batch.space else 0.0
        positions = Cameras(batch, [scenario.reach for scenario in group], beside).positions(motion.angles)
        results.update((i, result_of(scenarios[i], motion, positions, b)) for b, i in enumerate(members))
    return [results[i] for i in range(len(scenarios))]


def _of_one_method(scenarios: Sequence[Scenario], groups: Iterable[list[int]]) -> Iterator[tuple[list[int], ArmBatch]]:
    """Yield the groups and their batches, with lightly damped arms in batches of their own."""
    for members in groups:
        batch = ArmBatch.of([scenarios[i] for i in members])
        for same_method in (batch.ringing, ~batch.ringing):
            if same_method.all():
                yield members, batch
            elif same_method.any():
                yield [members[i] for i in np.flatnonzero(same_method)], batch.members(same_method)


def simulate_together(
    scenarios: Sequence[Scenario],
    batch: ArmBatch,
    method: Integrator,
    dynamics: Dynamics,
    *,
    separately: bool = False,
    threads: int = 1,
) -> Motion:
    """Return the motions of scenarios with the same sample times.

    All scenarios use the step lengths of the first one, or (``separately``) each has its own.
    """
    first, engine = scenarios[0], Engine(batch, dynamics)
    deliver = partial(engine.deliver, step=first.step, interpolated=first.interpolated, substeps=method.substeps(first.step))
    command = deliver(np.array([s.command for s in scenarios]).swapaxes(0, 1), np.array([s.initial_torque for s in scenarios]))
    if batch.points is not None:
        from hsr_pin.simulation.space.drive import with_loads

        command = with_loads(batch, scenarios, command)
    q, v = np.zeros((2, len(batch), batch.coordinates))
    wanted = np.array([isinstance(s.start, Settled) for s in scenarios])
    for b, s in enumerate(scenarios):
        if isinstance(s.start, Pose):
            q[b], v[b] = s.start.angles.ravel(), np.asarray(s.start.rates).ravel()
        elif s.start.near is not None:
            q[b] = s.start.near.ravel()
    if wanted.any():
        rests, found = engine.settled(command.initial, wanted, q)
        q = np.where(wanted[:, None], rests, q)
    else:
        found = wanted
    given = engine.loaded(q, v), command, len(first.time), method, found | ~wanted
    return engine.run_separately(*given, threads) if separately else engine.run(*given)


def result_of(scenario: Scenario, motion: Motion, positions: Array, index: int) -> SimulationResult:
    """Return the result of one scenario of a motion, given the marker positions (S, B, M, 3) [m] of the batch."""
    count, outcome, joint, time = len(scenario.time), Outcome.COMPLETED, None, None
    if np.isfinite(motion.lost[index]):
        elapsed = float(motion.lost[index])
        count = max(1, int(np.ceil(elapsed / scenario.step - 1e-9)))
        last = motion.beyond[index].reshape(scenario.arm.links, -1)
        # an arm without an equilibrium is left straight
        no_equilibrium = elapsed == 0 and np.linalg.norm(last[:, :2].sum(axis=0)) <= scenario.arm.bending_limit
        last = np.linalg.norm(last, axis=1)
        outcome = Outcome.NO_EQUILIBRIUM if no_equilibrium else reason_of(last)
        joint, time = furthest_joint(last), float(scenario.time[0] + elapsed)
    shape = (count, scenario.arm.links, 3) if scenario.arm.bending == "space" else (count, scenario.arm.links)
    trajectory = Trajectory(
        time=scenario.time[:count],
        markers=scenario.markers,
        positions=positions[:count, index],
        torque=scenario.torque[:count],
        joint_angles=motion.angles[:count, index].reshape(shape),
        joint_rates=motion.rates[:count, index].reshape(shape),
    )
    return SimulationResult(scenario, trajectory, outcome, time, joint)

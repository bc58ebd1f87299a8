"""Many scenarios at once, each as it would be alone."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from functools import partial

import numpy as np

from hsr_pin.simulation.cameras import Cameras
from hsr_pin.simulation.columns import Columns, likeness
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
    """Simulate scenarios; a failed one is marked in its result and does not touch the others.

    Args:
        scenarios: any mixture of arms, effects, inputs, starts and lengths.
        dynamics: "compiled", or "aba" or "rnea" over Pinocchio.
        integrator: a name from ``hsr_pin.simulation.integrator``; default: what suits each arm.
        tolerance: [m] of the tip, that a step may be in error by.
        step: [s] steps of at most this length in place of a tolerance; they divide the samples evenly.
        threads: to share the scenarios between; the compiled loops run side by side.

    Returns:
        One result per scenario, in their order. Each is what the scenario gives alone.
    """
    method = Integrator(integrator, tolerance, step)
    groups: dict[object, list[int]] = defaultdict(list)
    for index, scenario in enumerate(scenarios):
        groups[likeness(scenario), len(scenario.time), scenario.step, scenario.interpolated].append(index)
    results: dict[int, SimulationResult] = {}
    for members, columns in _of_one_method(scenarios, groups.values()):
        group = [scenarios[i] for i in members]
        motion = moved(group, columns, method, dynamics, apart=True, threads=threads)
        beside = [scenario.beside for scenario in group] if columns.space else 0.0
        positions = Cameras(columns, [scenario.reach for scenario in group], beside).positions(motion.angles)
        results.update((i, result_of(scenarios[i], motion, positions, b)) for b, i in enumerate(members))
    return [results[i] for i in range(len(scenarios))]


def _of_one_method(scenarios: Sequence[Scenario], groups: Iterable[list[int]]) -> Iterator[tuple[list[int], Columns]]:
    """The groups and their columns, those that hardly anything damps apart from the others."""
    for members in groups:
        columns = Columns.of([scenarios[i] for i in members])
        for alike in (columns.ringing, ~columns.ringing):
            if alike.all():
                yield members, columns
            elif alike.any():
                yield [members[i] for i in np.flatnonzero(alike)], columns.members(alike)


def moved(
    scenarios: Sequence[Scenario],
    columns: Columns,
    method: Integrator,
    dynamics: Dynamics,
    *,
    apart: bool = False,
    threads: int = 1,
) -> Motion:
    """The motions of scenarios with the same times, all with the steps of the first, or (``apart``) each with its own."""
    first, engine = scenarios[0], Engine(columns, dynamics)
    deliver = partial(engine.deliver, step=first.step, interpolated=first.interpolated, substeps=method.substeps(first.step))
    command = deliver(np.array([s.command for s in scenarios]).swapaxes(0, 1), np.array([s.held_under for s in scenarios]))
    if columns.points is not None:
        from hsr_pin.simulation.space.drive import with_loads

        command = with_loads(columns, scenarios, command)
    q, v = np.zeros((2, len(columns), columns.coordinates))
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
    return engine.run_apart(*given, threads) if apart else engine.run(*given)


def result_of(scenario: Scenario, motion: Motion, positions: Array, column: int) -> SimulationResult:
    """One column of a motion, with the positions (S, B, M, 3) [m] of its markers."""
    count, outcome, joint, time = len(scenario.time), Outcome.COMPLETED, None, None
    if np.isfinite(motion.lost[column]):
        elapsed = float(motion.lost[column])
        count = max(1, int(np.ceil(elapsed / scenario.step - 1e-9)))
        last = motion.beyond[column].reshape(scenario.arm.links, -1)
        # where there is no rest, the arm is left straight
        nowhere = elapsed == 0 and np.linalg.norm(last[:, :2].sum(axis=0)) <= scenario.arm.bending_limit
        last = np.linalg.norm(last, axis=1)
        outcome = Outcome.NO_EQUILIBRIUM if nowhere else reason_of(last)
        joint, time = furthest_joint(last), float(scenario.time[0] + elapsed)
    shape = (count, scenario.arm.links, 3) if scenario.arm.bending == "space" else (count, scenario.arm.links)
    trajectory = Trajectory(
        time=scenario.time[:count],
        markers=scenario.markers,
        positions=positions[:count, column],
        torque=scenario.torque[:count],
        joint_angles=motion.angles[:count, column].reshape(shape),
        joint_rates=motion.rates[:count, column].reshape(shape),
    )
    return SimulationResult(scenario, trajectory, outcome, time, joint)

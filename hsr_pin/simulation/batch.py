"""Many scenarios at once: grouped by shape, each group stepped side by side."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from hsr_pin.effects.effect import View
from hsr_pin.robot.kinematics import marker_map
from hsr_pin.robot.model import rigid_body
from hsr_pin.simulation.columns import Columns, Shape, arm_of, shape_of
from hsr_pin.simulation.forward import ForwardDynamics, forward_dynamics
from hsr_pin.simulation.integrators import Integrator
from hsr_pin.simulation.integrators import integrator as integrator_named
from hsr_pin.simulation.result import Outcome, SimulationResult
from hsr_pin.simulation.scenario import Pose, Scenario
from hsr_pin.simulation.statics import equilibrium
from hsr_pin.trajectory import Array, Trajectory

#: Default largest step [s]: with the default integrator the tip is within 0.05 mm of the chain's exact motion for N = 4 to 32.
STEP = 0.01


def simulate_batch(
    scenarios: Sequence[Scenario],
    *,
    dynamics: str = "aba",
    integrator: str = "extrapolated4",
    step: float = STEP,
    threads: int = 1,
) -> list[SimulationResult]:
    """Simulate scenarios side by side; a failed one is marked in its result and does not touch the others.

    Args:
        scenarios: any mixture of arms, effects, inputs, starts and lengths.
        dynamics: "aba" or "rnea".
        integrator: a name from ``hsr_pin.simulation.integrators``.
        step: largest step [s]; the steps divide the samples evenly, so that a held input changes on step boundaries.
        threads: for the dynamics; more than one pays for hundreds of columns on an idle machine.

    Returns:
        One result per scenario, in their order. Each is what the scenario gives alone.
    """
    method = integrator_named(integrator)
    groups: dict[Shape, list[int]] = defaultdict(list)
    for index, scenario in enumerate(scenarios):
        groups[shape_of(scenario, step)].append(index)
    results: dict[int, SimulationResult] = {}
    for shape, members in groups.items():
        members.sort(key=lambda i: hash(rigid_body(arm_of(scenarios[i]))))
        columns = Columns([scenarios[i] for i in members], shape)
        results.update(zip(members, _run(columns, method, dynamics, threads), strict=True))
    return [results[i] for i in range(len(scenarios))]


class _Step:
    """The equations of motion during one step: the drive and the laws' states are those at its beginning."""

    def __init__(self, columns: Columns, forward: ForwardDynamics) -> None:
        self._columns, self._forward = columns, forward
        self.stiffness, self.damping = columns.stiffness, columns.damping

    def begin(self, drive: Array, states: tuple[Array, ...], start: Array) -> None:
        self._drive, self._states, self._start = drive, states, start

    def solve(self, slot: int, q: Array, v: Array, elapsed: float, shift: Array) -> Array:
        states = self._states
        if states and elapsed > 0:
            states = self._columns.update(states, self._start, q, elapsed)
        return self._forward.solve(slot, q, v, self._columns.torque(q, v, states) + self._drive - shift)


def _run(columns: Columns, method: Integrator, dynamics: str, threads: int) -> list[SimulationResult]:
    step, substeps = columns.step, columns.shape.substeps
    armatures = [d * columns.damping[:, 0] + d * d * columns.stiffness[:, 0] for d in method.lengths(step)]
    models = [arm.model for arm in columns.arm_models]
    chain = _Step(columns, forward_dynamics(dynamics, models, armatures, threads))
    torques = columns.torques()
    q, v, states, found = _start(columns)
    failures = {int(b): (0, Outcome.NO_EQUILIBRIUM, 1) for b in np.flatnonzero(~found)}
    limit = np.array([arm.bending_limit for arm in columns.arms])
    samples = len(torques) // substeps + 1
    angles, rates = (np.empty((samples, len(models), columns.shape.links)) for _ in range(2))
    angles[0], rates[0] = q.T, v.T
    alive = np.array(found, dtype=bool)
    for n, torque in enumerate(torques):
        chain.begin(np.asfortranarray(columns.drive * torque), states, q)
        q_next, v_next = method.advance(chain, q, v, step)
        states = columns.update(states, q, q_next, step)
        q, v = q_next, v_next
        inside = np.asarray(np.abs(q.sum(axis=0)) <= limit, dtype=bool)
        if not (inside | ~alive).all():
            for b in np.flatnonzero(~inside & alive):
                failures[int(b)] = (n + 1, *_failure(q[:, b]))
            alive &= inside
        if failures:
            q[:, ~alive], v[:, ~alive] = 0.0, 0.0
            states = tuple(np.where(alive, state, 0.0) for state in states)
        if (n + 1) % substeps == 0:
            angles[(n + 1) // substeps], rates[(n + 1) // substeps] = q.T, v.T
    return _results(columns, angles, rates, failures)


def _start(columns: Columns) -> tuple[Array, Array, tuple[Array, ...], Array]:
    """Angles, rates (N, B), internal states, and (B,) whether there is a start."""
    q, states, found = equilibrium(columns, columns.settled_torques())
    v = np.zeros_like(q)
    posed = np.array([isinstance(scenario.start, Pose) for scenario in columns.scenarios])
    if posed.any():
        for b in np.flatnonzero(posed):
            start = columns.scenarios[b].start
            assert isinstance(start, Pose)
            q[:, b], v[:, b] = start.angles, start.rates
        states = columns.update(columns.virgin_states(), 0 * q, q, np.inf)
        found = found | posed
    return q, v, states, found


def _failure(q: Array) -> tuple[Outcome, int]:
    finite = np.isfinite(q)
    if not finite.all():
        return Outcome.DIVERGED, int(np.argmin(finite)) + 1
    outcome = Outcome.DIVERGED if np.abs(q).max() > 4 * np.pi else Outcome.BENDING_LIMIT
    return outcome, int(np.argmax(np.abs(q))) + 1


def _results(
    columns: Columns, angles: Array, rates: Array, failures: dict[int, tuple[int, Outcome, int]]
) -> list[SimulationResult]:
    positions = _positions(columns, angles)
    results = []
    for b, scenario in enumerate(columns.scenarios):
        stop, outcome, joint = failures.get(b, (None, Outcome.COMPLETED, None))
        count = len(scenario.time)
        if stop is not None:
            if stop > (count - 1) * columns.shape.substeps:  # it failed while the longer columns went on
                stop, outcome, joint = None, Outcome.COMPLETED, None
            else:
                count = max(1, -(-stop // columns.shape.substeps))
        trajectory = Trajectory(
            time=scenario.time[:count],
            markers=scenario.markers,
            positions=positions[b][:count],
            torque=scenario.torque[:count],
            joint_angles=angles[:count, b],
            joint_rates=rates[:count, b],
        )
        time = None if stop is None else float(scenario.time[0] + stop * columns.step)
        results.append(SimulationResult(scenario, trajectory, outcome, time, joint))
    return results


def _positions(columns: Columns, angles: Array) -> list[Array]:
    """For each column (T, M, 3) [m] where its markers are seen."""
    kinds: dict[object, list[int]] = defaultdict(list)
    for b, (scenario, arm) in enumerate(zip(columns.scenarios, columns.arms, strict=True)):
        kinds[(rigid_body(arm), scenario.markers)].append(b)
    positions: list[Array] = [angles] * len(columns.scenarios)
    for members in kinds.values():
        model, markers = columns.arm_models[members[0]], columns.scenarios[members[0]].markers
        reach = np.array([marker.arc_length for marker in markers])
        places = marker_map(model, reach)
        q = angles[:, members]
        seen = places.positions(q)
        for effect in columns.effects:
            if effect.acts_through("observe"):
                own = type(effect)(**{p.name: getattr(effect, p.name)[members] for p in effect.parameters()})
                seen = own.observe(View(seen, places.normals(q), reach, model.joint_axis))
        for place, b in enumerate(members):
            positions[b] = seen[:, place]
    return positions

"""Simulation runs of ``hsr-sim``: planning from the options, simulation, and conversion to a dataset."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from hsr_pin.cli.arm import arm_from
from hsr_pin.cli.progress import progress
from hsr_pin.effects.catalogue import parse_effect
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import InputError, PressureError, SimulationFailure
from hsr_pin.obstacles import Cylinder, HalfSpace, Obstacle, Surface
from hsr_pin.replay.drawn import Drawn
from hsr_pin.robot.combinations import Combination, combinations
from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.drive import Drive, checked_duration, pressure_step, torque_step
from hsr_pin.simulation.measures import TipMeasures, measure_tip
from hsr_pin.simulation.motion import Dynamics, default_dynamics
from hsr_pin.simulation.result import SimulationResult
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Array, Dataset, Trajectory, Trial

_DURATION = 3.0
#: Description of every dataset that is written here.
DESCRIPTION = "simulated by hsr-sim"


@dataclass(frozen=True, eq=False)
class Run:
    """Simulation run: its plan and, once it is simulated, its motion.

    Attributes:
        arm, drive, effects: simulated arm, its input, and the effects added to the model.
        trajectory: simulated motion; None before the simulation.
        tabulated: row of Table II of the paper that the run reproduces, if any.
        notes: notes for the user, one sentence each.
        forces: (2, T, O, 3) forces of the obstacles [N], and the points where they act [m]; None without obstacles.
    """

    arm: ArmSpecification
    drive: Drive
    effects: tuple[Effect, ...] = ()
    trajectory: Trajectory | None = None
    tabulated: Combination | None = None
    notes: tuple[str, ...] = ()
    forces: Array | None = None

    @property
    def torque(self) -> float:
        """Last commanded torque [N m]; in space its magnitude."""
        last = self.drive.torque[-1]
        return float(last) if self.drive.torque.ndim == 1 else float(np.hypot(*last))

    @property
    def direction(self) -> float | None:
        """Direction of the last command in space, from x towards y [rad]; None in the plane."""
        return float(np.arctan2(*self.drive.torque[-1, ::-1])) if self.drive.torque.ndim == 2 else None

    @property
    def pressures(self) -> tuple[float, float] | None:
        """Last commanded pressures [bar], as printed in the paper for its own runs; for a torque, pressures that produce it."""
        if self.tabulated is not None:
            return self.tabulated.P1, self.tabulated.P2
        if self.drive.pressures is not None:
            return float(self.drive.pressures[-1, 0]), float(self.drive.pressures[-1, 1])
        try:
            p1, p2 = PAPER.pressures_for_torque(self.arm.keq, self.torque).tolist()
        except PressureError:
            return None
        return p1, p2

    @property
    def motion(self) -> Trajectory:
        """Motion of a simulated run."""
        if self.trajectory is None:
            raise ValueError("the run has not been simulated yet")
        return self.trajectory

    @cached_property
    def measures(self) -> TipMeasures:
        """Measures of the motion of the tip."""
        return measure_tip(self.motion)

    @property
    def label(self) -> str:
        """Text that distinguishes the run from the others."""
        if self.drive.pressures is None or self.pressures is None:
            where = "" if self.direction is None else f" towards {self.direction:.3g} rad"
            return f"{self.torque:.4g} N m{where}"
        p1, p2 = self.pressures
        return f"{self.torque:.3f} N m (P1 {p1:.5g}, P2 {p2:.5g} bar)"

    @property
    def drawn(self) -> Drawn:
        """Run in the form used for pictures."""
        return Drawn(self.label, self.arm, self.motion, forces=self.forces)


def planned(options: dict[str, Any]) -> list[Run]:
    """Return the runs that the options describe.

    Raises:
        InputError: an option is invalid, or the stiffness is not tabulated in the paper and no pressures are given.
    """
    effects = tuple(parse_effect(text) for text in options["effects"])
    stepped = bool(options["pressures"] or options["torque"])
    if options["input_file"] is not None:
        if stepped:
            raise InputError("--input", expected="this option alone", received="--pressures or --torque as well")
        return [_in_its_space(_from_file(options, effects), options["direction"])]
    duration = checked_duration(_DURATION if options["duration"] is None else options["duration"])
    runs = [_from_pressures(options, pair, duration) for pair in options["pressures"]]
    if options["torque"] or not stepped:
        arm = _arm(options)
        runs += [Run(arm, torque_step(arm, torque, duration)) for torque in options["torque"]]
        if not stepped:
            runs = [_from_table(arm, row, duration) for row in _tabulated(arm.keq)]
    runs = [_in_its_space(replace(run, effects=effects), options["direction"]) for run in runs]
    for run in runs:
        run.drive.scenario(run.arm, effects)  # invalid combinations are refused here, before anything runs
    return runs


def _arm(options: dict[str, Any]) -> ArmSpecification:
    """Return the arm with the obstacles that the options describe."""
    surface = Surface.of(options["material"])._asdict()
    obstacles: list[Obstacle] = [HalfSpace(point=(0.0, 0.0, height), **surface) for height in options["ground"]]
    obstacles += [HalfSpace(point=(x, 0.0, 0.0), normal=(-np.copysign(1.0, x), 0.0, 0.0), **surface) for x in options["wall"]]
    obstacles += [Cylinder(centre=(x, 0.0, z), radius=radius, **surface) for x, z, radius in options["post"]]
    return replace(arm_from(options), obstacles=tuple(obstacles))


def common_dynamics(runs: list[Run]) -> Dynamics:
    """Return the default dynamics for the longest chain of all runs."""
    return default_dynamics(max((run.arm for run in runs), key=lambda arm: arm.links), runs[0].effects)


def simulated(runs: list[Run], dynamics: Dynamics) -> list[Run]:
    """Return the runs with their simulated motions, showing a progress bar on a terminal.

    Raises:
        SimulationFailure: a run ended early; the error names the first one.
    """
    done = []
    for number, run in enumerate(progress(runs, "simulating"), 1):
        try:
            result = simulate(run.drive.scenario(run.arm, run.effects), dynamics=dynamics)
        except SimulationFailure as failure:
            raise SimulationFailure(f"run {number} ({run.label}): {failure}", failure.result) from failure
        run = replace(run, trajectory=run.drive.noted_in(result.trajectory))
        if run.arm.obstacles:
            found = result.contact_forces()
            run = replace(run, forces=np.stack([found.force, found.point]), notes=(*run.notes, *_contacts(result, found.force)))
        done.append(replace(run, notes=(*run.notes, result.warning) if result.warning else run.notes))
    return done


def _contacts(result: SimulationResult, forces: Array) -> list[str]:
    """Return a sentence on the contact with each obstacle, from the forces (T, O, 3) [N]."""
    obstacles, time = result.scenario.arm.obstacles, result.trajectory.time
    found = []
    for number, (obstacle, force) in enumerate(zip(obstacles, np.linalg.norm(forces, axis=2).T, strict=True), 1):
        name = f"obstacle {number} ({obstacle.shape.replace('_', ' ')})"
        if not force.any():
            found.append(f"{name}: no contact")
            continue
        found.append(
            f"{name}: contact from {time[np.argmax(force > 0)]:.3g} s, "
            f"largest force {force.max():.3g} N, {force[-1]:.3g} N at the end"
        )
    return found


def dataset(runs: list[Run], dynamics: str) -> Dataset:
    """Return simulated runs as a dataset in memory."""
    arm = runs[0].arm
    effects = ", ".join(repr(effect) for effect in runs[0].effects) or "none"
    return Dataset(
        name="simulation",
        length=arm.length,
        mass=arm.mass,
        diameter=arm.diameter,
        mount=arm.mount,
        bending=arm.bending,
        torsion=arm.torsion,
        trials=tuple(
            Trial(f"trial_{number:02d}", run.motion, run.arm.keq, run.arm.damping, run.arm.tip_mass)
            for number, run in enumerate(runs, 1)
        ),
        description=DESCRIPTION,
        chain=(arm.links, arm.placement),
        obstacles=arm.obstacles,
        notes=(f"simulated: {arm.links} links, placement {arm.placement}, dynamics {dynamics}, effects {effects}",),
    )


def _in_its_space(run: Run, direction: float | None) -> Run:
    """Return the run with one torque component in a plane, or two in space."""
    alone, space = run.drive.torque.ndim == 1, run.arm.bending == "space"
    if direction is not None and not (alone and space):
        received = "two components of torque" if space else "an arm in a plane"
        raise InputError("--direction", expected="one torque for an arm in space", received=received, hint="try --bending space")
    if not alone and not space:
        hint = "try --bending space"
        raise InputError("--input", expected="one torque for an arm in a plane", received="tau_x and tau_y", hint=hint)
    return replace(run, drive=run.drive.towards(direction or 0.0)) if alone and space else run


def _tabulated(keq: float) -> tuple[Combination, ...]:
    try:
        return combinations(keq)
    except PressureError:
        raise InputError(
            "keq",
            expected="1.11 or 2.33 Nm/rad, whose pressure combinations the paper tabulates",
            received=f"{keq:g}",
            hint="for another stiffness add --pressures P1 P2 or --torque TAU",
        ) from None


def _from_table(arm: ArmSpecification, row: Combination, duration: float) -> Run:
    """Return the run of a row of Table II, with exact pressures for its torque (the table has four digits)."""
    p1, p2 = PAPER.pressures_for_torque(row.keq, row.tau).tolist()
    notes = tuple(
        f"Table II prints {name} = {printed:.4f} bar for {row.tau:.3f} N m; Eqs. (1), (4) and (5) give {exact:.4f}"
        for name, printed, exact in (("P1", row.P1, p1), ("P2", row.P2, p2))
        if abs(printed - exact) > 1e-3
    )
    return Run(arm, pressure_step(arm, (p1, p2), duration), tabulated=row, notes=notes)


def _from_pressures(options: dict[str, Any], pair: tuple[float, float], duration: float) -> Run:
    own = {"keq": repr(float(PAPER.stiffness(pair)))} if options["keq"] is None else {}
    arm = _arm(options | own)
    return Run(arm, pressure_step(arm, pair, duration), notes=_stiffness_note(arm, pair))


def _stiffness_note(arm: ArmSpecification, pair: tuple[float, float]) -> tuple[str, ...]:
    """Return a note if the given stiffness differs from that of Eq. (1) by more than the scatter of the equation."""
    try:
        by_equation = float(PAPER.stiffness(pair))
    except PressureError:
        by_equation = float("nan")
    if abs(by_equation - arm.keq) <= PAPER.scatter.residual[0]:
        return ()
    from_equation = "no stiffness" if by_equation != by_equation else f"{by_equation:.3g} Nm/rad"
    return (f"P1 {pair[0]:g}, P2 {pair[1]:g} bar: Eq. (1) gives {from_equation}; the run uses {arm.keq:g} Nm/rad as given",)


def _from_file(options: dict[str, Any], effects: tuple[Effect, ...]) -> Run:
    from hsr_pin.recordings.command_file import read_commands  # imported here, as it is not needed without a file

    arm = _arm(options)
    commands = read_commands(options["input_file"], max_pressure=PAPER.max_pressure, duration=options["duration"])
    torque = commands.torque if commands.pressures is None else PAPER.torque(commands.pressures, arm.keq)
    assert torque is not None  # a file has either torques or pressures
    drive = Drive(commands.time, torque, commands.pressures)
    return Run(arm, drive, effects, notes=(commands.note,) if commands.note else ())

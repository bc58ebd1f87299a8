"""What ``hsr-sim`` is asked to run, from its options to results."""

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
from hsr_pin.replay.drawn import Drawn
from hsr_pin.robot.combinations import Combination, combinations
from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.drive import Drive, checked_duration, pressure_step, torque_step
from hsr_pin.simulation.measures import TipMeasures, measure_tip
from hsr_pin.simulation.motion import Dynamics, usual
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Dataset, Trajectory, Trial

_DURATION = 3.0
#: How the description of every dataset that is written here begins.
DESCRIPTION = "simulated by hsr-sim"


@dataclass(frozen=True, eq=False)
class Run:
    """One run: planned, and with its motion once it is simulated.

    Attributes:
        arm, drive, effects: what runs.
        trajectory: the motion.
        tabulated: the row of Table II that it is, if it is one.
        notes: one sentence each, for the user.
    """

    arm: ArmSpecification
    drive: Drive
    effects: tuple[Effect, ...] = ()
    trajectory: Trajectory | None = None
    tabulated: Combination | None = None
    notes: tuple[str, ...] = ()

    @property
    def torque(self) -> float:
        """The last command [N m]; in space its size."""
        last = self.drive.torque[-1]
        return float(last) if self.drive.torque.ndim == 1 else float(np.hypot(*last))

    @property
    def direction(self) -> float | None:
        """Of the last command in space, from x towards y [rad]; None in the plane."""
        return float(np.arctan2(*self.drive.torque[-1, ::-1])) if self.drive.torque.ndim == 2 else None

    @property
    def pressures(self) -> tuple[float, float] | None:
        """The last command [bar], as the paper prints it for its own; for a torque, the pressures that give it, if any do."""
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
        """The motion of a simulated run."""
        if self.trajectory is None:
            raise ValueError("this run is not simulated yet")
        return self.trajectory

    @cached_property
    def measures(self) -> TipMeasures:
        """What the tip did."""
        return measure_tip(self.motion)

    @property
    def label(self) -> str:
        """What tells this run from the others."""
        if self.drive.pressures is None or self.pressures is None:
            where = "" if self.direction is None else f" towards {self.direction:.3g} rad"
            return f"{self.torque:.4g} N m{where}"
        p1, p2 = self.pressures
        return f"{self.torque:.3f} N m (P1 {p1:.5g}, P2 {p2:.5g} bar)"

    @property
    def drawn(self) -> Drawn:
        """The run, for pictures."""
        return Drawn(self.label, self.arm, self.motion)


def planned(options: dict[str, Any]) -> list[Run]:
    """The runs that the options ask for.

    Raises:
        InputError: something given cannot be used, or no pressures were given for a stiffness that the paper does not tabulate.
    """
    effects = tuple(parse_effect(text) for text in options["effects"])
    stepped = bool(options["pressures"] or options["torque"])
    if options["input_file"] is not None:
        if stepped:
            raise InputError("--input", expected="alone", received="--pressures or --torque beside it")
        return [_in_its_space(_from_file(options, effects), options["direction"])]
    duration = checked_duration(_DURATION if options["duration"] is None else options["duration"])
    runs = [_from_pressures(options, pair, duration) for pair in options["pressures"]]
    if options["torque"] or not stepped:
        arm = arm_from(options)
        runs += [Run(arm, torque_step(arm, torque, duration)) for torque in options["torque"]]
        if not stepped:
            runs = [_from_table(arm, row, duration) for row in _tabulated(arm.keq)]
    runs = [_in_its_space(replace(run, effects=effects), options["direction"]) for run in runs]
    for run in runs:
        run.drive.scenario(run.arm, effects)  # what cannot be simulated together is refused here, before anything runs
    return runs


def usual_dynamics(runs: list[Run]) -> Dynamics:
    """What starts soonest and bears them all."""
    return usual(max(run.arm.links for run in runs), runs[0].arm.bending == "space")


def simulated(runs: list[Run], dynamics: Dynamics) -> list[Run]:
    """The same runs with their motions, with a progress bar on a terminal.

    Raises:
        SimulationFailure: of the first run that ended early.
    """
    done = []
    for number, run in enumerate(progress(runs, "simulating"), 1):
        try:
            result = simulate(run.drive.scenario(run.arm, run.effects), dynamics=dynamics)
        except SimulationFailure as failure:
            raise SimulationFailure(f"run {number} ({run.label}): {failure}", failure.result) from failure
        warnings = (result.warning,) if result.warning else ()
        done.append(replace(run, trajectory=run.drive.noted_in(result.trajectory), notes=run.notes + warnings))
    return done


def dataset(runs: list[Run], dynamics: str) -> Dataset:
    """Simulated runs as a dataset in memory."""
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
        notes=(f"simulated: {arm.links} links, placement {arm.placement}, dynamics {dynamics}, effects {effects}",),
    )


def _in_its_space(run: Run, direction: float | None) -> Run:
    """The run with a torque of as many components as its arm bends in."""
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
            hint="for any other stiffness add --pressures P1 P2 or --torque TAU",
        ) from None


def _from_table(arm: ArmSpecification, row: Combination, duration: float) -> Run:
    """The torque that Table II prints, and the pressures that give it to the last digit (the table has four)."""
    p1, p2 = PAPER.pressures_for_torque(row.keq, row.tau).tolist()
    notes = tuple(
        f"Table II prints {name} = {printed:.4f} bar for {row.tau:.3f} N m; Eqs. (1), (4) and (5) give {exact:.4f}"
        for name, printed, exact in (("P1", row.P1, p1), ("P2", row.P2, p2))
        if abs(printed - exact) > 1e-3
    )
    return Run(arm, pressure_step(arm, (p1, p2), duration), tabulated=row, notes=notes)


def _from_pressures(options: dict[str, Any], pair: tuple[float, float], duration: float) -> Run:
    own = {"keq": repr(float(PAPER.stiffness(pair)))} if options["keq"] is None else {}
    arm = arm_from(options | own)
    return Run(arm, pressure_step(arm, pair, duration), notes=_stiffness_note(arm, pair))


def _stiffness_note(arm: ArmSpecification, pair: tuple[float, float]) -> tuple[str, ...]:
    """A word where the stiffness given is not the one of the pressures, beyond the scatter of the rows behind Eq. (1)."""
    try:
        by_equation = float(PAPER.stiffness(pair))
    except PressureError:
        by_equation = float("nan")
    if abs(by_equation - arm.keq) <= PAPER.scatter.residual[0]:
        return ()
    said = "no stiffness at all" if by_equation != by_equation else f"{by_equation:.3g} Nm/rad"
    return (f"P1 {pair[0]:g}, P2 {pair[1]:g} bar: Eq. (1) gives {said}; simulated with {arm.keq:g} Nm/rad as asked",)


def _from_file(options: dict[str, Any], effects: tuple[Effect, ...]) -> Run:
    from hsr_pin.recordings.command_file import read_commands  # here: without a file, no recordings

    arm = arm_from(options)
    commands = read_commands(options["input_file"], max_pressure=PAPER.max_pressure, duration=options["duration"])
    torque = commands.torque if commands.pressures is None else PAPER.torque(commands.pressures, arm.keq)
    assert torque is not None  # a file has the one or the other
    drive = Drive(commands.time, torque, commands.pressures)
    return Run(arm, drive, effects, notes=(commands.note,) if commands.note else ())

"""Conversion of a captured trial to the recording format: input at the samples of the motion, and declared numbers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from hsr_pin.errors import InputError, RecordingError
from hsr_pin.recordings.grid import mean_until_next, on_even_grid
from hsr_pin.recordings.importers.capture import Capture
from hsr_pin.recordings.importers.command_rows import CommandRows
from hsr_pin.recordings.importers.settings import ImportSettings, per_trial
from hsr_pin.recordings.importers.space import torque_rows
from hsr_pin.recordings.sections import around, torque_columns
from hsr_pin.trajectory import Array, Channel, Marker, Trajectory, Trial

#: Function that returns, at given times [s], the input as keyword arguments of a trajectory, and notes.
_Drive = Callable[[Array], tuple[dict[str, Any], list[str]]]


def check_torques(command: CommandRows, settings: ImportSettings) -> None:
    """Check that the command of an arm in space consists of torques of its sections if no channels are declared.

    Raises:
        RecordingError: the command has other columns.
    """
    if not settings.in_space or settings.channels or settings.gain is not None:
        return
    columns = torque_columns(settings.inputs_of_arm)
    if command.names != columns:
        expected, received = " and ".join(columns), " and ".join(command.names)
        hint = "declare chambers and tendons in tables [[input]]"
        raise RecordingError("input", expected=expected, received=received, hint=hint, file=command.path)


def channels_of_input(commands: Sequence[CommandRows | None], settings: ImportSettings) -> tuple[Channel, ...]:
    """Return the declared channels or, with a gain, the columns of the files as chambers spaced evenly around the arm.

    Raises:
        InputError: a gain is given without an input.
        RecordingError: the files have different columns.
    """
    if settings.gain is None:
        return tuple(settings.channels)
    given = [command for command in commands if command is not None]
    if not given:
        raise InputError("gain", expected="an input to which the gain applies", received="none", hint="give it with --input")
    first = given[0]
    for other in given[1:]:
        if other.names != first.names:
            expected, received = f"t,{','.join(first.names)}, as in {first.path.name}", f"t,{','.join(other.names)}"
            raise RecordingError("columns", expected=expected, received=received, file=other.path, line=1, column=1)
    torques = around(len(first.names), settings.gain, settings.angle)
    return tuple(Channel(name, "bar", torque) for name, torque in zip(first.names, torques, strict=True))


def driven(command: CommandRows | None, channels: tuple[Channel, ...], settings: ImportSettings) -> _Drive:
    """Return a function for the input at given times, which is held or, for a measured input, interpolated linearly."""

    def at(time: Array) -> tuple[dict[str, Any], list[str]]:
        if command is None:
            return {}, []
        straight = command.commanded is not None if settings.interpolated is None else settings.interpolated
        values, between = (command.interpolated_at(time), ()) if straight else mean_until_next(command.time, command.values, time)
        late = command.time[0] > time[0] + 1e-9
        given = {}
        if command.commanded is not None:
            commanded, changed = mean_until_next(command.time, command.commanded, time)
            given, between = {"commanded": commanded}, (*between, *changed)
        notes = [*between, *([f"the input begins at {command.time[0]:g} s; its first row was used before"] if late else [])]
        if channels:
            each = replace(command, time=time, values=values)
            return given | {"channels": values, "torque": torque_rows(each, channels, settings.inputs_of_arm)}, notes
        if command.names == ("P1", "P2"):
            return given | {"pressures": values}, notes
        return given | {"torque": values[:, 0] if command.names == ("tau",) else values}, notes

    return at


def trajectory_of(capture: Capture, world: Array, markers: tuple[Marker, ...], drive: _Drive, notes: Sequence[str]) -> Trajectory:
    """Return the motion at even times together with its input.

    Raises:
        RecordingError: sampling is so uneven that almost all of an even grid would be gaps.
    """
    try:
        trajectory, _ = on_even_grid(Trajectory(capture.time, markers, world))
    except ValueError:
        hint = "split the recording at long pauses"
        expected, received = "nearly even sampling", "gaps at almost all even times"
        raise RecordingError("time", expected=expected, received=received, hint=hint, file=capture.path) from None
    given, input_notes = drive(trajectory.time)
    return replace(trajectory, **given, notes=(*notes, *trajectory.notes, *input_notes))


def facts_of_trials(settings: ImportSettings, trials: int) -> list[dict[str, float | None]]:
    """Return the declared numbers of each trial, by name."""
    names = ("keq", "damping", "tip_mass", "t_start")
    columns = [per_trial(getattr(settings, name), trials, name) for name in names]
    return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]


def trial_of(name: str, trajectory: Trajectory, facts: dict[str, float | None], path: Path, interpolated: bool | None) -> Trial:
    """Return a trial with its declared numbers.

    Raises:
        InputError: the start of the trial is after its end.
    """
    t_start, time = facts["t_start"], trajectory.time
    if t_start is not None and not time[0] <= t_start < time[-1]:
        raise InputError("t_start", expected=f"a time in the recording, 0 to {time[-1]:g} s", received=f"{t_start:g}", file=path)
    keq, damping, tip_mass = facts["keq"] or 0.0, facts["damping"], facts["tip_mass"] or 0.0
    return Trial(name, trajectory, keq, damping, tip_mass, t_start, interpolated)

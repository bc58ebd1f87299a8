"""Small datasets as drafts that can be changed part by part before they are written: whole, or wrong in one place."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate

#: Samples of a trial and the time between them [s]: short, since there are many.
SAMPLES, STEP = 40, 0.025
#: What drives an arm, and whether it bends in space.
KINDS = ("torque", "pressures", "release", "space")


@dataclass
class Draft:
    """A dataset as it will be written.

    Attributes:
        top, robot: keys of ``dataset.toml`` and of its table ``[robot]``, with their values as TOML has them.
        markers, trials: the same for each ``[[marker]]`` and ``[[trial]]``.
        tables: name of the file -> its rows of fields, the header first.
        texts: what is done to a file's bytes at last: name -> functions.
    """

    top: dict[str, str]
    robot: dict[str, str]
    markers: list[dict[str, str]]
    trials: list[dict[str, str]]
    tables: dict[str, list[list[str]]]
    texts: list = field(default_factory=list)

    def sections(self):
        """Every table of keys."""
        return [self.top, self.robot, *self.markers, *self.trials]

    def declaration(self) -> str:
        """The text of ``dataset.toml``."""
        parts = [("", self.top), ("[robot]", self.robot)]
        parts += [("[[marker]]", each) for each in self.markers] + [("[[trial]]", each) for each in self.trials]
        return "\n".join(
            line for head, values in parts for line in (head, *(f"{key} = {value}" for key, value in values.items()))
        )

    def write(self, folder: Path) -> Path:
        """Onto the disk."""
        folder.mkdir()
        files = {"dataset.toml": self.declaration()}
        files |= {name: "\n".join(",".join(row) for row in rows) + "\n" for name, rows in self.tables.items()}
        content = {name: text.encode("utf-8", "surrogatepass") for name, text in files.items()}
        for name, change in self.texts:
            content[name] = change(content.get(name, b""))
        for name, data in content.items():
            (folder / name).write_bytes(data)
        return folder


def drafts() -> dict[str, Draft]:
    """By what drives them: two trials each, of an arm that carries 30 g more than is declared."""
    return {kind: draft_of(kind) for kind in KINDS}


def copied(draft: Draft) -> Draft:
    """One to change."""
    return copy.deepcopy(draft)


def draft_of(kind: str) -> Draft:
    """One of :data:`KINDS`."""
    generator, space = np.random.default_rng(1), {"bending": "space"} if kind == "space" else {}
    arm = ArmSpecification(links=8, placement="mid", tip_mass=0.03, **space)
    time = np.arange(SAMPLES) * STEP
    tables, trials = {}, []
    for number, torque in enumerate((0.4, -0.6) if kind != "pressures" else (0.3, 0.6), 1):
        if kind == "release":
            command, start = np.zeros(SAMPLES), Settled(torque)
        else:
            command, start = np.where(time < 0.1 - 1e-9, 0.0, torque), Settled(0.0)
        if space:
            command = np.stack([command, 0.5 * command], axis=1)
        motion = simulate(Scenario(arm, time, command, start)).trajectory
        seen = motion.positions + 2e-4 * generator.standard_normal(motion.positions.shape)
        names = {"torque": ["tau"], "space": ["tau_x", "tau_y"]}.get(kind, [])
        inputs = list(zip(names, np.atleast_2d(command.T), strict=False))
        if kind == "pressures":
            pressures = PAPER.pressures_for_torque(1.11, command)
            inputs = [("P1", pressures[:, 0]), ("P2", pressures[:, 1])]
        header = ["t", *(name for name, _ in inputs), *(f"{m.name}_{axis}" for m in motion.markers for axis in "xyz")]
        columns = [time, *(values for _, values in inputs), *seen.reshape(SAMPLES, -1).T]
        rows = [[f"{value:.6f}" for value in row] for row in np.stack(columns, axis=1)]
        tables[f"trial_{number:02d}.csv"] = [header, *rows]
        trials.append({"file": f'"trial_{number:02d}.csv"', "keq": "1.11", "damping": "0.05"})
    return Draft(
        top={"format": "2" if space else "1", "name": f'"{kind}"', "description": '"one line"'},
        robot={
            "length": "0.24",
            "mass": "0.15",
            "diameter": "0.04",
            "mount": '"hanging"',
            **({"bending": '"space"'} if space else {}),
        },
        markers=[{"name": f'"{m.name}"', "arc_length": f"{m.arc_length}"} for m in motion.markers],
        trials=trials,
        tables=tables,
    )

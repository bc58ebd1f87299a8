"""Small datasets as drafts that can be changed part by part before they are written: whole, or wrong in one place."""

from __future__ import annotations

import copy
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from hsr_pin.recordings.sections import around
from hsr_pin.robot.pressure import PAPER
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Marker, Section

#: Samples of a trial and the time between them [s]: short, since there are many.
SAMPLES, STEP = 40, 0.025
#: What drives an arm, and whether it bends in space, as one or in sections under the pressures of chambers.
KINDS = ("torque", "pressures", "release", "space", "sections")
#: Of the arm in sections: its parts, and what the chambers P1 to P3 of the first and Q1 to Q3 of the second give.
SECTIONS = (Section(0.14, 0.09, 2.0, 0.1), Section(0.1, 0.06, 2.6, 0.12))
#: Of arms in space; one stands beside the backbone.
MARKERS = (Marker("base", 0.0), Marker("mid", 0.12, 0.02, 1.0), Marker("tip", 0.24))
GAIN, CHAMBERS = 0.4, (("P1", "P2", "P3"), ("Q1", "Q2", "Q3"))


@dataclass
class Draft:
    """A dataset as it will be written.

    Attributes:
        top, robot: keys of ``dataset.toml`` and of its table ``[robot]``, with their values as TOML has them.
        markers, trials: the same for each ``[[marker]]`` and ``[[trial]]``.
        more: head and keys of every other table.
        tables: name of the file -> its rows of fields, the header first.
        texts: what is done to a file's bytes at last: name -> functions.
    """

    top: dict[str, str]
    robot: dict[str, str]
    markers: list[dict[str, str]]
    trials: list[dict[str, str]]
    more: list[tuple[str, dict[str, str]]]
    tables: dict[str, list[list[str]]]
    texts: list = field(default_factory=list)

    def sections(self):
        """Every table of keys."""
        return [self.top, self.robot, *self.markers, *self.trials, *(table for _, table in self.more)]

    def declaration(self) -> str:
        """The text of ``dataset.toml``."""
        parts = [("", self.top), ("[robot]", self.robot), *self.more]
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
    generator, space = np.random.default_rng(1), kind in ("space", "sections")
    arm = ArmSpecification(links=8, placement="mid", tip_mass=0.03, bending="space" if space else "plane")
    if kind == "sections":
        arm = ArmSpecification.in_sections(SECTIONS, links=8, placement="mid", tip_mass=0.03)
    markers = {"markers": MARKERS} if space else {}
    time = np.arange(SAMPLES) * STEP
    tables, trials = {}, []
    for number, torque in enumerate((0.4, -0.6) if kind != "pressures" else (0.3, 0.6), 1):
        step = np.where(time < 0.1 - 1e-9, 0.0, torque)
        inputs, command = _driven(kind, step)
        start = Settled(torque) if kind == "release" else Settled(0.0)
        motion = simulate(Scenario(arm, time, command, start, **markers)).trajectory
        seen = motion.positions + 2e-4 * generator.standard_normal(motion.positions.shape)
        header = ["t", *inputs, *(f"{m.name}_{axis}" for m in motion.markers for axis in "xyz")]
        columns = [time, *inputs.values(), *seen.reshape(SAMPLES, -1).T]
        rows = [[f"{value:.6f}" for value in row] for row in np.stack(columns, axis=1)]
        tables[f"trial_{number:02d}.csv"] = [header, *rows]
        level = {} if kind == "sections" else {"keq": "1.11", "damping": "0.05"}
        trials.append({"file": f'"trial_{number:02d}.csv"', **level})
    return Draft(
        top={"format": "2" if space else "1", "name": f'"{kind}"', "description": '"one line"'},
        robot={
            "length": "0.24",
            "mass": "0.15",
            "diameter": "0.04",
            "mount": '"hanging"',
            **({"bending": '"space"'} if space else {}),
        },
        markers=[
            {"name": f'"{m.name}"', "arc_length": f"{m.arc_length}"}
            | ({"radius": f"{m.radius}", "angle": f"{m.angle}"} if m.radius else {})
            for m in motion.markers
        ],
        trials=trials,
        more=_in_sections() if kind == "sections" else [],
        tables=tables,
    )


def _driven(kind: str, step: np.ndarray) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Columns of the input, and the torque that they command; a release has none."""
    if kind == "release":
        return {}, np.zeros(SAMPLES)
    if kind == "pressures":
        return dict(zip(("P1", "P2"), PAPER.pressures_for_torque(1.11, step).T, strict=True)), step
    if kind == "space":
        return {"tau_x": step, "tau_y": 0.5 * step}, np.stack([step, 0.5 * step], axis=1)
    if kind == "sections":
        columns = {name: np.abs(step) * (k + 1) / 3 for names in CHAMBERS for k, name in enumerate(names)}
        torques = [row for k, names in enumerate(CHAMBERS) for row in around(len(names), GAIN, 0.0, k + 1, len(CHAMBERS))]
        return columns, np.stack(list(columns.values()), axis=1) @ np.array(torques)
    return {"tau": step}, step


def _in_sections() -> list[tuple[str, dict[str, str]]]:
    """The tables of sections and of their chambers."""
    parts = [("[[section]]", {key: f"{value}" for key, value in asdict(section).items()}) for section in SECTIONS]
    inputs = [
        {"columns": str(list(names)).replace("'", '"'), "section": f"{k + 1}", "gain": f"{GAIN}", "angle": "0.0"}
        for k, names in enumerate(CHAMBERS)
    ]
    return [*parts, *(("[[input]]", each) for each in inputs)]

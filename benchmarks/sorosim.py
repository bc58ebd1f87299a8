"""Published solutions of two rods in space by SoroSim, and the arms that are compared with them.

This is half of the data set that OpenCR-MuJoCo publishes (ContinuumRoboticsLab/opencr-mujoco, commit 17fff8b, MIT licence). The
folder ``shared`` next to the repository contains it, with a description.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np

from hsr_pin.robot.chain import Arms
from hsr_pin.robot.space import base_rotations
from hsr_pin.robot.specification import ArmSpecification, Placement
from hsr_pin.simulation.load import Load
from hsr_pin.simulation.scenario import Scenario, Settled
from hsr_pin.trajectory import Array, Marker

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "reference" / "sorosim"
#: Files have x along the straight rod; here z is.
_FRAME = np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])


@dataclass(frozen=True)
class Rod:
    """A round rod: length and radius [m], Young's modulus [Pa], Poisson's ratio, density [kg/m^3]."""

    name: str
    length: float
    radius: float
    modulus: float
    poisson: float
    density: float

    def arm(self, links: int, gravity: Array, lag: float = 0.1, placement: Placement = "shifted") -> ArmSpecification:
        """Return the arm with this rod's stiffness, mounted such that gravity (3,) [m/s^2] has the given direction in its base.

        Args:
            links: number of elements.
            gravity: gravity in the axes of the base.
            lag: damping over stiffness [s].
            placement: placement of the joints.
        """
        keq = self.modulus * pi * self.radius**4 / 4 / self.length
        down = gravity / np.linalg.norm(gravity)
        across = np.hypot(down[0], down[1])  # by which the base is turned from upright, about an axis across it
        turn = np.arctan2(across, -down[2]) / max(across, 1e-12)
        return ArmSpecification(
            links=links,
            keq=keq,
            damping=lag * keq,
            placement=placement,
            mount="upright",
            length=self.length,
            mass=self.density * pi * self.radius**2 * self.length,
            diameter=2 * self.radius,
            tilt=turn * down[0],
            cross_tilt=turn * down[1],
            bending_limit=20.0,
            bending="space",
            torsion=keq / (1 + self.poisson),
        )


RODS = {
    "steel": Rod("SpringSteelRod", 0.6, 0.0008, 200e9, 0.33, 7870.0),
    "TPU": Rod("TPURod", 0.4, 0.005, 70e6, 0.4, 1200.0),
}


@dataclass(frozen=True, eq=False)
class Case:
    """One solution: a rod with a wrench at mid length and one at the tip, in its base's axes, and the places of its points.

    Attributes:
        gravity: (3,) [m/s^2].
        wrenches: (2, 6) force [N], moment [N m].
        time: (T,) [s]; a single time: a shape at rest.
        places: (T, 2, 3) places of mid and tip [m].
        lag: damping over stiffness [s].
    """

    gravity: Array
    wrenches: Array
    time: Array
    places: Array
    lag: float = 0.1

    def scenario(self, rod: Rod, links: int, placement: Placement = "shifted") -> Scenario:
        """Return the scenario of the arm: held by the wrenches, and released at time zero if the file continues."""
        arm = rod.arm(links, self.gravity, self.lag, placement)
        axes = base_rotations(Arms.of([arm]))[0]
        held = (self.wrenches.reshape(2, 2, 3) @ axes.T).reshape(2, 6)
        released = len(self.time) > 1
        loads = tuple(
            Load(share * rod.length, before=w) if released else Load(share * rod.length, w[:3], w[3:])
            for share, w in zip((0.5, 1.0), held, strict=True)
        )
        time = self.time if released else np.array([0.0, 1e-3])
        markers = (Marker("mid", rod.length / 2), Marker("tip", rod.length))
        return Scenario(arm, time, np.zeros((len(time), 2)), Settled(), markers=markers, loads=loads)

    def errors(self, rod: Rod, positions: Array) -> Array:
        """Return distances (T, 2) [% of the length] of simulated markers (T, 2, 3) in the world from the published places."""
        axes = base_rotations(Arms.of([rod.arm(1, self.gravity)]))[0]
        return np.asarray(100 / rod.length * np.linalg.norm(positions[: len(self.time)] @ axes - self.places, axis=2))


def shapes(rod: Rod) -> list[Case]:
    """Return all shapes at rest of a rod."""
    with (FOLDER / f"statics_{rod.name}.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))[2:]
    table = np.array([[float(cell) for cell in row[1:]] for row in rows]).reshape(-1, 6, 17)
    turned = np.stack([_FRAME @ table[:, 3:], _FRAME @ table[:, :3]], axis=1)  # positions and forces, then moments
    return [
        Case(each[0, :, 0], each[:, :, 1:3].transpose(2, 0, 1).reshape(2, 6), np.zeros(1), each[0][:, [9, 16]].T[None])
        for each in turned
    ]


def releases(rod: Rod) -> list[Case]:
    """Return all releases of a rod."""
    found = []
    for path in sorted(FOLDER.glob(f"dynamics_{rod.name}_*.txt")):
        table = np.loadtxt(path)
        moments, forces = table[1, [1, 2, 3, 7, 8, 9]].reshape(2, 3), table[1, [4, 5, 6, 10, 11, 12]].reshape(2, 3)
        wrenches = np.concatenate([forces @ _FRAME.T, moments @ _FRAME.T], axis=1)
        places = table[2:, [4, 5, 6, 10, 11, 12]].reshape(-1, 2, 3) @ _FRAME.T
        found.append(Case(_FRAME @ table[0, 10:], wrenches, table[2:, 0], places, float(table[0, 0])))
    return found

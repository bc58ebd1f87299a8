"""Base class of all plants, which simulates a trial and writes the dataset of a program."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from hsr_pin.errors import SimulationFailure

from .arm import Arm, Array
from .artefacts import Artefacts
from .integration import planar, simulated
from .laws.law import Law
from .nuisance import Nuisance
from .program import Program, Trial
from .writing import MARKERS, Marker, observe, write

AnyPlant = TypeVar("AnyPlant", bound="Plant")


@dataclass(frozen=True)
class Plant(ABC):
    """An arm in an engine.

    Attributes:
        elements: number of elements of the arm.
        step: integrator step [s], an integer fraction of 10 ms.
        bare: the arm as declared.
    """

    elements: int
    step: float
    bare: Arm = field(default_factory=Arm)
    #: Class of the engine, which implements `integration.Engine`.
    engine: ClassVar[type[Any]]
    #: Factor by which the step is reduced if a simulation diverges; None: the simulation is not repeated.
    refinement: ClassVar[float | None] = None

    @property
    @abstractmethod
    def joints(self) -> Array:
        """Arc lengths of the joints, (n,), relative to the length."""

    def simulate(self, trial: Trial, laws: Sequence[Law] = (), k: float = 1.0, c: float = 1.0) -> Any:
        """Return the motion in a trial; true stiffness and damping are k and c times the declared ones."""
        arm = self.loaded(trial, laws)
        given = self.engine, arm, trial, laws, (k, c), self.joints
        try:
            return simulated(*given, self.step, self.motion)
        except SimulationFailure:
            if self.refinement is None:
                raise
            return simulated(*given, self.step / self.refinement, self.motion)

    def loaded(self, trial: Trial, laws: Sequence[Law]) -> Arm:
        """Return the true arm in a trial."""
        arm = replace(self.bare, tip_mass=self.bare.tip_mass + trial.tip_mass)
        for law in laws:
            arm = law.arm(arm, trial)
        return arm

    def motion(self, t: Array, s: Array, nodes: Sequence[Any]) -> Any:
        """Return the motion for times (T,) [s], arc lengths (N,) [m] and the nodes at each sample."""
        return planar(t, s, nodes)

    def observed(self, motion: Any, arm: Any, laws: Sequence[Law], markers: Sequence[Marker], error: Array) -> Array:
        """Return the marker points of a motion, see `writing.observe`."""
        return observe(motion, arm, laws, markers, error)

    def mounted(self: AnyPlant, mount: str) -> AnyPlant:
        """Return the same plant with another mount."""
        return replace(self, bare=replace(self.bare, mount=mount))

    def watch(
        self,
        program: Program,
        laws: Sequence[Law] = (),
        nuisance: Nuisance | None = None,
        markers: Sequence[Marker] = MARKERS,
        placement: Array | None = None,
    ) -> list[Array]:
        """Return the marker points (T, M, 3) of each trial of a program [m], without noise.

        `placement`, (M, 2) [m]: error of each marker's place, along and off the arm.
        """
        nuisance = nuisance or Nuisance()
        plant, laws = self.mounted(program.mount), (*nuisance.laws(), *laws)
        error = np.zeros((len(markers), 2)) if placement is None else placement
        points = []
        for trial in program.trials:
            motion = plant.simulate(trial, laws, nuisance.k, nuisance.c)
            points.append(self.observed(motion, plant.loaded(trial, laws), laws, markers, error))
        return points

    def run(
        self,
        program: Program,
        effects: Sequence[Law],
        seed: int,
        folder: str | Path,
        nuisance: Nuisance | None = None,
        markers: Sequence[Marker] = MARKERS,
        artefacts: Artefacts | None = None,
        session: int = 0,
    ) -> Path:
        """Record a program with these effects into a folder in the recording format, and return the folder.

        All random numbers follow from `seed`. Without `nuisance`, the nuisances are drawn from it (`nuisance_of(seed)`).
        Recording artefacts are added if given. In another session the markers keep their places, and the noise is new. Neither
        the folder nor its files contain the effects.
        """
        nuisance = nuisance or nuisance_of(seed)
        placing, noise = (np.random.default_rng(stream) for stream in ([seed, 1], [seed, 2, *[session] * bool(session)]))
        placement = nuisance.placement * placing.standard_normal((len(markers), 2))
        if artefacts is None:
            points = self.watch(program, effects, nuisance, markers, placement)
            noisy = [p + nuisance.noise * noise.standard_normal(p.shape) for p in points]
        else:
            points = self.watch(program, (*effects, artefacts.law()), nuisance, markers, placement)
            noisy = [
                artefacts.recorded(p, nuisance.noise, trial.clock, noise) for p, trial in zip(points, program.trials, strict=True)
            ]
        return write(Path(folder), program, self.bare, markers, noisy)


def nuisance_of(seed: int) -> Nuisance:
    """Return the nuisances that `Plant.run` draws for a seed."""
    return Nuisance.draw(np.random.default_rng([seed, 0]))

"""What every plant does: simulate a trial, and make a dataset of a program."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from .arm import Arm, Array, Motion
from .laws.law import Law
from .mess import Mess
from .nuisance import Nuisance
from .program import Program, Trial
from .writing import MARKERS, Marker, observe, write

AnyPlant = TypeVar("AnyPlant", bound="Plant")


class Plant(ABC):
    """An arm in an engine. `bare` is the arm as declared."""

    bare: Arm

    @abstractmethod
    def simulate(self, trial: Trial, laws: Sequence[Law] = (), k: float = 1.0, c: float = 1.0) -> Motion:
        """The motion in a trial; true stiffness and damping are k and c times the declared ones."""

    def mounted(self: AnyPlant, mount: str) -> AnyPlant:
        """The same plant on another mount."""
        return replace(self, bare=replace(self.bare, mount=mount))  # type: ignore[type-var]

    def watch(
        self,
        program: Program,
        laws: Sequence[Law] = (),
        nuisance: Nuisance | None = None,
        markers: Sequence[Marker] = MARKERS,
        placement: Array | None = None,
    ) -> list[Array]:
        """Marker points (T, M, 3) of each trial of a program [m], without noise.

        `placement`, (M, 2) [m]: how far each marker sits from where it should, along and off the arm.
        """
        nuisance = nuisance or Nuisance()
        plant, laws = self.mounted(program.mount), (*nuisance.laws(), *laws)
        error = np.zeros((len(markers), 2)) if placement is None else placement
        points = []
        for trial in program.trials:
            arm = plant.bare
            for law in laws:
                arm = law.arm(arm, trial)
            motion = plant.simulate(trial, laws, nuisance.k, nuisance.c)
            points.append(self.observed(motion, arm, laws, markers, error))
        return points

    def observed(self, motion: Motion, arm: Arm, laws: Sequence[Law], markers: Sequence[Marker], error: Array) -> Array:
        """As `writing.observe`."""
        return observe(motion, arm, laws, markers, error)

    def run(
        self,
        program: Program,
        effects: Sequence[Law],
        seed: int,
        folder: str | Path,
        nuisance: Nuisance | None = None,
        markers: Sequence[Marker] = MARKERS,
        mess: Mess | None = None,
        session: int = 0,
    ) -> Path:
        """Record a program with these effects into a folder in the recording format, and return it.

        Everything random follows from `seed`; without `nuisance`, it is drawn from it
        (`nuisance_of(seed)`). A mess comes on top. In another session the markers sit where they sat, the noise
        is another. Neither the folder nor its files tell the effects.
        """
        nuisance = nuisance or nuisance_of(seed)
        placing, noise = (np.random.default_rng(stream) for stream in ([seed, 1], [seed, 2, *[session] * bool(session)]))
        placement = nuisance.placement * placing.standard_normal((len(markers), 2))
        if mess is None:
            points = self.watch(program, effects, nuisance, markers, placement)
            noisy = [p + nuisance.noise * noise.standard_normal(p.shape) for p in points]
        else:
            points = self.watch(program, (*effects, mess.law()), nuisance, markers, placement)
            noisy = [mess.tracked(p, nuisance.noise, trial.clock, noise) for p, trial in zip(points, program.trials, strict=True)]
        return write(Path(folder), program, self.bare, markers, noisy)


def nuisance_of(seed: int) -> Nuisance:
    """The nuisances that `Plant.run` draws for a seed."""
    return Nuisance.draw(np.random.default_rng([seed, 0]))

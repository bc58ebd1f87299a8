"""A planar Cosserat rod in PyElastica.

The engine: M. Gazzola et al., Forward and Inverse Problems in the Mechanics
of Soft Filaments, R. Soc. Open Sci. 5, 2018; directors, shear and stretch, explicit position Verlet.

The damper C L (curvature rate) is too stiff for an explicit step. Therefore it is implemented here as a PyElastica damper: the
rates after each step solve (J + dt D) w' = J w with tridiagonal D. Shear and stretch have one common stiffness, as low as the
static sag allows (see `AXIAL_STIFFNESS`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from hsr_pin.errors import EffectError, MissingDependencyError

from .arm import Arm, Array
from .laws.law import Law, Nodes
from .plant import Plant
from .program import Trial

#: Stretch and shear stiffness [N]. The arm's weight of 1.5 N stretches it by 0.02 mm, at most a tenth of the noise. A rubber
#: rod of this section and bending stiffness has about a third of it.
AXIAL_STIFFNESS = 1e4


def joints_of(elements: int) -> Array:
    """Return the arc lengths of the joints, (n,), relative to the length: h/2, 3h/2, ..., because the base element is clamped.

    The first element is centred on the base.
    """
    h = 1 / (elements - 0.5)
    return np.arange(0.5, elements - 1, dtype=float) * h


class Cosserat(ABC):
    """An engine in PyElastica that implements `integration.Engine`.

    Args:
        arm: arm with all attached masses.
        stiffness: (n,) stiffness of the whole arm at the n inner nodes of n + 1 elements [Nm/rad].
        damping: (n,) damping of the whole arm at these nodes [Nm s/rad].
        step: integrator step [s].
    """

    #: The first director of the straight rod.
    normal: ClassVar[tuple[float, float, float]]

    def __init__(self, arm: Arm, stiffness: Array, damping: Array, step: float) -> None:
        try:
            import elastica
        except ImportError as error:
            raise MissingDependencyError("pyelastica", "blind") from error
        n, self.step = stiffness.size, step
        self.places = np.concatenate([[0.0], joints_of(n + 1), [1.0]]) * arm.length
        self.h = arm.length / (n + 0.5)
        self.per_bend = arm.length / self.h  # ratio of the bending of the whole arm to that of a joint
        self.damping = damping * self.per_bend
        self.rod = _rod(elastica, arm, stiffness, self.h, self.normal)
        self.inertia = self.rod.mass_second_moment_of_inertia[0, 0, 1:].copy()
        self.moment: Array = np.zeros(n)
        self.gravity: Array = np.zeros(0)
        self.force: Array | None = None
        self.time = 0.0
        self._extra_damping: Array | None = None
        self._constant_solve = np.linalg.inv(self._damped(self.damping)) * self.inertia
        self.simulator, self.stepper = _simulator(elastica, self)

    @abstractmethod
    def read(self) -> tuple[Array, Array]:
        """Return bending and its rate, see `integration.Engine`."""

    @abstractmethod
    def nodes(self) -> Any:
        """Return the base and the rod's nodes beyond it."""

    @abstractmethod
    def apply_loads(self, rod: Any) -> None:
        """Apply gravity, forces and joint moments to a PyElastica rod."""

    @abstractmethod
    def apply_dampers(self, rod: Any) -> None:
        """Apply the dampers of the joints implicitly; the clamped element does not rotate."""

    def advance(self, moment: Array, viscous: Array | None, force: Array | None, gravity: Array) -> None:
        """Simulate one step, see `integration.Engine`."""
        self.moment, self.force, self.gravity = moment, force, gravity
        self._extra_damping = None if viscous is None else viscous * self.per_bend
        self.time = self.stepper.step(self.simulator, self.time, self.step)

    def damped(self, rate: Array) -> Array:
        """Return the rates (n, ...) about one direction of space after a step of the dampers."""
        if self._extra_damping is None:
            return np.asarray(self._constant_solve @ rate)
        matrix, weight = self._damped(self.damping + self._extra_damping), self.inertia.reshape(-1, *[1] * (rate.ndim - 1))
        return np.linalg.solve(matrix, weight * rate)

    def _damped(self, d: Array) -> Array:
        """Return the matrix J + dt D for joint dampers d (n,) [Nm s/rad]."""
        tail = np.append(d[1:], 0.0)
        stiff = np.diag(d + tail) - np.diag(d[1:], 1) - np.diag(d[1:], -1)
        matrix: Array = np.diag(self.inertia) + self.step * stiff
        return matrix


class Rod(Cosserat):
    """Engine of a rod that bends about y, its first director."""

    normal = (0.0, 1.0, 0.0)

    def read(self) -> tuple[Array, Array]:
        bend = np.diff(self._angles()) * self.per_bend
        return bend, np.diff(self.rod.omega_collection[0]) * self.per_bend

    def nodes(self) -> Nodes:
        a = self._angles()
        angle = np.concatenate([[0.0], (a[1:] + a[:-1]) / 2, [1.5 * a[-1] - 0.5 * a[-2]]])
        position, velocity = (
            np.concatenate([np.zeros((2, 1)), field[::2, 1:]], axis=1)
            for field in (self.rod.position_collection, self.rod.velocity_collection)
        )
        return Nodes(position, velocity, angle)

    def apply_loads(self, rod: Any) -> None:
        rod.external_forces[0] += rod.mass * self.gravity[0]
        rod.external_forces[2] += rod.mass * self.gravity[1]
        if self.force is not None:
            rod.external_forces[::2, 1:] += self.force[:, 1:]
        rod.external_torques[0, 1:] += self.moment
        rod.external_torques[0, 1:-1] -= self.moment[1:]

    def apply_dampers(self, rod: Any) -> None:
        rate = rod.omega_collection[0]
        rate[0] = 0.0
        rate[1:] = self.damped(rate[1:])

    def _angles(self) -> Array:
        """Return the direction of each element, (n + 1,) [rad]."""
        along = self.rod.director_collection[2]
        angle: Array = np.arctan2(along[0], along[2])
        return angle


@dataclass(frozen=True)
class RodPlant(Plant):
    """The arm as a PyElastica rod.

    A law that is stiffer than the rod's own springs may need a smaller step, because the integrator is explicit.
    """

    elements: int = 24
    step: float = 5e-5
    engine = Rod
    refinement = 2.5

    @property
    def joints(self) -> Array:
        return joints_of(self.elements)

    def loaded(self, trial: Trial, laws: Sequence[Law]) -> Arm:
        """Return the true arm in a trial.

        Raises:
            EffectError: the rod does not support a law.
        """
        arm = super().loaded(trial, laws)
        if arm.wall is not None or any(place > arm.length for place, _ in arm.lumps):
            raise EffectError(
                "rod plant", expected="no contact, and no mass beyond the tip",
                received=[law.name for law in laws], hint="use the chain plant",
            )  # fmt: skip
        return arm


def _rod(elastica: Any, arm: Arm, stiffness: Array, h: float, normal: tuple[float, float, float]) -> Any:
    """Return a straight rod along z that begins half an element before the base; torsional and bending stiffness are equal."""
    n = stiffness.size + 1
    area = np.pi * arm.radius**2
    rod = elastica.CosseratRod.straight_rod(
        n, np.array([0.0, 0.0, -h / 2]), np.array([0.0, 0.0, 1.0]), np.array(normal),
        n * h, arm.radius, arm.line_mass / area, youngs_modulus=AXIAL_STIFFNESS / area,
    )  # fmt: skip
    rod.shear_matrix[:] = AXIAL_STIFFNESS * np.eye(3)[:, :, None]
    rod.bend_matrix[:] = np.eye(3)[:, :, None] * (stiffness * arm.length)
    rod.mass[-1] += arm.tip_mass
    for place, mass in arm.lumps:  # divided between the two neighbouring nodes by the lever rule
        where = np.clip((place + h / 2) / h, 0, n)
        k = int(min(where, n - 1))
        rod.mass[k] += mass * (k + 1 - where)
        rod.mass[k + 1] += mass * (where - k)
    return rod


def _simulator(elastica: Any, engine: Cosserat) -> tuple[Any, Any]:
    """Return PyElastica's simulator around the rod of an engine, and its stepper."""

    class Simulator(
        elastica.BaseSystemCollection,  # type: ignore[misc]
        elastica.Constraints,  # type: ignore[misc]
        elastica.Forcing,  # type: ignore[misc]
        elastica.Damping,  # type: ignore[misc]
    ):
        pass

    class Push(elastica.NoForces):  # type: ignore[misc]
        def apply_forces(self, system: Any, time: float = 0.0) -> None:
            engine.apply_loads(system)

    class Dampers(elastica.DamperBase):  # type: ignore[misc]
        def dampen_rates(self, system: Any, time: float) -> None:
            engine.apply_dampers(system)

    simulator = Simulator()
    simulator.append(engine.rod)
    simulator.constrain(engine.rod).using(elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,))
    simulator.add_forcing_to(engine.rod).using(Push)
    simulator.dampen(engine.rod).using(Dampers)
    simulator.finalize()
    return simulator, elastica.PositionVerlet()

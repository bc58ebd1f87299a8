"""A model with some of its numbers left open: what a fit searches, and what a diagnosis compares."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from hsr_pin.effects.effect import Effect, with_values
from hsr_pin.errors import IdentificationError
from hsr_pin.identification.experiment import Experiment, Run
from hsr_pin.identification.release import state_from_markers
from hsr_pin.parameters import Parameter
from hsr_pin.robot.model import build_model
from hsr_pin.robot.specification import ArmSpecification, Placement
from hsr_pin.simulation.columns import along
from hsr_pin.simulation.scenario import Pose, Scenario, Settled
from hsr_pin.trajectory import Array

#: Open numbers of the arm itself.
ARM = {
    "keq_scale": Parameter("keq_scale", "1", 1.0, 0.1, 10.0, 0.1, False, "stiffness over the declared one"),
    "damping_scale": Parameter("damping_scale", "1", 1.0, 0.02, 50.0, 0.2, False, "damping over the declared one"),
    "mass_scale": Parameter("mass_scale", "1", 1.0, 0.1, 10.0, 0.1, False, "mass of the arm over the declared one"),
}
#: Their counterparts in a scenario.
_SCENARIO_NAME = {"keq_scale": "keq", "damping_scale": "damping", "mass_scale": "mass"}
#: Samples at most over which the pose at rest is averaged.
_REST = 20


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A model of the arm with open parameters.

    Attributes:
        effects: what acts beside the nominal model; their values are where a fit starts.
        free: names of the open parameters: "keq_scale", "damping_scale", "mass_scale" (with "@1.11" behind it: for the trials
            declared with that Keq only), "effect.parameter".
        links, placement: the chain.
        integrator, step: how it is integrated; step [s].
    """

    effects: tuple[Effect, ...] = ()
    free: tuple[str, ...] = ("keq_scale", "damping_scale")
    links: int = 6
    placement: Placement = "mid"
    integrator: str = "ros2"
    step: float = 0.01

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Unit, bounds and scale of each open parameter.

        Raises:
            IdentificationError: a name that there is not.
        """
        known = dict(ARM)
        known |= {f"{e.name}.{p.name}": replace(p, name=f"{e.name}.{p.name}") for e in self.effects for p in e.parameters()}
        facts = []
        for name in self.free:
            base, at, level = name.partition("@")
            if base not in known or (at and (base not in ARM or not _is_number(level))):
                raise IdentificationError("parameter", expected=", ".join(known), received=repr(name))
            facts.append(replace(known[base], name=name))
        return tuple(facts)

    @cached_property
    def start(self) -> Array:
        """(P,) values to start from."""
        own = {f"{e.name}.{p.name}": float(getattr(e, p.name)) for e in self.effects for p in e.parameters()}
        return np.array([own.get(fact.name, fact.neutral) for fact in self.parameters])

    def with_effects(self, *effects: Effect) -> Hypothesis:
        """The same with further effects, all their parameters open."""
        names = tuple(f"{e.name}.{p.name}" for e in effects for p in e.parameters())
        return replace(self, effects=(*self.effects, *effects), free=(*self.free, *names))

    def finer(self, links: int, step: float) -> Hypothesis:
        """The same model, discretised more finely in space and time."""
        fine = replace(self, links=max(links, self.links), step=min(step, self.step))
        return replace(fine, integrator="extrapolated4", step=fine.step / 2) if self._rings else fine

    def steadied(self) -> Hypothesis:
        """The same model, with an integrator that none of its effects makes ring."""
        return replace(self, integrator="extrapolated3") if self._rings and self.integrator == "ros2" else self

    @property
    def _rings(self) -> bool:
        return any(effect.loosely_bounded for effect in self.effects)

    def with_chain(self, links: int, step: float) -> Hypothesis:
        """The same model with another number of links and step [s]."""
        return replace(self, links=links, step=step)

    def effects_at(self, values: Array) -> tuple[Effect, ...]:
        """The effects with the open parameters at ``values`` (P,)."""
        named = dict(zip(self.free, values, strict=True))
        return tuple(
            with_values(e, **{p.name: float(named.get(f"{e.name}.{p.name}", getattr(e, p.name))) for p in e.parameters()})
            for e in self.effects
        )

    def scenario(self, experiment: Experiment, run: Run, values: Array) -> Scenario:
        """What to simulate for one run with the open parameters at ``values`` (P,)."""
        scales = {
            name.partition("@")[0]: float(value)
            for name, value in zip(self.free, values, strict=True)
            if name.partition("@")[0] in ARM and self.counterpart(name, experiment, run) is not None
        }
        arm = _declared(experiment, run, self)
        arm = replace(
            arm,
            keq=arm.keq * scales.get("keq_scale", 1.0),
            damping=arm.damping * scales.get("damping_scale", 1.0),
            mass=arm.mass * scales.get("mass_scale", 1.0),
        )
        time, torque = run.time, run.torque
        if run.lead > 0:  # one sample more, so that the measured ones lie between simulated ones
            time = run.time[0] + run.step * (np.arange(len(run.time) + 1) - run.lead)
            torque = np.append(run.torque[:1], run.torque)
        effects = self.effects_at(values)
        start: Settled | Pose = Settled(float(run.torque[0]), _resting_angles(experiment, run, self.links, self.placement))
        if run.start_pose is not None:
            stiffness = tuple(along(effects, "stiffness", self.links)[:, 0].round(4).tolist())
            start = Pose(*_start_state(experiment, run, self.links, self.placement, stiffness))
        return Scenario(arm, time, torque, start, effects, experiment.markers)

    def counterpart(self, name: str, experiment: Experiment, run: Run) -> tuple[str, float] | None:
        """The scenario's parameter that an open one moves in a run, and by how much per unit; None: it does not act there."""
        base, _, level = name.partition("@")
        if level and not np.isclose(float(level), run.trial.keq):
            return None
        if base not in ARM:
            return base, 1.0
        return _SCENARIO_NAME[base], float(getattr(_declared(experiment, run, self), _SCENARIO_NAME[base]))


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False


def _declared(experiment: Experiment, run: Run, hypothesis: Hypothesis) -> ArmSpecification:
    return ArmSpecification.from_trial(
        experiment.dataset, run.trial, links=hypothesis.links, placement=hypothesis.placement, bending_limit=2 * np.pi
    )


@lru_cache(maxsize=256)
def _resting_angles(experiment: Experiment, run: Run, links: int, placement: Placement) -> Array | None:
    """(N,) [rad] about where a run rests before its first change of command, as the markers show; None where they do not."""
    changes = np.flatnonzero(np.diff(run.torque))
    window = run.measured[: min(int(changes[0]) + 1 if len(changes) else _REST, _REST)]
    if not np.isfinite(window).any(axis=0).all():
        return None
    arm = build_model(ArmSpecification.from_trial(experiment.dataset, run.trial, links=links, placement=placement))
    reach = np.array([marker.arc_length for marker in experiment.markers])
    pose = np.nanmedian(window, axis=0)
    return state_from_markers(arm, reach, pose, np.zeros_like(pose), float(experiment.noise.max()))[0]


@lru_cache(maxsize=1024)
def _start_state(
    experiment: Experiment, run: Run, links: int, placement: Placement, stiffness: tuple[float, ...]
) -> tuple[Array, Array]:
    """(N,) [rad], [rad/s] the state a run starts from: of what is fitted, only how stiffness varies along the arm matters."""
    assert run.start_pose is not None
    arm = build_model(ArmSpecification.from_trial(experiment.dataset, run.trial, links=links, placement=placement))
    reach = np.array([marker.arc_length for marker in experiment.markers])
    velocity = np.zeros_like(run.start_pose) if run.start_velocity is None else run.start_velocity
    return state_from_markers(arm, reach, run.start_pose, velocity, float(experiment.noise.max()), np.array(stiffness))

"""A MuJoCo model as a model whose missing causes can be explained: its numbers are opened by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from hsr_pin.errors import InputError, MissingDependencyError, quoted
from hsr_pin.explain.model import Cause, Model, Trial
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

#: What a number of MuJoCo belongs to, by how the name of its field begins.
_OBJECTS = {"dof": "joint", "jnt": "joint", "body": "body", "geom": "geom", "actuator": "actuator", "tendon": "tendon"}


@dataclass(frozen=True, eq=False)
class Opened:
    """A cause that is a change of numbers of an ``MjModel``, or a force of your own.

    Attributes:
        cause: its name, kind and parameters: one for each of ``elements``, or those that the functions below know.
        field: of the ``MjModel``, as "dof_frictionloss", "dof_damping", "dof_armature", "body_mass", "actuator_gear".
        elements: names of the joints, bodies or actuators whose numbers are opened.
        relative: whether a value is a share of what the model declares, and not an amount.
        delay: whether the (only) parameter is a time by which controls come later [s].
        force: called before each step with the ``MjModel``, the ``MjData`` and the values of the cause by name: it may set
            ``qfrc_applied`` or ``xfrc_applied``.
    """

    cause: Cause
    field: str = ""
    elements: tuple[str, ...] = ()
    relative: bool = False
    delay: bool = False
    force: Callable[[Any, Any, Mapping[str, float]], None] | None = None


@dataclass(frozen=True, eq=False)
class MujocoInputs:
    """How a trial of a MuJoCo model is driven.

    Attributes:
        controls: (N, nu) at the times of the trial, each held until the next.
        qpos: (nq,) at the start.
        qvel: (nv,) at the start.
    """

    controls: Array
    qpos: Array
    qvel: Array


@dataclass(frozen=True, eq=False)
class MujocoModel:
    """Predicts trials by MuJoCo; it can be sent to other processes.

    Attributes:
        xml: of the model (MJCF or URDF).
        channels: what is measured: for each channel the name of a sensor with one number, or of a joint with one angle.
        causes: what the model may lack.
        parameters: numbers that are fitted in any case, as ``Opened`` with one parameter each.
        name: of what is modelled.
        units: of the channels.
    """

    xml: str
    channels: Mapping[str, str]
    causes: tuple[Opened, ...] = ()
    parameters: tuple[Opened, ...] = ()
    name: str = "MuJoCo model"
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def as_model(self) -> Model:
        """It as a model of its causes.

        Raises:
            InputError: a field, an element or a channel that the model has not.
            MissingDependencyError: MuJoCo is not installed.
        """
        for opened in (*self.parameters, *self.causes):
            for element in opened.elements:
                self._index(opened.field, element)
        for channel in self.channels:
            self._place(channel)
        numbers = tuple(fact for opened in self.parameters for fact in opened.cause.parameters)
        causes = tuple(opened.cause for opened in self.causes)
        return Model(self.predict, numbers, causes, self.name, self.units)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name in self.__dataclass_fields__}

    @cached_property
    def declared(self) -> Any:
        """The ``MjModel`` as declared."""
        return _mujoco().MjModel.from_xml_string(self.xml)

    def predict(self, values: Mapping[str, float], trial: Trial) -> Mapping[str, Array]:
        """What the channels show in one trial."""
        import copy

        mujoco, model = _mujoco(), copy.copy(self.declared)
        lag, forces = 0.0, []
        prefixes = [""] * len(self.parameters) + [f"{each.cause.name}." for each in self.causes]
        for opened, prefix in zip((*self.parameters, *self.causes), prefixes, strict=True):
            own = {fact.name: values[prefix + fact.name] for fact in opened.cause.parameters}
            if opened.delay:
                lag += next(iter(own.values()))
            for element, value in zip(opened.elements, own.values(), strict=False):
                place = self._index(opened.field, element)
                numbers = getattr(model, opened.field)
                numbers[place] = _changed(numbers[place], value, opened, self._fact(opened, element))
            if opened.force is not None:
                forces.append((opened.force, own))
        data, inputs = mujoco.MjData(model), trial.inputs
        data.qpos[:], data.qvel[:] = inputs.qpos, inputs.qvel
        time, seen = trial.time - trial.time[0], np.full((len(trial.time), len(self.channels)), np.nan)
        places = [self._place(channel) for channel in self.channels]
        mujoco.mj_forward(model, data)
        sensors = any(array == "sensordata" for array, _ in places)
        for n in range(len(time)):
            if sensors:
                mujoco.mj_forward(model, data)  # a step leaves them as they were before it
            seen[n] = [getattr(data, array)[place] for array, place in places]
            while n + 1 < len(time) and data.time < time[n + 1] - model.opt.timestep / 2:
                data.ctrl[:] = inputs.controls[max(0, int(np.searchsorted(time, data.time - lag, side="right")) - 1)]
                for force, own in forces:
                    force(model, data, own)
                mujoco.mj_step(model, data)
            if not np.isfinite(data.qpos).all():
                break
        return dict(zip(self.channels, seen.T, strict=True))

    def _fact(self, opened: Opened, element: str) -> Parameter:
        """Of an element."""
        return opened.cause.parameters[opened.elements.index(element)]

    def _index(self, name: str, element: str) -> Any:
        """Where the number of an element stands in a field."""
        mujoco, kind = _mujoco(), _OBJECTS.get(name.partition("_")[0], "")
        if not kind or not hasattr(self.declared, name):
            raise InputError("field", expected="one of an MjModel, as dof_damping or body_mass", received=quoted(name))
        index = mujoco.mj_name2id(self.declared, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), element)
        if index < 0:
            raise InputError(name, expected=f"a {kind} of the model", received=quoted(element))
        return int(self.declared.jnt_dofadr[index]) if name.startswith("dof") else index

    def _place(self, channel: str) -> tuple[str, int]:
        """Array of ``MjData`` and place in it that a channel shows."""
        mujoco, name = _mujoco(), self.channels[channel]
        sensor = mujoco.mj_name2id(self.declared, mujoco.mjtObj.mjOBJ_SENSOR, name)
        joint = mujoco.mj_name2id(self.declared, mujoco.mjtObj.mjOBJ_JOINT, name)
        if sensor >= 0:
            return "sensordata", int(self.declared.sensor_adr[sensor])
        if joint >= 0:
            return "qpos", int(self.declared.jnt_qposadr[joint])
        raise InputError(f"channel {channel}", expected="a sensor or a joint of the model", received=quoted(name))


def _changed(declared: Any, value: float, opened: Opened, fact: Parameter) -> Any:
    """A number of the model with a change: times a factor, by a share, or by an amount."""
    if fact.ratio_width is not None:
        return declared * value
    return declared * (1 + value) if opened.relative else declared + value


def opened(
    name: str, kind: str, field: str, parameters: Sequence[Parameter], description: str = "", *, relative: bool = False
) -> Opened:
    """A cause that changes one field of an ``MjModel``, with a parameter for each element, named after it."""
    facts = tuple(parameters)
    single = tuple((fact.name,) for fact in facts) if len(facts) > 1 else ()
    cause = Cause(name, kind, facts, description, apart=single)
    return Opened(cause, field, tuple(fact.name for fact in facts), relative)


def _mujoco() -> Any:
    try:
        import mujoco
    except ImportError as error:
        raise MissingDependencyError("mujoco", "export") from error
    return mujoco

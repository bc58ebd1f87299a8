"""A MuJoCo model as a user-defined model, with causes that change named elements of its fields."""

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

#: Prefix of an ``MjModel`` field -> type of object that it describes.
_OBJECTS = {"dof": "joint", "jnt": "joint", "body": "body", "geom": "geom", "actuator": "actuator", "tendon": "tendon"}


@dataclass(frozen=True, eq=False)
class Opened:
    """A cause that changes elements of a field of an ``MjModel``, delays the controls, or applies a user-defined force.

    Attributes:
        cause: name, kind and parameters of the cause: one parameter for each of ``elements``, or those used by ``force``.
        field: field of the ``MjModel``, such as "dof_frictionloss", "dof_damping", "dof_armature", "body_mass", "actuator_gear".
        elements: names of the joints, bodies or actuators that are changed.
        relative: whether a value is a share of the declared number instead of an amount.
        delay: whether the only parameter is a delay of the controls [s].
        force: function called before each step with the ``MjModel``, the ``MjData`` and the values of the cause by name; it may
            set ``qfrc_applied`` or ``xfrc_applied``.
    """

    cause: Cause
    field: str = ""
    elements: tuple[str, ...] = ()
    relative: bool = False
    delay: bool = False
    force: Callable[[Any, Any, Mapping[str, float]], None] | None = None


@dataclass(frozen=True, eq=False)
class MujocoInputs:
    """Inputs of a trial of a MuJoCo model.

    Attributes:
        controls: (N, nu) controls at the sampling times of the trial, each held until the next.
        qpos: (nq,) initial positions.
        qvel: (nv,) initial velocities.
    """

    controls: Array
    qpos: Array
    qvel: Array


@dataclass(frozen=True, eq=False)
class MujocoModel:
    """Picklable model that predicts trials with MuJoCo.

    Attributes:
        xml: the model as text (MJCF or URDF).
        channels: for each measured channel the name of a scalar sensor, or of a joint with one angle.
        causes: causes that the model may lack.
        parameters: parameters that are always fitted, each as an ``Opened`` with one parameter.
        name: name of the modelled system.
        units: units of the channels.
    """

    xml: str
    channels: Mapping[str, str]
    causes: tuple[Opened, ...] = ()
    parameters: tuple[Opened, ...] = ()
    name: str = "MuJoCo model"
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def as_model(self) -> Model:
        """The same as a :class:`Model`.

        Raises:
            InputError: a field, an element or a channel does not exist in the model.
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
        """The ``MjModel`` with its declared parameters."""
        return _mujoco().MjModel.from_xml_string(self.xml)

    def predict(self, values: Mapping[str, float], trial: Trial) -> Mapping[str, Array]:
        """Return the channels of one trial as predicted by MuJoCo."""
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
                mujoco.mj_forward(model, data)  # mj_step leaves the sensor values of the previous state
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
        """Return the parameter of an element."""
        return opened.cause.parameters[opened.elements.index(element)]

    def _index(self, name: str, element: str) -> Any:
        """Return the index of an element in a field."""
        mujoco, kind = _mujoco(), _OBJECTS.get(name.partition("_")[0], "")
        if not kind or not hasattr(self.declared, name):
            raise InputError("field", expected="a field of an MjModel, such as dof_damping or body_mass", received=quoted(name))
        index = mujoco.mj_name2id(self.declared, getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}"), element)
        if index < 0:
            raise InputError(name, expected=f"a {kind} of the model", received=quoted(element))
        return int(self.declared.jnt_dofadr[index]) if name.startswith("dof") else index

    def _place(self, channel: str) -> tuple[str, int]:
        """Return the ``MjData`` array that holds a channel, and the index in it."""
        mujoco, name = _mujoco(), self.channels[channel]
        sensor = mujoco.mj_name2id(self.declared, mujoco.mjtObj.mjOBJ_SENSOR, name)
        joint = mujoco.mj_name2id(self.declared, mujoco.mjtObj.mjOBJ_JOINT, name)
        if sensor >= 0:
            return "sensordata", int(self.declared.sensor_adr[sensor])
        if joint >= 0:
            return "qpos", int(self.declared.jnt_qposadr[joint])
        raise InputError(f"channel {channel}", expected="a sensor or a joint of the model", received=quoted(name))


def _changed(declared: Any, value: float, opened: Opened, fact: Parameter) -> Any:
    """Return a number of the model after a change by a factor, by a share or by an amount."""
    if fact.ratio_width is not None:
        return declared * value
    return declared * (1 + value) if opened.relative else declared + value


def opened(
    name: str, kind: str, field: str, parameters: Sequence[Parameter], description: str = "", *, relative: bool = False
) -> Opened:
    """Return a cause that changes one field of an ``MjModel``, with one parameter for each element, named after the element."""
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

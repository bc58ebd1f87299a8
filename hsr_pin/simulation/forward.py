"""Accelerations of many chains at once: (M(q) + armature) a = tau - C(q, v) v - G(q), by ABA or by RNEA."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Literal

import numpy as np
import pinocchio as pin

from hsr_pin.errors import InputError
from hsr_pin.trajectory import Array

Method = Literal["aba", "rnea"]

#: Columns below which a second thread costs more than it brings.
THREADING_PAYS = 48


class ForwardDynamics(ABC):
    """Solves for accelerations with one of several armatures ("slots"), which the integrator asks for.

    Args:
        models: (B,) the Pinocchio model of each column; equal ones side by side.
        armatures: for each slot, (N,) [kg m^2] added to the diagonal of the mass matrix.
        threads: at most this many.
    """

    @abstractmethod
    def __init__(self, models: list[pin.Model], armatures: list[Array], threads: int = 1) -> None: ...

    @abstractmethod
    def solve(self, slot: int, q: Array, v: Array, tau: Array, out: Array | None = None) -> Array:
        """(N, B) [rad/s^2] accelerations, in ``out`` if given; angles, rates and torques (N, B), all in column-major order."""


class ArticulatedBody(ForwardDynamics):
    """Featherstone's articulated-body algorithm, O(N); ``pin.abaInParallel``.

    One pool serves all slots: Pinocchio's workspace, with its second derivatives, takes N^3 memory (1 MB at N = 32, 4 GB at 500).
    """

    def __init__(self, models: list[pin.Model], armatures: list[Array], threads: int = 1) -> None:
        self._threads = threads if len(models) >= THREADING_PAYS else 1
        self._shape = (models[0].nv, len(models))
        self._blocks = _blocks(models)
        self._pools = [pin.ModelPool(models[block.start], self._threads) for block in self._blocks]
        self._copies = [pool.getModel(thread) for pool in self._pools for thread in range(self._threads)]
        self._armatures = armatures

    def solve(self, slot: int, q: Array, v: Array, tau: Array, out: Array | None = None) -> Array:
        a = np.empty(self._shape, order="F") if out is None else out
        for model in self._copies:
            model.armature = self._armatures[slot]
        if len(self._pools) == 1:
            pin.abaInParallel(self._threads, self._pools[0], q, v, tau, a)
        else:
            for block, pool in zip(self._blocks, self._pools, strict=True):
                pin.abaInParallel(self._threads, pool, q[:, block], v[:, block], tau[:, block], a[:, block])
        return a


class NewtonEuler(ForwardDynamics):
    """Bias by the recursive Newton-Euler algorithm, mass matrix by CRBA: the path the paper names as future work; O(N^3)."""

    def __init__(self, models: list[pin.Model], armatures: list[Array], threads: int = 1) -> None:
        self._models = models
        self._data = {id(model): model.createData() for model in models}
        self._armatures = armatures

    def solve(self, slot: int, q: Array, v: Array, tau: Array, out: Array | None = None) -> Array:
        a = np.empty(q.shape, order="F") if out is None else out
        still = np.zeros(q.shape[0])
        for column, model in enumerate(self._models):
            data = self._data[id(model)]
            bias = pin.rnea(model, data, q[:, column], v[:, column], still)
            upper = np.triu(pin.crba(model, data, q[:, column]))
            mass = upper + np.triu(upper, 1).T + np.diag(self._armatures[slot])
            a[:, column] = np.linalg.solve(mass, tau[:, column] - bias)
        return a


METHODS: dict[str, type[ForwardDynamics]] = {"aba": ArticulatedBody, "rnea": NewtonEuler}


def forward_dynamics(method: str, models: list[pin.Model], armatures: list[Array], threads: int = 1) -> ForwardDynamics:
    """One of the two by name.

    Raises:
        InputError: no such method.
    """
    if method not in METHODS:
        raise InputError("dynamics", expected=" or ".join(METHODS), received=repr(method))
    return METHODS[method](models, armatures, threads)


def _blocks(models: list[pin.Model]) -> list[slice]:
    """Runs of columns that share a model."""
    starts = [0] + [i for i in range(1, len(models)) if models[i] is not models[i - 1]]
    return [slice(start, stop) for start, stop in zip(starts, [*starts[1:], len(models)], strict=True)]

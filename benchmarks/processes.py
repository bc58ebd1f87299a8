"""Ours in several processes, each with its share of the arms."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from types import TracebackType

import numpy as np
from ours import Ours

from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Array


class Processes:
    """A solver; a context, at whose end the processes end.

    Args:
        arms, method, substeps, nominal: as for `Ours`.
        count: of processes.
    """

    def __init__(
        self, arms: Sequence[ArmSpecification], method: str, substeps: int, nominal: ArmSpecification, count: int
    ) -> None:
        self._shares = np.array_split(np.arange(len(arms)), count)
        self._workers = [ProcessPoolExecutor(1, mp_context=get_context("spawn")) for _ in self._shares]
        for worker, share in zip(self._workers, self._shares, strict=True):
            worker.submit(_prepare, [arms[i] for i in share], method, substeps, nominal).result()

    def __enter__(self) -> Processes:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        for worker in self._workers:
            worker.shutdown()

    def run(self) -> Array:
        """Joint angles (T, B, N) [rad], all processes at once."""
        return np.concatenate([work.result() for work in [worker.submit(_run) for worker in self._workers]], axis=1)


_solver: Ours  # of this process


def _prepare(arms: Sequence[ArmSpecification], method: str, substeps: int, nominal: ArmSpecification) -> None:
    global _solver
    _solver = Ours(arms, method, substeps, nominal=nominal)


def _run() -> Array:
    return _solver.run()

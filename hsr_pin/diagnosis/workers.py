"""Fitting candidates one after the other, or in several processes."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from typing import TypeVar

from hsr_pin.diagnosis.candidates import Candidate, Guess, finish, glance, guesses
from hsr_pin.effects.effect import Effect
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import Fit

T = TypeVar("T")

_experiment: Experiment | None = None  # in a worker process: what it works on, sent once


class _Counting:
    """Calls ``advance`` after each answer."""

    def __init__(self, advance: Callable[[], None]) -> None:
        self._advance = advance

    def _counted(self, answers: Iterable[T]) -> list[T]:
        done = []
        for answer in answers:
            done.append(answer)
            self._advance()
        return done


class Serial(_Counting):
    """All in this process."""

    def __init__(self, experiment: Experiment, advance: Callable[[], None] = lambda: None) -> None:
        super().__init__(advance)
        self._experiment = experiment

    def guess(self, base: Candidate, effects: Sequence[Effect]) -> list[Guess]:
        """First guesses for adding each effect."""
        return guesses(self._experiment, base.fit, list(effects))

    def glance(self, tasks: Sequence[tuple[Fit, Guess]]) -> list[Fit]:
        """A quick fit for each guess about a base fit."""
        return self._counted(glance(self._experiment, base, guess) for base, guess in tasks)

    def finish(self, tasks: Sequence[tuple[Fit, Fit]]) -> list[Candidate]:
        """A candidate for each quick fit, with the fit it is based on before it."""
        return self._counted(finish(self._experiment, base, quick) for base, quick in tasks)


class Pool(_Counting):
    """In several processes; gives what :class:`Serial` gives."""

    def __init__(self, executor: ProcessPoolExecutor, jobs: int, advance: Callable[[], None] = lambda: None) -> None:
        super().__init__(advance)
        self._executor, self._jobs = executor, jobs

    def guess(self, base: Candidate, effects: Sequence[Effect]) -> list[Guess]:
        """First guesses for adding each effect."""
        parts = [list(effects[k :: self._jobs]) for k in range(self._jobs)]
        answers = self._executor.map(_guess, [base] * self._jobs, parts)
        order = {(effect.name, effect.options): place for place, effect in enumerate(effects)}
        found = [guess for answer in answers for guess in answer]
        return sorted(found, key=lambda guess: order[guess.hypothesis.effects[-1].name, guess.hypothesis.effects[-1].options])

    def glance(self, tasks: Sequence[tuple[Fit, Guess]]) -> list[Fit]:
        """A quick fit for each guess about a base fit."""
        return self._counted(self._executor.map(_glance, *zip(*tasks, strict=True)) if tasks else ())

    def finish(self, tasks: Sequence[tuple[Fit, Fit]]) -> list[Candidate]:
        """A candidate for each quick fit, with the fit it is based on before it."""
        return self._counted(self._executor.map(_finish, *zip(*tasks, strict=True)) if tasks else ())


@contextmanager
def workers(experiment: Experiment, jobs: int | None, advance: Callable[[], None] = lambda: None) -> Iterator[Serial | Pool]:
    """Who does the fitting; ``jobs`` processes (default: one per core)."""
    count = jobs or os.cpu_count() or 1
    if count == 1:
        yield Serial(experiment, advance)
        return
    context = multiprocessing.get_context("spawn")  # forking a process that runs threads is not safe
    with ProcessPoolExecutor(count, context, initializer=_begin, initargs=(experiment,)) as executor:
        yield Pool(executor, count, advance)


def _begin(experiment: Experiment) -> None:
    global _experiment
    _experiment = experiment


def _guess(base: Candidate, effects: list[Effect]) -> list[Guess]:
    assert _experiment is not None
    return guesses(_experiment, base.fit, effects)


def _glance(base: Fit, guess: Guess) -> Fit:
    assert _experiment is not None
    return glance(_experiment, base, guess)


def _finish(base: Fit, quick: Fit) -> Candidate:
    assert _experiment is not None
    return finish(_experiment, base, quick)

"""Fitting candidates one after the other, or in several processes."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager

from hsr_pin.diagnosis.candidates import Candidate, Guess, guesses, try_candidate
from hsr_pin.effects.effect import Effect
from hsr_pin.identification.experiment import Experiment

_experiment: Experiment | None = None  # in a worker process: what it works on, sent once


class Serial:
    """All in this process."""

    def __init__(self, experiment: Experiment, advance: Callable[[], None] = lambda: None) -> None:
        self._experiment, self._advance = experiment, advance

    def guess(self, base: Candidate, effects: Sequence[Effect]) -> list[Guess]:
        """First guesses for adding each effect."""
        return guesses(self._experiment, base.fit, list(effects))

    def fit(self, guesses: Sequence[Guess]) -> list[Candidate]:
        """A candidate for each guess."""
        answers = []
        for guess in guesses:
            answers.append(try_candidate(self._experiment, guess))
            self._advance()
        return answers


class Pool:
    """In several processes; gives what :class:`Serial` gives."""

    def __init__(self, executor: ProcessPoolExecutor, jobs: int, advance: Callable[[], None] = lambda: None) -> None:
        self._executor, self._jobs, self._advance = executor, jobs, advance

    def guess(self, base: Candidate, effects: Sequence[Effect]) -> list[Guess]:
        """First guesses for adding each effect."""
        parts = [list(effects[k :: self._jobs]) for k in range(self._jobs)]
        answers = self._executor.map(_guess, [base] * self._jobs, parts)
        order = {(effect.name, effect.options): place for place, effect in enumerate(effects)}
        found = [guess for answer in answers for guess in answer]
        return sorted(found, key=lambda guess: order[guess.hypothesis.effects[-1].name, guess.hypothesis.effects[-1].options])

    def fit(self, guesses: Sequence[Guess]) -> list[Candidate]:
        """A candidate for each guess."""
        answers = []
        for answer in self._executor.map(_fit, guesses):
            answers.append(answer)
            self._advance()
        return answers


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


def _fit(guess: Guess) -> Candidate:
    assert _experiment is not None
    return try_candidate(_experiment, guess)

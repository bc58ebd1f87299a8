"""Screening, refinement and cross-validation of many candidates side by side, by any executor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor

from hsr_pin.diagnosis.candidates import Candidate, Guess, finish, glance, guesses
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import Part
from hsr_pin.parallel import Shared, run

#: Effects whose probes make one task: they are quick.
_TOGETHER = 3


class Crew:
    """Who does the fitting to one experiment.

    Args:
        experiment: what to fit to.
        executor: who computes.
        advance: called after each fit.
    """

    def __init__(self, experiment: Experiment, executor: Executor, advance: Callable[[], None] = lambda: None) -> None:
        self._shared, self._executor, self._advance = Shared(experiment), executor, advance
        self._guessed: dict[tuple[Candidate, tuple[Part, ...]], list[Guess]] = {}

    def guess(self, base: Candidate, parts: Sequence[Part]) -> list[Guess]:
        """First guesses for adding each part; kept, for a search comes back to models that it left."""
        asked = base, tuple(parts)
        if asked not in self._guessed:
            groups = [parts[k : k + _TOGETHER] for k in range(0, len(parts), _TOGETHER)]
            answers = run(self._executor, _guess, [(self._shared, base.fit, group) for group in groups])
            self._guessed[asked] = [guess for answer in answers for guess in answer]
        return self._guessed[asked]

    def glance(self, tasks: Sequence[tuple[Fit, Guess]]) -> list[Fit]:
        """A quick fit for each guess about a base fit."""
        return run(self._executor, _glance, [(self._shared, *task) for task in tasks], self._advance)

    def finish(self, starts: Sequence[Fit]) -> list[Candidate]:
        """A candidate from where each quick fit ended."""
        return run(self._executor, _finish, [(self._shared, start) for start in starts], self._advance)


def _guess(shared: Shared[Experiment], base: Fit, parts: Sequence[Part]) -> list[Guess]:
    return guesses(shared.get(), base, parts)


def _glance(shared: Shared[Experiment], base: Fit, guess: Guess) -> Fit:
    return glance(shared.get(), base, guess)


def _finish(shared: Shared[Experiment], start: Fit) -> Candidate:
    return finish(shared.get(), start)

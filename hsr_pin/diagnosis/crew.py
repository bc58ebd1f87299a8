"""Screening, refinement and cross-validation of many candidates side by side, by any executor."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor

from hsr_pin.diagnosis.candidates import Candidate, Guess, finish, glance, glanced, guesses
from hsr_pin.diagnosis.where import Where, locate
from hsr_pin.identification.evaluation import predict_all, residuals, rms
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import Part
from hsr_pin.parallel import Shared, begun, run

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
        self._experiment = experiment
        self._shared, self._executor, self._advance = Shared(experiment), executor, advance
        self._guessed: dict[tuple[Candidate, tuple[Part, ...]], list[Guess]] = {}

    @property
    def glanced(self) -> list[int]:
        """Which of the runs quick fits look at."""
        return glanced(self._experiment)

    def where(self, base: Candidate, seed: int) -> Callable[[], Where]:
        """Begin to map what a model misses, beside the fits; and what gives the maps."""
        return begun(self._executor, _where, self._shared, base, seed)

    def misfit(self, start: Fit) -> float:
        """RMS distance [m] where a fit begins."""
        return rms(residuals(self._experiment, predict_all(self._experiment, start.hypothesis, start.values)))

    def guess(self, base: Candidate, parts: Sequence[Part]) -> list[Guess]:
        """First guesses for adding each part; kept, for a search comes back to models that it left."""
        return self.guess_each([(base, parts)])[0]

    def guess_each(self, asked: Sequence[tuple[Candidate, Sequence[Part]]]) -> list[list[Guess]]:
        """The same for several models, side by side."""
        keys = [(base, tuple(parts)) for base, parts in asked]
        new = [key for key in dict.fromkeys(keys) if key not in self._guessed]
        cut = [_cut(parts) for _, parts in new]
        tasks = [(self._shared, key[0].fit, group) for key, groups in zip(new, cut, strict=True) for group in groups]
        answers = iter(run(self._executor, _guess, tasks))
        for key, groups in zip(new, cut, strict=True):
            self._guessed[key] = [guess for _ in groups for guess in next(answers)]
        return [self._guessed[key] for key in keys]

    def glance(self, tasks: Sequence[tuple[Fit, Guess]]) -> list[Fit]:
        """A quick fit for each guess about a base fit."""
        return run(self._executor, _glance, [(self._shared, *task) for task in tasks], self._advance)

    def finish(self, starts: Sequence[Fit]) -> list[Candidate]:
        """A candidate from where each quick fit ended."""
        order = sorted(range(len(starts)), key=lambda k: _labour(starts[k]), reverse=True)
        answers = run(self._executor, _finish, [(self._shared, starts[k]) for k in order], self._advance)
        return [answer for _, answer in sorted(zip(order, answers, strict=True), key=lambda each: each[0])]


def _labour(fit: Fit) -> tuple[bool, int]:
    """More for a fit that takes longer, to begin with: a law with a memory wants short steps, and every number another column."""
    return any(effect.states for effect in fit.hypothesis.effects), len(fit.values)


def _cut(parts: Sequence[Part]) -> list[list[Part]]:
    """A few parts each; the readings of a law that differ in what their size goes with stay together: they share their probes."""
    groups: list[list[Part]] = []
    for part in parts:
        if groups and (len(groups[-1]) < _TOGETHER or part.resized or part.levels):
            groups[-1].append(part)
        else:
            groups.append([part])
    return groups


def _guess(shared: Shared[Experiment], base: Fit, parts: Sequence[Part]) -> list[Guess]:
    return guesses(shared.get(), base, parts)


def _where(shared: Shared[Experiment], base: Candidate, seed: int) -> Where:
    return locate(shared.get(), base, seed)


def _glance(shared: Shared[Experiment], base: Fit, guess: Guess) -> Fit:
    return glance(shared.get(), base, guess)


def _finish(shared: Shared[Experiment], start: Fit) -> Candidate:
    return finish(shared.get(), start)

"""Proposals, quick fits and full fits of many models side by side, by any executor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any, TypeVar

from hsr_pin.inference.candidate import Candidate, full_fit
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.problem import Part, Problem
from hsr_pin.inference.proposals import Proposal, proposals, quick_fit
from hsr_pin.parallel import Shared, begun, run, shared

T = TypeVar("T")

#: Causes whose probes make one task: they are quick.
_TOGETHER = 3


class FitPool:
    """Fits many models to the same recordings.

    Args:
        problem: what to fit to, and who simulates it.
        executor: who computes.
        variants: how many variants of each law are offered.
        advance: called after each fit.
    """

    def __init__(
        self,
        problem: Problem,
        executor: Executor,
        variants: Mapping[str, int] | None = None,
        advance: Callable[[], None] = lambda: None,
    ) -> None:
        self._shared, self._executor, self._advance = shared(problem, executor), executor, advance
        self._variants = dict(variants or {})

    def beside(self, function: Callable[..., T], *arguments: Any) -> Callable[[], T]:
        """Begin ``function(problem, *arguments)`` beside the fits; and what waits for its answer."""
        return begun(self._executor, _with_problem, self._shared, function, arguments)

    def propose(self, asked: Sequence[tuple[Candidate, Sequence[Part]]]) -> list[list[Proposal]]:
        """For each of some models, proposals for adding each of some parts; none for a part that cannot be simulated."""
        cut = [_cut(parts) for _, parts in asked]
        tasks = [(self._shared, base.fit, group) for (base, _), groups in zip(asked, cut, strict=True) for group in groups]
        answers = iter(run(self._executor, _propose, tasks))
        return [[proposal for _ in groups for proposal in next(answers)] for groups in cut]

    def quick(self, tasks: Sequence[tuple[Fit, Proposal]]) -> list[Fit]:
        """A quick fit for each proposal about a base fit."""
        return run(self._executor, _quick, [(self._shared, *task) for task in tasks], self._advance)

    def full(self, starts: Sequence[Fit]) -> list[Candidate]:
        """A candidate from where each fit ended or is to start."""
        order = sorted(range(len(starts)), key=lambda k: _labour(starts[k]), reverse=True)
        tasks = [(self._shared, starts[k], self._variants) for k in order]
        answers = run(self._executor, _full, tasks, self._advance)
        return [answer for _, answer in sorted(zip(order, answers, strict=True), key=lambda each: each[0])]


def _labour(fit: Fit) -> tuple[Any, ...]:
    """More for a fit that takes longer, to begin with: every number is another simulation."""
    return (*fit.hypothesis.labour, len(fit.values))


def _cut(parts: Sequence[Part]) -> list[list[Part]]:
    """A few parts each; variants of a law that differ in what their size goes with stay together: they share their probes."""
    groups: list[list[Part]] = []
    for part in parts:
        if groups and (len(groups[-1]) < _TOGETHER or part.plain.reading != part.reading):
            groups[-1].append(part)
        else:
            groups.append([part])
    return groups


def _with_problem(shared: Shared[Problem], function: Callable[..., T], arguments: tuple[Any, ...]) -> T:
    return function(shared.get(), *arguments)


def _propose(shared: Shared[Problem], base: Fit, parts: Sequence[Part]) -> list[Proposal]:
    return proposals(shared.get(), base, parts)


def _quick(shared: Shared[Problem], base: Fit, proposal: Proposal) -> Fit:
    return quick_fit(shared.get(), base, proposal)


def _full(shared: Shared[Problem], start: Fit, variants: Mapping[str, int]) -> Candidate:
    return full_fit(shared.get(), start, variants)

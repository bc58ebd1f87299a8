"""Proposals, quick fits and full fits of many models in parallel, on any executor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any, TypeVar

from hsr_pin.inference.candidate import Candidate, full_fit
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.problem import Part, Problem
from hsr_pin.inference.proposals import Proposal, proposals, quick_fit
from hsr_pin.parallel import run, shared, start_task, with_shared

T = TypeVar("T")

#: Number of causes whose probes form one task, because a single probe is fast.
_TOGETHER = 3


class FitPool:
    """Pool that fits many models to the same recordings.

    Args:
        problem: the recordings and their simulation.
        executor: executor that runs the fits.
        variants: number of variants of each law in the catalogue.
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

    def submit(self, function: Callable[..., T], *arguments: Any) -> Callable[[], T]:
        """Submit ``function(problem, *arguments)`` in addition to the fits, and return a function that waits for its result."""
        return start_task(self._executor, with_shared, self._shared, function, *arguments)

    def propose(self, asked: Sequence[tuple[Candidate, Sequence[Part]]]) -> list[list[Proposal]]:
        """Return for each model the proposals for adding each of some parts; a part that cannot be simulated has none."""
        cut = [_cut(parts) for _, parts in asked]
        tasks = [
            (self._shared, proposals, base.fit, group) for (base, _), groups in zip(asked, cut, strict=True) for group in groups
        ]
        answers = iter(run(self._executor, with_shared, tasks))
        return [[proposal for _ in groups for proposal in next(answers)] for groups in cut]

    def quick(self, tasks: Sequence[tuple[Fit, Proposal]]) -> list[Fit]:
        """Return a quick fit for each pair of a base fit and a proposal."""
        return run(self._executor, with_shared, [(self._shared, quick_fit, *task) for task in tasks], self._advance)

    def full(self, starts: Sequence[Fit]) -> list[Candidate]:
        """Return a candidate from a full fit for each start, in the order of the starts."""
        order = sorted(range(len(starts)), key=lambda k: _labour(starts[k]), reverse=True)
        tasks = [(self._shared, full_fit, starts[k], self._variants) for k in order]
        answers = run(self._executor, with_shared, tasks, self._advance)
        return [answer for _, answer in sorted(zip(order, answers, strict=True), key=lambda each: each[0])]


def _labour(fit: Fit) -> tuple[Any, ...]:
    """Return the sort key of a fit's duration: the cost of its model, then its number of parameters (one simulation each)."""
    return (*fit.hypothesis.cost, len(fit.values))


def _cut(parts: Sequence[Part]) -> list[list[Part]]:
    """Return groups of a few parts; each group is one task.

    Variants of a law that differ only in how their size depends on the stiffness level stay together, because they share probes.
    """
    groups: list[list[Part]] = []
    for part in parts:
        if groups and (len(groups[-1]) < _TOGETHER or part.base_variant.variant != part.variant):
            groups[-1].append(part)
        else:
            groups.append([part])
    return groups

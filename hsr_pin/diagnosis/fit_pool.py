"""Proposals, quick fits and full fits of many models side by side, by any executor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor

from hsr_pin.diagnosis.candidate import Candidate, full_fit
from hsr_pin.diagnosis.proposals import Proposal, proposals, quick_fit
from hsr_pin.diagnosis.where import Where, locate
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import Part
from hsr_pin.parallel import Shared, begun, run

#: Effects whose probes make one task: they are quick.
_TOGETHER = 3


class FitPool:
    """Fits many models to one experiment.

    Args:
        experiment: what to fit to.
        executor: who computes.
        variants: how many variants of each law are offered.
        advance: called after each fit.
    """

    def __init__(
        self,
        experiment: Experiment,
        executor: Executor,
        variants: Mapping[str, int] | None = None,
        advance: Callable[[], None] = lambda: None,
    ) -> None:
        self.experiment = experiment
        self._shared, self._executor, self._advance = Shared(experiment), executor, advance
        self._variants = dict(variants or {})

    def where(self, base: Candidate, seed: int) -> Callable[[], Where]:
        """Begin to map what a model misses, beside the fits; and what gives the maps."""
        return begun(self._executor, _where, self._shared, base, seed)

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


def _labour(fit: Fit) -> tuple[bool, int]:
    """More for a fit that takes longer, to begin with: a law with a memory wants short steps, and every number another column."""
    return any(effect.states for effect in fit.hypothesis.effects), len(fit.values)


def _cut(parts: Sequence[Part]) -> list[list[Part]]:
    """A few parts each; variants of a law that differ in what their size goes with stay together: they share their probes."""
    groups: list[list[Part]] = []
    for part in parts:
        if groups and (len(groups[-1]) < _TOGETHER or part.resized or part.levels):
            groups[-1].append(part)
        else:
            groups.append([part])
    return groups


def _propose(shared: Shared[Experiment], base: Fit, parts: Sequence[Part]) -> list[Proposal]:
    return proposals(shared.get(), base, parts)


def _where(shared: Shared[Experiment], base: Candidate, seed: int) -> Where:
    return locate(shared.get(), base, seed)


def _quick(shared: Shared[Experiment], base: Fit, proposal: Proposal) -> Fit:
    return quick_fit(shared.get(), base, proposal)


def _full(shared: Shared[Experiment], start: Fit, variants: Mapping[str, int]) -> Candidate:
    return full_fit(shared.get(), start, variants)

"""How many links: what a coarser chain costs in error, beside what the data can show, and what a finer one costs in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from hsr_pin.identification.evaluation import predict, rms, squared_distance
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.fit import fit
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.robot.specification import Placement
from hsr_pin.trajectory import Array

LINKS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16)
#: The chain and step taken as converged; the study's own simulations are exact in time to well below their differences.
CONVERGED_LINKS, CONVERGED_STEP = 40, 0.005
_STEP = 0.005


@dataclass(frozen=True)
class LinksRow:
    """One number of links.

    Attributes:
        links: N.
        model_error: [m] RMS distance of its markers from those of the converged chain, with the same parameters.
        data_error: [m] RMS distance from the measured ones, with parameters fitted on this very chain.
        evaluations: articulated-body passes of one simulation of the dataset, times N: what it costs, in links advanced.
        cost: that, over the cheapest's.
    """

    links: int
    model_error: float
    data_error: float
    evaluations: int
    cost: float


@dataclass(frozen=True)
class LinksStudy:
    """A study over N.

    Attributes:
        rows: by increasing N.
        placement: of the joints.
        noise: [m] RMS distance that noise alone leaves.
        recommended: the N to use; None if none of those tried is good enough.
        sentence: why.
    """

    rows: tuple[LinksRow, ...]
    placement: Placement
    noise: float
    recommended: int | None
    sentence: str


def links_study(
    experiment: Experiment,
    hypothesis: Hypothesis,
    values: Array,
    *,
    links: Sequence[int] = LINKS,
    tell: Callable[[str], None] = lambda line: None,
) -> LinksStudy:
    """Compare chains of different numbers of links, joints placed as in ``hypothesis``.

    Args:
        experiment: the dataset.
        hypothesis: the model; its own number of links does not matter.
        values: (P,) of its open parameters, fitted with correction for the coarse chain.
        links: the numbers to try.
        tell: called with a line for each.
    """
    converged = _positions(experiment, hypothesis.finer(CONVERGED_LINKS, CONVERGED_STEP), values)
    rows: list[LinksRow] = []
    steps = sum(len(run.time) * max(1, round(run.step / _STEP)) for run in experiment.runs)
    for count in sorted(set(links)):
        tell(f"{count} links")
        chain = hypothesis.with_chain(count, _STEP)
        away = [own - fine for own, fine in zip(_positions(experiment, chain, values), converged, strict=True)]
        fitted = fit(experiment, chain, start=values, corrected=False)
        evaluations = 2 * steps * count
        cost = evaluations / rows[0].evaluations if rows else 1.0
        rows.append(LinksRow(count, _distance(away), rms(fitted.residuals), evaluations, cost))
    recommended, sentence = _recommend(rows, experiment.noise_rms, experiment.dataset.length)
    return LinksStudy(tuple(rows), hypothesis.placement, experiment.noise_rms, recommended, sentence)


def _positions(experiment: Experiment, hypothesis: Hypothesis, values: Array) -> list[Array]:
    return [p.positions for p in predict(experiment, hypothesis, [(run, values) for run in experiment.runs])]


def _distance(away: Sequence[Array]) -> float:
    """RMS distance [m] where both chains could be simulated."""
    squares = np.concatenate([squared_distance(part) for part in away])
    return float(np.sqrt(squares.mean())) if len(squares) else float("nan")


def _recommend(rows: Sequence[LinksRow], noise: float, length: float) -> tuple[int | None, str]:
    """The fewest links whose own error is below half the noise floor, or below a thousandth of the length where noise is less."""
    limit, what = (noise / 2, "half the noise floor") if noise / 2 > 1e-3 * length else (1e-3 * length, "0.1 % of the length")
    good = [row for row in rows if row.model_error < limit]
    if not good:
        return None, f"None of these is within {what} ({1e3 * limit:.2g} mm) of the converged chain: take more links."
    first = good[0]
    most = max(rows, key=lambda row: row.links)
    gain = first.data_error - most.data_error
    more = "more buys nothing" if gain < limit / 10 else f"{most.links} links take another {1e3 * gain:.2g} mm off the data error"
    return first.links, (
        f"N = {first.links} is within {what}: {1e3 * first.model_error:.2g} mm from the converged chain "
        f"(limit {1e3 * limit:.2g} mm); {more}."
    )

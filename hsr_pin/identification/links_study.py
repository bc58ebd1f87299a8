"""How many links: what a coarser chain costs in error, beside what the data can show, and what a finer one costs in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hsr_pin.identification.evaluation import predict_all
from hsr_pin.identification.experiment import Experiment
from hsr_pin.identification.hypothesis import Hypothesis
from hsr_pin.inference.fit import fit
from hsr_pin.inference.residuals import rms, squared_distance
from hsr_pin.robot.specification import Placement
from hsr_pin.trajectory import Array

LINKS = (1, 2, 3, 4, 5, 6, 8, 10, 12, 16)
#: The chain taken as converged, and the error of a step [m at the tip]: well below the differences between chains.
CONVERGED_LINKS, TOLERANCE = 40, 5e-5


@dataclass(frozen=True)
class LinksRow:
    """One number of links.

    Attributes:
        links: N.
        model_error: [m] RMS distance of its markers from those of the converged chain, with the same parameters.
        data_error: [m] RMS distance from the measured ones, with parameters fitted on this very chain.
        cost: of a simulation, over that of the smallest number of links: they grow with N.
    """

    links: int
    model_error: float
    data_error: float
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
        values: (P,) of its open parameters, fitted.
        links: the numbers to try.
        tell: called with a line for each.
    """
    converged = _positions(experiment, replace(hypothesis, links=CONVERGED_LINKS, tolerance=TOLERANCE), values)
    rows: list[LinksRow] = []
    for count in sorted(set(links)):
        tell(f"{count} links")
        chain = replace(hypothesis, links=count, tolerance=TOLERANCE)
        away = [own - fine for own, fine in zip(_positions(experiment, chain, values), converged, strict=True)]
        fitted = fit(experiment, chain, start=values)
        rows.append(LinksRow(count, _distance(away), rms(fitted.residuals), count / min(links)))
    recommended, sentence = _recommend(rows, experiment.noise_rms, experiment.dataset.length)
    return LinksStudy(tuple(rows), hypothesis.placement, experiment.noise_rms, recommended, sentence)


def _positions(experiment: Experiment, hypothesis: Hypothesis, values: Array) -> list[Array]:
    return [p.positions for p in predict_all(experiment, hypothesis, values)]


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

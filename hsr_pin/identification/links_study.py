"""Study of the number of links: the error of coarse chains compared with the noise of the data, and the cost of fine chains."""

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
#: Number of links of the reference chain, and the tolerance of a step [m at the tip], well below the differences between chains.
CONVERGED_LINKS, TOLERANCE = 40, 5e-5


@dataclass(frozen=True)
class LinksRow:
    """The results for one number of links.

    Attributes:
        links: number of links N.
        model_error: RMS distance of the markers from those of the reference chain with the same parameters [m].
        data_error: RMS distance from the measured markers, with parameters fitted on this chain [m].
        cost: cost of a simulation relative to that of the smallest number of links; it increases with N.
    """

    links: int
    model_error: float
    data_error: float
    cost: float


@dataclass(frozen=True)
class LinksStudy:
    """A study of the number of links.

    Attributes:
        rows: the results by increasing N.
        placement: placement of the joints.
        noise: RMS distance due to noise alone [m].
        recommended: the recommended N; None if no tried chain is good enough.
        sentence: the reason for the recommendation.
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
    """Compare chains with different numbers of links, with the joint placement of ``hypothesis``.

    Args:
        experiment: the dataset.
        hypothesis: the model; its own number of links is ignored.
        values: (P,) fitted values of its open parameters.
        links: the numbers of links to compare.
        tell: function that is called with a line for each number.
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
    """Return the RMS distance [m] over the samples that both chains could simulate."""
    squares = np.concatenate([squared_distance(part) for part in away])
    return float(np.sqrt(squares.mean())) if len(squares) else float("nan")


def _recommend(rows: Sequence[LinksRow], noise: float, length: float) -> tuple[int | None, str]:
    """Return the smallest number of links whose model error is small enough, with a sentence.

    The limit is half the noise floor, or a thousandth of the length if that is larger.
    """
    limit, what = (noise / 2, "half the noise floor") if noise / 2 > 1e-3 * length else (1e-3 * length, "0.1 % of the length")
    good = [row for row in rows if row.model_error < limit]
    if not good:
        return None, f"None of these chains is within {what} ({1e3 * limit:.2g} mm) of the converged chain; use more links."
    first = good[0]
    most = max(rows, key=lambda row: row.links)
    gain = first.data_error - most.data_error
    better = f"{most.links} links reduce the data error by another {1e3 * gain:.2g} mm"
    more = "more links do not reduce the data error" if gain < limit / 10 else better
    return first.links, (
        f"N = {first.links} is within {what}: {1e3 * first.model_error:.2g} mm from the converged chain "
        f"(limit {1e3 * limit:.2g} mm); {more}."
    )

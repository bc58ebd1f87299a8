"""What speaks for each part of a model, and for each kind of physics, without asking that the model closes the gap.

A part is supported if it takes away much of the gap; if every model without it, however mended, is certainly and clearly worse
(a model confidence set: P. R. Hansen, A. Lunde, J. M. Nason, Econometrica 79, 2011); if it has the same size wherever it acts, in
every level, amplitude, direction and half of the record (invariance: J. Peters, P. Buehlmann, N. Meinshausen, J. R. Stat. Soc. B
78, 2016), as a true law has and a stand-in has not; and if that size is far from none.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.evidence import frequency_of_gain, squares, structure
from hsr_pin.diagnosis.thresholds import SURE, Thresholds, doubtful, open_share, tolerated
from hsr_pin.identification.experiment import Experiment, Run
from hsr_pin.identification.fit import Fit
from hsr_pin.identification.hypothesis import PLAIN
from hsr_pin.identification.step import damped_inverse
from hsr_pin.identification.uncertainty import clearness
from hsr_pin.trajectory import Array


@dataclass(frozen=True)
class Support:
    """For one part, or one kind.

    Attributes:
        name: of the effect, of the open number of the arm, or of the kind.
        kind: of physics.
        share: of the squared gap, by how much the best model without it (of no more parts) leaves more.
        lead: that, over all that the best model takes away: 1 where nothing else helps at all.
        margin: that, over the difference that is tolerated in a model that is not exact.
        frequency: of resampled trials, in how many the best model is better than that one.
        drift: RMS difference of its size between environments, beyond noise, over its size; NaN where it acts in one alone.
        clear: standard errors of its size from none.
        rest: share of the squared gap that the best model leaves, beyond what does not repeat.
        shown: 1 where the recordings point to its kind without a model, -1 where they do not though they would; 0 for kinds of
            which that tells nothing.
    """

    name: str
    kind: str
    share: float
    lead: float
    margin: float
    frequency: float
    drift: float
    clear: float
    rest: float
    shown: float = 0.0


#: Kinds that show without a model, if they are there: as steps that come late, bending that goes on, loops.
TO_BE_SEEN = ("actuation_time", "creep", "friction")

#: Support for a choice of sets of names: that one of them is right.
Together = Callable[[Sequence[tuple[str, ...]]], Support]


def supports(
    experiment: Experiment,
    best: Candidate,
    base: Candidate,
    tried: Sequence[Candidate],
    thresholds: Thresholds,
    seed: int,
    shown: Collection[str],
) -> tuple[tuple[Support, ...], tuple[Support, ...], Together]:
    """For each part of the best model, for each of its kinds, and for any sets of names together.

    Args:
        experiment: the recordings.
        best: the model.
        base: stiffness and damping fitted, nothing else.
        tried: every fitted model.
        thresholds: what counts.
        seed: of the resampling.
        shown: kinds that the recordings point to without a model.
    """
    drifts, clear = drift(experiment, best.fit), clearness(best.fit)
    gap, left, limit = structure(base.heldout), structure(best.heldout), tolerated(best, thresholds)
    rest = open_share(best, base, thresholds)

    def of(name: str, kind: str, lacks: Callable[[Candidate], bool], parts: Sequence[str] = ()) -> Support:
        as_small = (other for other in tried if len(other.names) <= len(best.names) and not other.bends_more(best))
        without = [base, *(other for other in as_small if lacks(other))]
        ranked = sorted(without, key=lambda other: squares(other.heldout).mean)
        own = parts or [part.name for part in best.fit.hypothesis.parts if name in (part.name, part.kind)]
        surest = max(clear[each] for each in own)
        least = min(SURE, surest)  # what is in more doubt itself is no rival
        rival = next(other for other in ranked if other is base or not doubtful(other, least))
        gain = squares(rival.heldout).mean - squares(best.heldout).mean
        known = [drifts[each] for each in own if np.isfinite(drifts[each])]
        return Support(
            name=name,
            kind=kind,
            share=gain / max(gap, limit),
            lead=gain / max(gap - left, limit),
            margin=gain / limit,
            frequency=frequency_of_gain(best.heldout, rival.heldout, seed),
            drift=float(np.mean(known)) if known else float("nan"),
            clear=surest,
            rest=rest,
            shown=shows(kind, shown),
        )

    near = [each for each in (best, *tried) if squares(each.heldout).mean - squares(best.heldout).mean <= limit]

    def clearest(kind: str) -> float:  # of the laws of a kind in models that do about as well
        own = (each for each in near if len(each.names) <= len(best.names))
        return max(clearness(each.fit)[part.name] for each in own for part in each.fit.hypothesis.parts if part.kind == kind)

    parts = tuple(
        of(part.name, part.kind, lambda other, name=part.name: name not in other.names and not other.contains(best))  # type: ignore[misc]
        for part in best.fit.hypothesis.parts
    )
    kinds = tuple(
        replace(of(kind, kind, lambda other, kind=kind: kind not in other.kinds), clear=clearest(kind))  # type: ignore[misc]
        for kind in best.kinds
    )

    def together(sets: Sequence[tuple[str, ...]]) -> Support:
        told = [other for other in tried if other.names in sets]

        def lacks(other: Candidate) -> bool:  # a law that has one of them for a special case does not lack it
            return not any(set(each.names) <= set(other.names) or other.contains(each) for each in told)

        surest = max((value for each in told for value in clearness(each.fit).values()), default=0.0)
        return replace(of("", "", lacks, best.names), clear=surest)

    return parts, kinds, together


def shows(kind: str, pointed_to: Collection[str]) -> float:
    """Whether a kind that recordings would point to without a model is among those that they do: 1 or -1; 0 for other kinds."""
    return 0.0 if kind not in TO_BE_SEEN else 1.0 if kind in pointed_to else -1.0


def drift(experiment: Experiment, fit: Fit) -> dict[str, float]:
    """For each part how much its size differs between environments, over its size: one Gauss-Newton step in each of them."""
    model = fit.hypothesis
    amplitudes = {
        part.name: [k for k, f in enumerate(model.parameters) if _owner(f.name) == part.name and (f.amplitude or f.name in PLAIN)]
        for part in model.parts
    }
    squares_of: dict[str, list[float]] = {name: [] for name in amplitudes}
    for masks in environments(experiment, fit):
        estimates = [_step(fit, chosen) for chosen in masks]
        for name, places in amplitudes.items():
            size = np.array([fit.values[k] - model.parameters[k].neutral for k in places])
            weight = float(size @ size)
            if weight <= 0:
                continue
            for one in range(len(estimates)):
                for other in range(one):
                    (a, va), (b, vb) = estimates[one], estimates[other]
                    difference = (a - b)[places]
                    noise = float((va + vb)[places].sum())
                    if noise < weight:  # an environment in which it hardly acts tells nothing
                        squares_of[name].append(max(0.0, float(difference @ difference) - noise) / weight)
    return {name: sqrt(float(np.mean(found))) if found else float("nan") for name, found in squares_of.items()}


def _owner(name: str) -> str:
    return name.partition(".")[0]


def environments(experiment: Experiment, fit: Fit) -> Iterator[list[list[NDArray[np.bool_]]]]:
    """Ways to cut the recordings in two or more, each as masks (T,) for each run in each part."""
    runs = experiment.runs
    whole = [np.ones(len(run.time), dtype=bool) for run in runs]
    none = [np.zeros(len(run.time), dtype=bool) for run in runs]

    def by(labels: Sequence[object]) -> list[list[NDArray[np.bool_]]]:
        return [
            [w if own == label else n for w, n, own in zip(whole, none, labels, strict=True)] for label in dict.fromkeys(labels)
        ]

    sizes = [_size(run) for run in runs]
    cuts: list[Sequence[object]] = [
        [run.trial.keq for run in runs],
        [bool(abs(size) > np.median(np.abs(sizes))) for size in sizes],
        [size.real > 0 for size in sizes],
        [size.imag > 0 for size in sizes],
        [run.trial.tip_mass for run in runs],
        [k % 2 for k in range(len(runs))],
    ]
    for labels in cuts:
        if len(set(labels)) > 1:
            yield by(labels)
    yield [
        [np.arange(len(run.time)) < len(run.time) // 2 for run in runs],
        [np.arange(len(run.time)) >= len(run.time) // 2 for run in runs],
    ]


def _size(run: Run) -> complex:
    """How far a run goes, with its side: the torque of largest size, or how far aside the arm is held."""
    if run.span > 0:
        return complex(run.torque[np.argmax(np.abs(run.torque - run.torque[0]))])
    seen: NDArray[np.bool_] = np.asarray(np.isfinite(run.compared).all(axis=2))
    marker = max(k for k in range(seen.shape[1]) if seen[:, k].sum() >= 0.5 * seen.sum(axis=0).max())
    places = run.compared[seen[:, marker], marker]
    moved = places - np.median(places, axis=0)
    far = moved[int(np.argmax((moved**2).sum(axis=1)))]
    if len(far) == 2:
        return complex(far[np.argmax(np.abs(far))])
    return complex(*far[np.sort(np.argsort(moved.std(axis=0))[1:])])  # the two coordinates in which it moves most


def _step(fit: Fit, masks: Sequence[NDArray[np.bool_]]) -> tuple[Array, Array]:
    """Where the fit would go on a part of the data alone, and the variance of each value (P,).

    Residuals last: they count for as many as their correlation says.
    """
    scale, rows, slopes, last = fit.hypothesis.scale, [], [], []
    for k, mask in enumerate(masks):
        weights = fit.weights[k] * mask[:, None, None]
        seen = weights > 0
        if not seen.any():
            continue
        without = fit.eliminated(k, mask[:, None, None])
        r = np.nan_to_num(fit.residuals[k]) * weights
        rows.append(without((np.nan_to_num(fit.missed[k]) * weights)[seen]))
        slopes.append(without((fit.slopes[k] * weights[..., None] * scale)[seen]))
        last.append(float((r[1:] * r[:-1]).sum() / max((r**2).sum(), 1e-300)))
    if not rows:
        return fit.values.copy(), np.full(len(fit.values), np.inf)
    residual, J = np.concatenate(rows), np.vstack(slopes)
    inverse = damped_inverse(J, 1e-3)
    rho = float(np.clip(np.mean(last), 0.0, 0.999))
    variance = float(residual @ residual) / max(len(residual) - len(scale), 1) * (1 + rho) / (1 - rho)
    step = np.clip(-inverse @ (J.T @ residual), -3.0, 3.0)
    return fit.values + scale * step, scale**2 * np.diag(inverse) * variance

"""The result of a search as plain numbers, texts, lists and dictionaries for JSON; unknown values are null."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np

from hsr_pin.inference.calibration import calibrated
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.decision import Decision, Loss
from hsr_pin.inference.estimates import estimates
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.model import Model
from hsr_pin.inference.search import Search
from hsr_pin.inference.verdict import Verdict


def number_or_null(value: float) -> float | None:
    """Return a finite number, or None."""
    return float(value) if math.isfinite(value) else None


def millimetres_or_null(metres: float) -> float | None:
    """Return a finite length in mm, or None."""
    return number_or_null(1e3 * metres)


def verdict_to_json(verdict: Verdict) -> dict[str, Any]:
    """Return a verdict as a dictionary, without the remaining gap."""
    return {
        "status": verdict.status,
        "effects": sorted(verdict.effects),
        "alternatives": [sorted(names) for names in verdict.alternatives],
        "sentence": verdict.sentence,
        "kinds": list(verdict.kinds),
        "confidence": {name: number_or_null(value) for name, value in sorted(verdict.confidence.items())},
    }


def posterior_to_json(search: Search, decision: Decision | None, loss: Loss) -> dict[str, Any]:
    """Return the probabilities of all sets of causes, the loss table and the expected gain of the report as a dictionary."""
    return {
        "sets": [
            {"effects": list(names), "probability": number_or_null(probability)}
            for names, probability in search.posterior.sets.items()
        ],
        "loss": asdict(loss),
        "expected_gain": None if decision is None else number_or_null(decision.gain),
        "probability": None if decision is None else number_or_null(decision.probability),
        "calibration": asdict(calibrated()),
        "data": {name: np.asarray(value).tolist() for name, value in asdict(search.data).items() if name != "groups"}
        | {"groups": [list(own) for own in search.data.groups]},
        "unfitted": [judged_to_json(model) for model in search.posterior.models[len(search.candidates) :]],
    }


def candidates_to_json(search: Search, shown: Callable[[Candidate], dict[str, Any]]) -> list[dict[str, Any]]:
    """Return all fitted models as dictionaries made by ``shown``, the smallest error on held-out trials first.

    Special cases of a model are given by their indices in the list.
    """
    found, every = search.posterior, search.candidates
    order = sorted(range(len(every)), key=lambda k: (every[k].heldout_square, every[k].names))
    place = {k: n for n, k in enumerate(order)}
    return [
        shown(every[k])
        | {
            "probability": number_or_null(found.probabilities[k]),
            "log_evidence": number_or_null(found.evidence[k]),
            **judged_to_json(every[k].model),
            "special_cases": sorted(place[n] for n, other in enumerate(every) if other.special_case_of(every[k])),
        }
        for k in order
    ]


def judged_to_json(model: Model) -> dict[str, Any]:
    """Return the summary of a model from which its evidence is computed."""
    return {
        "causes": [asdict(cause) for cause in model.causes],
        "misfit": number_or_null(model.misfit),
        "misfits": [number_or_null(value) for value in model.misfits],
        "information": model.information.tolist(),
        "departures": [number_or_null(value) for value in model.departures],
        "errors": [number_or_null(value) for value in model.errors],
    }


def detection_to_json(search: Search) -> list[dict[str, Any]]:
    """Return the detection limits; a size of null could not have been found within the bounds of the parameter."""
    return [
        {"effect": each.cause, "parameter": each.parameter, "size": each.size, "unit": each.unit} for each in search.detection
    ]


def estimates_to_json(fit: Fit) -> dict[str, Any]:
    """Return every free parameter with its value, unit and 95 % interval."""
    return {
        each.name: {
            "value": number_or_null(each.value),
            "unit": each.unit,
            "ci95": [number_or_null(bound) for bound in each.interval],
        }
        for each in sorted(estimates(fit), key=lambda each: each.name)
    }

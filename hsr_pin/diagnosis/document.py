"""A diagnosis as one JSON document, for programs.

Lengths are in mm (but for ``arm``: SI units) and shares from 0 to 1; what is not known is null. Schema 2 has ``posterior`` and
``limits`` in place of the ``support``, ``thresholds`` and ``damping_held`` of schema 1.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from hsr_pin.diagnosis.result import Diagnosis
from hsr_pin.diagnosis.where import Map, Where
from hsr_pin.identification.arm_document import arm_to_json
from hsr_pin.inference import Decision, Loss, Model
from hsr_pin.inference.calibration import calibrated
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.estimates import estimates
from hsr_pin.inference.ladder import Rung
from hsr_pin.inference.search import Search
from hsr_pin.inference.verdict import Left

SCHEMA = 2


def to_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """The document: plain numbers, texts, lists and dictionaries, as ``json.dumps(..., allow_nan=False)`` takes them."""
    verdict, length = diagnosis.verdict, diagnosis.experiment.dataset.length
    return {
        "schema": SCHEMA,
        "dataset": diagnosis.experiment.dataset.name,
        "verdict": {
            "status": verdict.status,
            "effects": sorted(verdict.effects),
            "alternatives": [sorted(names) for names in verdict.alternatives],
            "sentence": verdict.sentence,
            "kinds": list(verdict.kinds),
            "confidence": {name: _number(value) for name, value in sorted(verdict.confidence.items())},
            "left": _left(verdict.left),
        },
        "posterior": None if diagnosis.search is None else _posterior(diagnosis.search, verdict.decision, diagnosis.loss),
        "arm": None if diagnosis.search is None else arm_to_json(diagnosis.experiment, diagnosis.search.best.fit),
        "ladder": [_rung(rung, length) for rung in diagnosis.ladder],
        "noise_floor_mm": _mm(diagnosis.experiment.noise_rms),
        "candidates": [] if diagnosis.search is None else _candidates(diagnosis.search),
        "where": _where(diagnosis.where),
        "next_experiment": [{"name": each.name, "separation": _number(each.separation)} for each in diagnosis.next_experiment],
        "limits": {"closed_mm": _mm(diagnosis.limits.closed), "share": _number(diagnosis.limits.share)},
        "fingerprint": None if diagnosis.fingerprint is None else diagnosis.fingerprint.to_json(),
        "repeats": None if diagnosis.repeats is None else diagnosis.repeats.to_json(),
        "notes": list(diagnosis.experiment.notes),
    }


def _posterior(search: Search, decision: Decision | None, loss: Loss) -> dict[str, Any]:
    """Probabilities of all sets of causes, the loss, and what the report was expected to gain by it."""
    return {
        "sets": [
            {"effects": list(names), "probability": _number(probability)} for names, probability in search.posterior.sets.items()
        ],
        "loss": asdict(loss),
        "expected_gain": None if decision is None else _number(decision.gain),
        "probability": None if decision is None else _number(decision.probability),
        "calibration": asdict(calibrated()),
        "data": asdict(search.data),
        "unfitted": [_judged(model) for model in search.posterior.models[len(search.candidates) :]],
    }


def _candidates(search: Search) -> list[dict[str, Any]]:
    """Every fitted model, the smallest error on held-out trials first; special cases are told by their place in the list."""
    found, every = search.posterior, search.candidates
    order = sorted(range(len(every)), key=lambda k: (every[k].heldout_square, every[k].names))
    place = {k: n for n, k in enumerate(order)}
    return [
        _candidate(every[k])
        | {
            "probability": _number(found.probabilities[k]),
            "log_evidence": _number(found.evidence[k]),
            **_judged(every[k].model),
            "special_cases": sorted(place[n] for n, other in enumerate(every) if other.special_case_of(every[k])),
        }
        for k in order
    ]


def _judged(model: Model) -> dict[str, Any]:
    """All that the judgement knows of a model."""
    return {
        "causes": [asdict(cause) for cause in model.causes],
        "misfit": _number(model.misfit),
        "information": [_number(value) for value in model.information],
        "departures": [_number(value) for value in model.departures],
    }


def _left(left: Left | None) -> dict[str, float | None] | None:
    if left is None:
        return None
    return {
        "mm": _mm(left.rms),
        "percent_of_length": _number(100 * left.rms / left.length),
        "share": _number(left.share),
        "not_repeatable_mm": None if left.not_repeatable is None else _mm(left.not_repeatable),
    }


def _rung(rung: Rung, length: float) -> dict[str, Any]:
    return {
        "rung": rung.name,
        "effects": sorted(rung.effects),
        "heldout_rms_mm": _mm(rung.rms),
        "heldout_rms_percent": _number(100 * rung.rms / length),
        "share": _number(rung.share),
        "ci95_mm": [_mm(bound) for bound in rung.interval],
    }


def _candidate(candidate: Candidate) -> dict[str, Any]:
    effects = candidate.fit.hypothesis.effects
    return {
        "effects": list(candidate.names),
        "resized": list(candidate.fit.hypothesis.resized),
        "options": dict(sorted((f"{effect.name}.{name}", value) for effect in effects for name, value in effect.options)),
        "parameters": {
            each.name: {"value": _number(each.value), "unit": each.unit, "ci95": [_number(bound) for bound in each.interval]}
            for each in sorted(estimates(candidate.fit), key=lambda each: each.name)
        },
        "heldout_rms_mm": _mm(math.sqrt(candidate.heldout_square)),
        "fit_rms_mm": _mm(candidate.fit.rms),
    }


def _where(where: Where | None) -> dict[str, Any]:
    if where is None:
        return {
            "arc_length": {},
            "time": {},
            "operating_range": {},
            "trials": {},
            "sentence": "",
            "frequency_hz": None,
            "defect": None,
            "base": None,
            "pulsation": None,
        }
    centre, *interval = (None,) if where.defect is None else map(_number, where.defect)
    return {
        "arc_length": _map(where.arc_length),
        "time": _map(where.time),
        "operating_range": {each.quantity.replace(" ", "_"): _map(each) for each in where.operating_range},
        "trials": _map(where.trials),
        "sentence": where.sentence,
        "frequency_hz": None if where.frequency is None else _number(where.frequency),
        "defect": None if where.defect is None else {"centre": centre, "ci95": interval},
        "base": None if where.base is None else {"foretold": _number(where.base.foretold)},
        "pulsation": None if where.pulsation is None else {k: _number(v) for k, v in asdict(where.pulsation).items()},
    }


def _map(chart: Map) -> dict[str, Any]:
    return {
        "quantity": chart.quantity,
        "unit": chart.unit,
        "bins": [
            {"label": part.label, "value": _number(part.value), "share": _number(part.share), "noise": _number(part.noise)}
            for part in chart.bins
        ],
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _mm(metres: float) -> float | None:
    return _number(1e3 * metres)

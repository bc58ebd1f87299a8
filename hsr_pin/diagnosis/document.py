"""A diagnosis as one JSON document, for programs.

Lengths are in mm (but for ``arm``: SI units) and shares from 0 to 1; what is not known is null. The fields of schema 1 stay;
others may be added.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from hsr_pin.diagnosis.candidates import Candidate
from hsr_pin.diagnosis.diagnose import Diagnosis
from hsr_pin.diagnosis.estimates import estimates
from hsr_pin.diagnosis.held_damping import HeldDamping
from hsr_pin.diagnosis.ladder import Rung
from hsr_pin.diagnosis.thresholds import mean_square
from hsr_pin.diagnosis.verdict import Left
from hsr_pin.diagnosis.where import Map, Where
from hsr_pin.identification.arm_document import arm_to_json

SCHEMA = 1


def to_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """The document: plain numbers, texts, lists and dictionaries, as ``json.dumps(..., allow_nan=False)`` takes them."""
    verdict, length = diagnosis.verdict, diagnosis.experiment.dataset.length
    tried = () if diagnosis.search is None else diagnosis.search.tried
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
            "support": [
                {k: _number(v) if isinstance(v, float) else v for k, v in asdict(each).items()} for each in verdict.support
            ],
        },
        "arm": None if diagnosis.search is None else arm_to_json(diagnosis.experiment, diagnosis.search.best.fit),
        "ladder": [_rung(rung, length) for rung in diagnosis.ladder],
        "noise_floor_mm": _mm(diagnosis.experiment.noise_rms),
        "candidates": [_candidate(each) for each in sorted(tried, key=lambda each: (mean_square(each), each.names))],
        "where": _where(diagnosis.where),
        "next_experiment": [{"name": each.name, "separation": _number(each.separation)} for each in diagnosis.next_experiment],
        "thresholds": {
            "worth_mm": _mm(diagnosis.thresholds.worth),
            "closed_mm": _mm(diagnosis.thresholds.closed),
            "explained": _number(diagnosis.thresholds.explained),
        },
        "fingerprint": None if diagnosis.fingerprint is None else diagnosis.fingerprint.to_json(),
        "repeats": None if diagnosis.repeats is None else diagnosis.repeats.to_json(),
        "damping_held": None if diagnosis.held is None else _held(diagnosis.held),
        "notes": list(diagnosis.experiment.notes),
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


def _held(held: HeldDamping) -> dict[str, Any]:
    alone, best = map(_number, held.damping)
    slow, others = map(_number, held.shares)
    return {
        "damping_scale": {"alone": alone, "best": best},
        "late": {"effects": list(held.slow), "share": slow},
        "others": {"effects": list(held.others), "share": others},
        "model": _candidate(held.model),
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
        "heldout_rms_mm": _mm(math.sqrt(mean_square(candidate))),
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
            "spread": None,
            "spread_beside_arm": None,
            "base": None,
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
        "spread": _shares(where.spread.left) if where.spread else None,
        "spread_beside_arm": _shares(where.spread.beside) if where.spread and where.spread.beside else None,
        "base": None if where.base is None else {"foretold": _number(where.base.foretold)},
    }


def _shares(left: Mapping[str, float]) -> dict[str, Any]:
    return {shape: _number(share) for shape, share in left.items()}


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

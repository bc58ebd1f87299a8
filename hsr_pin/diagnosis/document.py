"""A diagnosis as one JSON document.

Lengths are in mm (except for ``arm``, which is in SI units), shares range from 0 to 1, and unknown values are null. Schema 2 has
``posterior`` and ``limits`` in place of the ``support``, ``thresholds`` and ``damping_held`` of schema 1.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from hsr_pin.diagnosis.where import Map, Where
from hsr_pin.identification.arm_document import arm_to_json
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.document import (
    candidates_to_json,
    detection_to_json,
    estimates_to_json,
    millimetres_or_null,
    number_or_null,
    posterior_to_json,
    verdict_to_json,
)
from hsr_pin.inference.ladder import Rung
from hsr_pin.inference.verdict import Remainder

if TYPE_CHECKING:
    from hsr_pin.diagnosis.result import Diagnosis

SCHEMA = 2


def to_json(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the document as plain numbers, texts, lists and dictionaries for ``json.dumps(..., allow_nan=False)``."""
    verdict, length = diagnosis.verdict, diagnosis.experiment.dataset.length
    return {
        "schema": SCHEMA,
        "dataset": diagnosis.experiment.dataset.name,
        "verdict": verdict_to_json(verdict) | {"left": _left(verdict.left)},
        "posterior": None if diagnosis.search is None else posterior_to_json(diagnosis.search, verdict.decision, diagnosis.loss),
        "arm": None if diagnosis.search is None else arm_to_json(diagnosis.experiment, diagnosis.search.best.fit),
        "ladder": [_rung(rung, length) for rung in diagnosis.ladder],
        "noise_floor_mm": millimetres_or_null(diagnosis.experiment.noise_rms),
        "candidates": [] if diagnosis.search is None else candidates_to_json(diagnosis.search, _candidate),
        "where": _where(diagnosis.where),
        "next_experiment": [
            {"name": each.name, "separation": number_or_null(each.separation)} for each in diagnosis.next_experiment
        ],
        "limits": {"closed_mm": millimetres_or_null(diagnosis.limits.closed), "share": number_or_null(diagnosis.limits.share)},
        "fingerprint": None if diagnosis.indicators is None else diagnosis.indicators.to_json(),
        "repeats": None if diagnosis.repeatability is None else diagnosis.repeatability.to_json(),
        "supply": [each.to_json() for each in diagnosis.supply],
        "detection_limits": [] if diagnosis.search is None else detection_to_json(diagnosis.search),
        "notes": list(diagnosis.experiment.notes),
    }


def _left(left: Remainder | None) -> dict[str, float | None] | None:
    if left is None:
        return None
    return {
        "mm": millimetres_or_null(left.rms),
        "percent_of_length": number_or_null(100 * left.rms / left.length),
        "share": number_or_null(left.share),
        "not_repeatable_mm": None if left.not_repeatable is None else millimetres_or_null(left.not_repeatable),
    }


def _rung(rung: Rung, length: float) -> dict[str, Any]:
    return {
        "rung": rung.name,
        "effects": sorted(rung.effects),
        "heldout_rms_mm": millimetres_or_null(rung.rms),
        "heldout_rms_percent": number_or_null(100 * rung.rms / length),
        "share": number_or_null(rung.share),
        "ci95_mm": [millimetres_or_null(bound) for bound in rung.interval],
    }


def _candidate(candidate: Candidate) -> dict[str, Any]:
    effects = candidate.fit.hypothesis.effects
    return {
        "effects": list(candidate.names),
        "resized": list(candidate.fit.hypothesis.resized),
        "options": dict(sorted((f"{effect.name}.{name}", value) for effect in effects for name, value in effect.options)),
        "parameters": estimates_to_json(candidate.fit),
        "heldout_rms_mm": millimetres_or_null(math.sqrt(candidate.heldout_square)),
        "fit_rms_mm": millimetres_or_null(candidate.fit.rms),
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
    centre, *interval = (None,) if where.defect is None else map(number_or_null, where.defect)
    return {
        "arc_length": _map(where.arc_length),
        "time": _map(where.time),
        "operating_range": {each.quantity.replace(" ", "_"): _map(each) for each in where.operating_range},
        "trials": _map(where.trials),
        "sentence": where.sentence,
        "frequency_hz": None if where.frequency is None else number_or_null(where.frequency),
        "defect": None if where.defect is None else {"centre": centre, "ci95": interval},
        "base": None if where.base is None else {"foretold": number_or_null(where.base.predicted)},
        "pulsation": None if where.pulsation is None else {k: number_or_null(v) for k, v in asdict(where.pulsation).items()},
    }


def _map(chart: Map) -> dict[str, Any]:
    return {
        "quantity": chart.quantity,
        "unit": chart.unit,
        "bins": [
            {
                "label": part.label,
                "value": number_or_null(part.value),
                "share": number_or_null(part.share),
                "noise": number_or_null(part.noise),
            }
            for part in chart.bins
        ],
    }

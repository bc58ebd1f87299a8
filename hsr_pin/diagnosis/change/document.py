"""The diagnosis of a change as one JSON document.

Lengths are in mm, shares range from 0 to 1, and other numbers are in SI units; unknown values are null. The fields of schema 1
are stable; others may be added.
"""

from __future__ import annotations

import math
from typing import Any

from hsr_pin.diagnosis.change.diagnose import ChangeDiagnosis
from hsr_pin.diagnosis.change.history import History, Quantity
from hsr_pin.diagnosis.change.size import Size

SCHEMA = 1


def to_json(diagnosis: ChangeDiagnosis) -> dict[str, Any]:
    """Return the document of one comparison for ``json.dumps(..., allow_nan=False)``."""
    verdict, found, reference = diagnosis.verdict, diagnosis.found, diagnosis.reference
    return {
        "schema": SCHEMA,
        "dataset": diagnosis.pair.new.dataset.name,
        "since": diagnosis.pair.old.dataset.name,
        "verdict": {
            "status": verdict.status,
            "effects": sorted(verdict.effects),
            "alternatives": [sorted(names) for names in verdict.alternatives],
            "sentence": verdict.sentence,
            "kinds": list(verdict.kinds),
            "changes": [_size(each) for each in verdict.changes],
            "confidence": {name: _number(value) for name, value in verdict.confidence.items()},
        },
        "difference": None
        if verdict.difference is None
        else {
            "before_mm": _mm(verdict.difference.before),
            "after_mm": _mm(verdict.difference.after),
            "scatter_mm": _mm(verdict.difference.scatter),
            "share": _number(verdict.difference.share),
        },
        "limits": {name: _number(value) for name, value in sorted(verdict.limits.items())},
        "reference": None
        if reference is None
        else {
            "effects": list(reference.names),
            "parameters": {name: _number(value) for name, value in sorted(reference.fit.named.items())},
        },
        "candidates": []
        if found is None
        else [
            {
                "changes": list(fitted.change.names),
                "parameters": {name: _number(float(value)) for name, value in zip(fitted.change.open, fitted.after, strict=True)},
                "gain": _number(found.gain(fitted)),
                "needed": _number(found.needed),
                "moves_mm": _mm(fitted.rms),
            }
            for fitted, _ in found.fits
        ],
        "next_experiment": [{"name": each.name, "separation": _number(each.separation)} for each in diagnosis.next_experiment],
        "notes": [*diagnosis.pair.old.notes, *diagnosis.pair.new.notes],
    }


def history_to_json(found: History) -> dict[str, Any]:
    """Return the document of the last session compared with the first, with an overview of all sessions."""
    return to_json(found.diagnoses[-1]) | {
        "sessions": list(found.names),
        "verdicts": [to_json(each)["verdict"] for each in found.diagnoses],
        "quantities": [_quantity(each, found.names) for each in found.quantities],
    }


def _size(size: Size) -> dict[str, Any]:
    spans = {"from": size.was, "to": size.becomes, "step": size.step}
    return {
        "name": size.name,
        "parameter": size.parameter,
        "unit": size.unit,
        "from": None if size.before is None else _number(size.before),
        "to": _number(size.after),
        "intervals": {name: [_number(float(end)) for end in span] for name, span in spans.items() if span is not None},
    }


def _quantity(quantity: Quantity, names: tuple[str, ...]) -> dict[str, Any]:
    return {
        "name": quantity.name,
        "unit": quantity.unit,
        "first_certain": None if quantity.first is None else names[quantity.first],
        "points": [
            {
                "session": name,
                "value": _number(point.value),
                "interval": None if point.interval is None else [_number(float(end)) for end in point.interval],
                "changed": point.changed,
            }
            for name, point in zip(names, quantity.points, strict=True)
        ],
    }


def _mm(metres: float) -> float | None:
    return _number(1e3 * metres)


def _number(value: float) -> float | None:
    return float(f"{value:.6g}") if math.isfinite(value) else None

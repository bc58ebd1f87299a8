"""An explanation as one JSON document: distances in floors, shares from 0 to 1, null for unknown values."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.document import (
    candidates_to_json,
    detection_to_json,
    estimates_to_json,
    number_or_null,
    posterior_to_json,
    verdict_to_json,
)

if TYPE_CHECKING:
    from hsr_pin.explain.result import Explanation

SCHEMA = 1


def to_json(found: Explanation) -> dict[str, Any]:
    """Return the document for ``json.dumps(..., allow_nan=False)``."""
    recordings, verdict = found.recordings, found.verdict
    left = verdict.left and {name: number_or_null(getattr(verdict.left, name)) for name in ("rms", "share")}
    return {
        "schema": SCHEMA,
        "model": recordings.model.name,
        "channels": {
            name: {"unit": recordings.model.units.get(name, ""), "floor": number_or_null(floor), "noise": number_or_null(noise)}
            for name, floor, noise in zip(recordings.channels, recordings.units, recordings.noise * recordings.units, strict=True)
        },
        "verdict": verdict_to_json(verdict) | {"left": left},
        "posterior": posterior_to_json(found.search, verdict.decision, found.loss),
        "ladder": [
            {
                "rung": rung.name,
                "causes": list(rung.effects),
                "heldout_rms": number_or_null(rung.rms),
                "share": number_or_null(rung.share),
                "ci95": [number_or_null(bound) for bound in rung.interval],
            }
            for rung in found.ladder
        ],
        "candidates": candidates_to_json(found.search, _candidate),
        "where": {each.quantity: [asdict(part) for part in each.parts] for each in found.where},
        "next_experiment": [{"name": name, "separation": number_or_null(size)} for name, size in found.next_experiment],
        "limits": {"closed": number_or_null(found.limits.closed), "share": number_or_null(found.limits.share)},
        "detection_limits": detection_to_json(found.search),
        "notes": list(found.notes),
    }


def _candidate(candidate: Candidate) -> dict[str, Any]:
    return {
        "causes_named": list(candidate.names),
        "parameters": estimates_to_json(candidate.fit),
        "heldout_rms": number_or_null(candidate.heldout_square**0.5),
        "fit_rms": number_or_null(candidate.fit.rms),
    }

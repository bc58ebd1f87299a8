"""An identification as a JSON document.

Lengths are in mm, except in ``arm``, which is in SI units; unknown values are null. The fields of schema 1 are permanent; further
fields may be added.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from hsr_pin.identification.arm_document import arm_to_json
from hsr_pin.identification.identify import Identification
from hsr_pin.identification.links_study import LinksStudy
from hsr_pin.identification.paper_procedure import PaperProcedure
from hsr_pin.identification.profile import Profile
from hsr_pin.inference.residuals import rms
from hsr_pin.trajectory import Array

SCHEMA = 1


def to_json(
    found: Identification,
    *,
    profiles: Sequence[Profile] = (),
    paper: PaperProcedure | None = None,
    study: LinksStudy | None = None,
) -> dict[str, Any]:
    """Return the document as plain numbers, texts, lists and dictionaries for ``json.dumps(..., allow_nan=False)``."""
    answer, uncertainties, dataset = found.fit, found.uncertainty, found.experiment.dataset
    return {
        "schema": SCHEMA,
        "dataset": dataset.name,
        "parameters": _parameters(found, profiles),
        "rms_mm": _three(found, rms),
        "tip_rms_mm": _three(found, found.tip_rms),
        "length_mm": 1e3 * dataset.length,
        "noise_floor_mm": _mm(found.experiment.noise_rms),
        "heldout": "set aside" if found.set_aside else "leave one out" if found.heldout else None,
        "trials": _trials(found),
        "links": answer.hypothesis.links,
        "placement": answer.hypothesis.placement,
        "effects": [effect.name for effect in answer.hypothesis.effects],
        "correlation": [[_number(value) for value in row] for row in uncertainties.correlation],
        "condition": _number(uncertainties.condition),
        "not_told": list(uncertainties.weak),
        "converged": answer.converged,
        "failed": list(answer.failed),
        "evaluations": answer.evaluations,
        "paper_procedure": None if paper is None else _paper(paper),
        "links_study": None if study is None else _study(study),
        "notes": list(found.experiment.notes),
        "arm": arm_to_json(found.experiment, answer),
    }


def _parameters(found: Identification, profiles: Sequence[Profile]) -> dict[str, Any]:
    answer, uncertainties, bounds = found.fit, found.uncertainty, found.fit.on_bound()
    known = {profile.name: profile for profile in profiles}
    parameters: dict[str, Any] = {}
    for index, fact in enumerate(answer.hypothesis.parameters):
        profile = known.get(fact.name)
        parameters[fact.name] = {
            "value": float(answer.values[index]),
            "unit": fact.unit,
            "ci95": [_number(end) for end in uncertainties.interval[index]],
            "standard_error": _number(uncertainties.standard_error[index]),
            "on_bound": fact.name in bounds,
            "profile": None
            if profile is None
            else {
                "ci95": [_number(end) for end in profile.interval],
                "values": [_number(value) for value in profile.values],
                "deviance": [_number(value) for value in profile.deviance],
            },
        }
    return parameters


def _three(found: Identification, measure: Any) -> dict[str, float | None]:
    """Return an error measure for the declared arm, the fitted arm and held-out trials."""
    return {
        "before": _mm(measure(found.before)),
        "after": _mm(measure(found.after)),
        "heldout_before": _mm(measure(found.heldout_before)) if found.heldout else None,
        "heldout": _mm(measure(found.heldout)) if found.heldout else None,
    }


def _trials(found: Identification) -> list[dict[str, Any]]:
    rows = []
    for run, before, after in zip(found.experiment.runs, found.before, found.after, strict=True):
        rows.append({"trial": run.trial.name, "fitted": True, **_row(found, run.time, before, after)})
    if found.set_aside:
        for run, before, after in zip(found.heldout_experiment.runs, found.heldout_before, found.heldout, strict=True):
            rows.append({"trial": run.trial.name, "fitted": False, **_row(found, run.time, before, after)})
    else:
        for row, missed in zip(rows, found.heldout, strict=False):
            row["heldout_rms_mm"] = _mm(rms([missed]))
    return rows


def _row(found: Identification, time: Array, before: Array, after: Array) -> dict[str, Any]:
    return {
        "from_s": _number(float(time[0])),
        "rms_mm": {"before": _mm(rms([before])), "after": _mm(rms([after]))},
        "tip_rms_mm": {"before": _mm(found.tip_rms([before])), "after": _mm(found.tip_rms([after]))},
    }


def _paper(paper: PaperProcedure) -> dict[str, Any]:
    return {
        "links": paper.links,
        "placement": paper.placement,
        "keq_scale": _number(paper.last.keq_scale),
        "damping_scale": _number(paper.last.damping_scale),
        "rms_mm": _mm(paper.last.rms),
        "passes": [
            {"keq_scale": _number(p.keq_scale), "damping_scale": _number(p.damping_scale), "rms_mm": _mm(p.rms)}
            for p in paper.passes
        ],
        "grid": [{"damping_scale": _number(c), "rms_mm": _mm(error)} for c, error in paper.grid.T],
        "simulations": paper.simulations,
    }


def _study(study: LinksStudy) -> dict[str, Any]:
    return {
        "placement": study.placement,
        "recommended": study.recommended,
        "sentence": study.sentence,
        "rows": [
            {
                "links": row.links,
                "model_error_mm": _mm(row.model_error),
                "data_error_mm": _mm(row.data_error),
                "cost": _number(row.cost),
            }
            for row in study.rows
        ],
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _mm(metres: float) -> float | None:
    return _number(1e3 * metres)

"""An identification as a JSON document.

Lengths are in mm, except in ``arm``, which is in SI units; unknown values are null. The fields of schema 1 are permanent; further
fields may be added.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from hsr_pin.identification.arm_document import arm_to_json
from hsr_pin.identification.identify import Identification
from hsr_pin.identification.links_study import LinksStudy
from hsr_pin.identification.paper_procedure import PaperProcedure
from hsr_pin.identification.profile import Profile
from hsr_pin.inference.document import millimetres_or_null, number_or_null
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
        "noise_floor_mm": millimetres_or_null(found.experiment.noise_rms),
        "heldout": "set aside" if found.set_aside else "leave one out" if found.heldout else None,
        "trials": _trials(found),
        "links": answer.hypothesis.links,
        "placement": answer.hypothesis.placement,
        "effects": [effect.name for effect in answer.hypothesis.effects],
        "correlation": [[number_or_null(value) for value in row] for row in uncertainties.correlation],
        "condition": number_or_null(uncertainties.condition),
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
            "ci95": [number_or_null(end) for end in uncertainties.interval[index]],
            "standard_error": number_or_null(uncertainties.standard_error[index]),
            "on_bound": fact.name in bounds,
            "profile": None
            if profile is None
            else {
                "ci95": [number_or_null(end) for end in profile.interval],
                "values": [number_or_null(value) for value in profile.values],
                "deviance": [number_or_null(value) for value in profile.deviance],
            },
        }
    return parameters


def _three(found: Identification, measure: Any) -> dict[str, float | None]:
    """Return an error measure for the declared arm, the fitted arm and held-out trials."""
    return {
        "before": millimetres_or_null(measure(found.before)),
        "after": millimetres_or_null(measure(found.after)),
        "heldout_before": millimetres_or_null(measure(found.heldout_before)) if found.heldout else None,
        "heldout": millimetres_or_null(measure(found.heldout)) if found.heldout else None,
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
            row["heldout_rms_mm"] = millimetres_or_null(rms([missed]))
    return rows


def _row(found: Identification, time: Array, before: Array, after: Array) -> dict[str, Any]:
    return {
        "from_s": number_or_null(float(time[0])),
        "rms_mm": {"before": millimetres_or_null(rms([before])), "after": millimetres_or_null(rms([after]))},
        "tip_rms_mm": {
            "before": millimetres_or_null(found.tip_rms([before])),
            "after": millimetres_or_null(found.tip_rms([after])),
        },
    }


def _paper(paper: PaperProcedure) -> dict[str, Any]:
    return {
        "links": paper.links,
        "placement": paper.placement,
        "keq_scale": number_or_null(paper.last.keq_scale),
        "damping_scale": number_or_null(paper.last.damping_scale),
        "rms_mm": millimetres_or_null(paper.last.rms),
        "passes": [
            {
                "keq_scale": number_or_null(p.keq_scale),
                "damping_scale": number_or_null(p.damping_scale),
                "rms_mm": millimetres_or_null(p.rms),
            }
            for p in paper.passes
        ],
        "grid": [{"damping_scale": number_or_null(c), "rms_mm": millimetres_or_null(error)} for c, error in paper.grid.T],
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
                "model_error_mm": millimetres_or_null(row.model_error),
                "data_error_mm": millimetres_or_null(row.data_error),
                "cost": number_or_null(row.cost),
            }
            for row in study.rows
        ],
    }

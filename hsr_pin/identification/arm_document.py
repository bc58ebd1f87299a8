"""The arm of a result, for other programs: the declared arm, the fitted chain and its effects.

All values are in SI units, as in ``dataset.toml``: this part of a document can be read without the recordings.
"""

from __future__ import annotations

from dataclasses import asdict
from math import isfinite
from typing import Any

from hsr_pin.identification.experiment import Experiment
from hsr_pin.inference.fit import Fit
from hsr_pin.obstacles import to_dict
from hsr_pin.robot.specification import default_damping
from hsr_pin.trajectory import Dataset, Marker


def arm_to_json(experiment: Experiment, fit: Fit) -> dict[str, Any]:
    """Return the section ``arm`` of a document, with the fitted effects of ``fit`` in the order in which they act."""
    dataset, hypothesis = experiment.dataset, fit.hypothesis
    return {
        "length": dataset.length,
        "mass": dataset.mass,
        "diameter": dataset.diameter,
        "mount": dataset.mount,
        **_of_space(dataset),
        "levels": levels([(run.trial.keq, run.trial.damping, run.trial.tip_mass) for run in experiment.runs]),
        **({"obstacles": [to_dict(obstacle) for obstacle in dataset.obstacles]} if dataset.obstacles else {}),
        "markers": [_marker(marker) for marker in dataset.markers],
        "links": hypothesis.links,
        "placement": hypothesis.placement,
        "effects": [
            {
                "name": effect.name,
                "parameters": {fact.name: float(getattr(effect, fact.name)) for fact in effect.parameters()},
                "options": dict(effect.options),
            }
            for effect in hypothesis.effects_at(fit.values)
        ],
    }


def _of_space(dataset: Dataset) -> dict[str, Any]:
    """Return the entries of arms in space only: a torsion of null is infinite, and inputs are the channels that drive the arm."""
    if dataset.bending == "plane":
        return {}
    sections = {"sections": [asdict(section) for section in dataset.sections]} if dataset.sections else {}
    driving = [asdict(channel) for channel in dataset.channels if channel.torque]
    inputs = {"inputs": [{**channel, "torque": list(channel["torque"])} for channel in driving]} if driving else {}
    return {"bending": dataset.bending, "torsion": dataset.torsion if isfinite(dataset.torsion) else None, **sections, **inputs}


def _marker(marker: Marker) -> dict[str, Any]:
    beside = {"radius": marker.radius, "angle": marker.angle} if marker.radius else {}
    return {"name": marker.name, "arc_length": marker.arc_length, **beside}


def levels(declared: list[tuple[float, float | None, float]]) -> list[dict[str, float]]:
    """Return, for each declared Keq [Nm/rad], the damping [Nm s/rad] and the payload [kg] of its first trial."""
    found: dict[float, dict[str, float]] = {}
    for keq, damping, tip_mass in declared:
        loss = default_damping(keq) if damping is None else damping
        found.setdefault(keq, {"keq": keq, "damping": loss, "tip_mass": tip_mass})
    return [found[keq] for keq in sorted(found)]

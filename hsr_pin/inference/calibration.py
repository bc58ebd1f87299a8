"""The few numbers of the judgement, fitted once to cases whose answers are known."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files


@dataclass(frozen=True)
class Calibration:
    """Numbers of the judgement.

    Attributes:
        samples: nu, the number of independent samples that residuals count for: a model's errors repeat in every trial.
        cause: kappa, what each cause costs beforehand [nats].
        flexible: kappa_f, what a law that stands for its kind only costs besides [nats].
        floor: least root mean square that any model leaves beyond noise, over the noise.
        share: a model gives way to a special case of it that does all of what it does but for this share.
    """

    samples: float
    cause: float
    flexible: float
    floor: float
    share: float


@cache
def calibrated() -> Calibration:
    """The numbers in ``calibration.json``, which ``scripts/calibrate.py`` wrote."""
    document = json.loads(files("hsr_pin.inference").joinpath("calibration.json").read_text(encoding="utf-8"))
    return Calibration(**{name: entry["value"] for name, entry in document["numbers"].items()})

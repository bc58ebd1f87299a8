"""Constants of the model evidence, calibrated once on cases whose answers are known."""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib.resources import files


@dataclass(frozen=True)
class Calibration:
    """Calibrated constants of the model evidence.

    Attributes:
        samples: nu, the effective number of independent samples in the residuals of all trials, because model errors repeat in
            every trial.
        cause: kappa, the prior penalty of each cause [nats].
        flexible: kappa_f, the additional prior penalty of a flexible law, which stands for its kind of physics only [nats].
        floor: smallest RMS residual beyond noise that any model is assumed to leave, as a multiple of the noise.
        share: a model is replaced by a special case of it that explains all of what the model explains except for this share.
    """

    samples: float
    cause: float
    flexible: float
    floor: float
    share: float


@cache
def calibrated() -> Calibration:
    """Return the constants in ``calibration.json``, which ``scripts/calibrate.py`` wrote."""
    document = json.loads(files("hsr_pin.inference").joinpath("calibration.json").read_text(encoding="utf-8"))
    return Calibration(**{name: entry["value"] for name, entry in document["numbers"].items()})

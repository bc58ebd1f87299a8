"""Fit how the confidence of names is scaled, in hsr_pin/diagnosis/confidence.py, to published runs of the blind check.

python scripts/scale_confidence.py data/blind_928745.json data/blind_350227.json prints, for each of these and for all together,
which shift and power make their names most likely, and the calibration error of every run as stated and so scaled. Runs
up to the eighth (350227) state it unscaled, later ones as it is scaled now.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from hsr_pin.blind.kinds import KINDS
from hsr_pin.blind.reliability import reliability
from hsr_pin.blind.scoring import scored
from hsr_pin.diagnosis.confidence import odds, scaled

#: Of each case: whether it is a name, its stated confidence, and whether it was right.
Claims = list[list[tuple[bool, float, bool]]]


def claims(file: Path) -> Claims:
    """What was stated, of every case."""
    outcomes = scored(json.loads(file.read_text(encoding="utf-8"))).outcomes
    return [[(claim not in KINDS, value, each.is_so(claim)) for claim, value in each.confidence] for each in outcomes]


def fitted(runs: Sequence[Claims]) -> tuple[float, float]:
    """Shift and power that make the names of some runs most likely (J. Platt, 1999)."""
    names = [(odds(value), right) for run in runs for case in run for is_name, value, right in case if is_name]
    x, y = np.array(names, dtype=float).T

    def cost(w: np.ndarray) -> float:
        z = w[0] + w[1] * x
        return float(np.sum(np.logaddexp(0, z) - y * z))

    shift, power = minimize(cost, [0.0, 1.0]).x
    return float(shift), float(power)


def error(run: Claims, shift: float = 0.0, power: float = 1.0) -> float:
    """Expected calibration error with its names scaled."""
    names_scaled = [[(scaled(p, shift, power) if is_name else p, right) for is_name, p, right in case] for case in run if case]
    return reliability(names_scaled).error


def main() -> None:
    """Print them."""
    files = [Path(text) for text in sys.argv[1:]]
    runs = [claims(file) for file in files]
    for what, chosen in [*((file.stem, [run]) for file, run in zip(files, runs, strict=True)), ("all", runs)]:
        shift, power = fitted(chosen)
        errors = ", ".join(
            f"{file.stem} {error(run):.3f} to {error(run, shift, power):.3f}" for file, run in zip(files, runs, strict=True)
        )
        print(f"fitted to {what}: shift {shift:.2f}, power {power:.2f}; calibration error of {errors}")


if __name__ == "__main__":
    main()

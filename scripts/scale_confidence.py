"""Fit how confidence is scaled, in hsr_pin/diagnosis/confidence.py, to published runs of the blind check.

python scripts/scale_confidence.py data/blind_928745.json data/blind_350227.json prints, for each of these, for all but it, and
for all, which shift and power make their names most likely, and likewise for kinds, with a further shift for each of them, and
the calibration error of every run as stated and so scaled; then, of each kind, how often claims were right. Names of runs up to
the eighth (350227) and kinds of runs up to the tenth (80977) are stated unscaled, later ones as they are scaled now.
"""

from __future__ import annotations

import itertools
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from hsr_pin.blind.kinds import KINDS
from hsr_pin.blind.reliability import reliability
from hsr_pin.blind.scoring import scored
from hsr_pin.diagnosis.confidence import odds, scaled

#: Of each case: what was claimed, its stated confidence, and whether it was right.
Claims = list[list[tuple[str, float, bool]]]
#: Kinds of which no shift is known beforehand by more than this (standard deviation of a normal prior).
APART = 1.0
#: Claims are counted between these.
BOUNDS = (0.0, 0.5, 0.75, 0.8, 1.01)


@dataclass(frozen=True)
class Scale:
    """What makes claims of one sort most likely; by ``of_kind`` further shifts, of those of a kind."""

    shift: float = 0.0
    power: float = 1.0
    of_kind: dict[str, float] = field(default_factory=dict)

    def of(self, claim: str, stated: float) -> float:
        """A stated probability, scaled."""
        return scaled(stated, self.shift + self.of_kind.get(claim, 0.0), self.power)

    def __str__(self) -> str:
        own = "".join(f", {kind} {shift:+.2f}" for kind, shift in self.of_kind.items())
        return f"shift {self.shift:.2f}, power {self.power:.2f}{own}"


def claims(file: Path) -> Claims:
    """What was stated, of every case."""
    outcomes = scored(json.loads(file.read_text(encoding="utf-8"))).outcomes
    return [[(claim, value, each.is_so(claim)) for claim, value in each.confidence] for each in outcomes]


def fitted(runs: Sequence[Claims], *, names: bool) -> Scale:
    """Shift and power that make the names of some runs most likely, or their kinds (J. Platt, 1999)."""
    told = [each for run in runs for case in run for each in case if (each[0] not in KINDS) is names]
    x, y = np.array([(odds(value), right) for _, value, right in told], dtype=float).T
    known = [] if names else [kind for kind in KINDS if any(claim == kind for claim, _, _ in told)]
    own = np.array([[claim == kind for kind in known] for claim, _, _ in told], dtype=float).reshape(len(told), len(known))

    def cost(w: np.ndarray) -> float:
        z = w[0] + w[1] * x + own @ w[2:]
        return float(np.sum(np.logaddexp(0, z) - y * z)) + float(w[2:] @ w[2:]) / (2 * APART**2)

    shift, power, *apart = (float(value) for value in minimize(cost, [0.0, 1.0, *np.zeros(len(known))]).x)
    return Scale(shift, power, dict(zip(known, apart, strict=True)))


def error(run: Claims, names: Scale, kinds: Scale) -> float:
    """Expected calibration error once scaled."""
    told = [[((kinds if claim in KINDS else names).of(claim, p), right) for claim, p, right in case] for case in run if case]
    return reliability(told).error


def right(runs: Sequence[Claims], kind: str, low: float, high: float) -> str:
    """How many of the claims of a kind with a confidence between two values were so, in words."""
    told = [so for run in runs for case in run for claim, value, so in case if claim == kind and low <= value < high]
    return f"{sum(told)} of {len(told)}"


def main() -> None:
    """Print them."""
    runs = {Path(text).stem: claims(Path(text)) for text in sys.argv[1:]}
    chosen = {name: [run] for name, run in runs.items()}
    if len(runs) > 1:
        chosen |= {f"all but {name}": [run for other, run in runs.items() if other != name] for name in runs}
        chosen["all"] = list(runs.values())
    for what, some in chosen.items():
        names, kinds = fitted(some, names=True), fitted(some, names=False)
        before_after = ((name, error(run, Scale(), Scale()), error(run, names, kinds)) for name, run in runs.items())
        errors = ", ".join(f"{name} {before:.3f} to {after:.3f}" for name, before, after in before_after)
        print(f"fitted to {what}: names {names}; kinds {kinds}; calibration error of {errors}")
    for kind in KINDS:
        often = ", ".join(
            f"{right(list(runs.values()), kind, low, high)} from {low:g} to {high:g}" for low, high in itertools.pairwise(BOUNDS)
        )
        print(f"{kind} was right in {often}")


if __name__ == "__main__":
    main()

"""Fit the coefficients of hsr_pin/diagnosis/confidence.py to diagnoses of cases whose answers are known.

python scripts/calibrate.py ANSWERS RESULTS prints them, and how well the probabilities hold in cross-validation over cases.

ANSWERS is the file of answers of a check (``hsr-blind make``), RESULTS the folder of its verdicts (``hsr-blind run``). One that
served here is not reported as a result: sealed runs have other seeds. After names are fitted anew their shift and power go back
to 0 and 1, until ``scripts/scale_confidence.py`` finds others for them.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.kinds import FLEXIBLE
from hsr_pin.diagnosis.confidence import features
from hsr_pin.diagnosis.support import Support, shows
from hsr_pin.trajectory import Array

#: Strength of the prior that keeps coefficients small where there are few cases.
PRIOR = 0.05


#: Case, features, frequency, and whether it was right.
Row = tuple[str, tuple[float, ...], float, bool]


def rows(answers: Path, results: Path) -> tuple[dict[str, list[Row]], int]:
    """For names and kinds; and how many cases there were."""
    found: dict[str, list[Row]] = {"name": [], "kind": []}
    cases = {case["name"]: Answer.of(case) for case in json.loads(answers.read_text(encoding="utf-8"))["cases"]}
    files = sorted(results.glob("*.json"))
    for file in files:
        case = cases[file.stem]
        names, kinds = ({each for some in key for each in some} for key in (case.names, case.kinds))
        document = json.loads(file.read_text(encoding="utf-8"))
        verdict, seen = document["verdict"], document["fingerprint"]["kinds"]
        for told in verdict["support"]:  # older versions did not tell all of it
            known = {"rest": verdict["left"]["share"], "shown": shows(told["kind"], seen), **told}
            support = Support(**{k: float("nan") if v is None else v for k, v in known.items()})
            of_kind = support.name == support.kind
            if support.name not in FLEXIBLE:
                right = support.name in (kinds if of_kind else names)
                found["kind" if of_kind else "name"].append((file.stem, features(support), support.frequency, right))
    return found, len(files)


def stated(w: Array, X: Array, frequency: Array) -> Array:
    """As :func:`hsr_pin.diagnosis.confidence.probability`, before it is scaled."""
    return np.asarray((1 + frequency) / 2 / (1 + np.exp(-X @ w)))


def fitted(X: Array, frequency: Array, y: Array) -> Array:
    """By maximum likelihood, all but the constant shrunk a little."""

    def cost(w: Array) -> float:
        p = np.clip(stated(w, X, frequency), 1e-6, 1 - 1e-6)
        return float(-np.log(np.where(y > 0, p, 1 - p)).sum() + PRIOR * len(y) ** 0.5 * (w[1:] @ w[1:]))

    return np.asarray(minimize(cost, np.zeros(X.shape[1])).x)


def main() -> None:
    """Print the coefficients, and the calibration when each tenth of the cases is left out of its own fit."""
    found, count = rows(Path(sys.argv[1]), Path(sys.argv[2]))
    print(f"{count} cases")
    for what, entries in found.items():
        cases, values, frequencies, rights = zip(*entries, strict=True)
        X, often, y = np.array(values), np.array(frequencies), np.array(rights, dtype=float)
        fold = np.array([hash_of(case) % 10 for case in cases])
        p = np.empty(len(y))
        for k in range(10):
            own = fold == k
            if own.any():
                p[own] = stated(fitted(X[~own], often[~own], y[~own]), X[own], often[own])
        print(f"{what}: {tuple(fitted(X, often, y).round(2).tolist())} from {len(y)}, {int(y.sum())} of them right")
        for low, high in ((0, 0.25), (0.25, 0.5), (0.5, 0.75), (0.75, 0.9), (0.9, 1.01)):
            some = (p >= low) & (p < high)
            if some.any():
                print(f"  said {p[some].mean():.2f}, was right {y[some].mean():.2f} ({int(some.sum())})")


def hash_of(name: str) -> int:
    """The same in every process."""
    return sum(map(ord, name)) * 7919 % 101


if __name__ == "__main__":
    main()

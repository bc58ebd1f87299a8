"""Fit the coefficients of hsr_pin/diagnosis/confidence.py to diagnoses of cases whose answers are known.

python scripts/calibrate.py ANSWERS RESULTS prints them, and how well the probabilities hold in cross-validation over cases.

ANSWERS is the file of answers of a check (``hsr-blind make``), RESULTS the folder of its verdicts (``hsr-blind run``). One that
served here is not reported as a result: sealed runs have other seeds.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from hsr_pin.diagnosis.confidence import features
from hsr_pin.diagnosis.support import Support
from hsr_pin.trajectory import Array

#: Strength of the prior that keeps coefficients small where there are few cases.
PRIOR = 0.05


def rows(answers: Path, results: Path) -> tuple[dict[str, list[tuple[str, tuple[float, ...], bool]]], int]:
    """For names and kinds: case, features, and whether it was right; and how many cases there were."""
    found: dict[str, list[tuple[str, tuple[float, ...], bool]]] = {"name": [], "kind": []}
    cases = {case["name"]: case for case in json.loads(answers.read_text(encoding="utf-8"))["cases"]}
    files = sorted(results.glob("*.json"))
    for file in files:
        case = cases[file.stem]
        names, kinds = ({each for some in case[key] for each in some} for key in ("names", "kinds"))
        for support in json.loads(file.read_text(encoding="utf-8"))["verdict"]["support"]:
            values = features(Support(**{k: float("nan") if v is None else v for k, v in support.items()}))
            of_kind = support["name"] == support["kind"]
            right = support["name"] in (kinds if of_kind else names)
            found["kind" if of_kind else "name"].append((file.stem, values, right))
    return found, len(files)


def fitted(X: Array, y: Array) -> Array:
    """Logistic regression by maximum likelihood, all but the constant shrunk a little."""
    start = np.zeros(X.shape[1])
    answer = minimize(lambda w: np.logaddexp(0, -(2 * y - 1) * (X @ w)).sum() + PRIOR * len(y) ** 0.5 * (w[1:] @ w[1:]), start)
    return np.asarray(answer.x)


def main() -> None:
    """Print the coefficients, and the calibration when each tenth of the cases is left out of its own fit."""
    found, count = rows(Path(sys.argv[1]), Path(sys.argv[2]))
    print(f"{count} cases")
    for what, entries in found.items():
        X, y = np.array([values for _, values, _ in entries]), np.array([right for _, _, right in entries], dtype=float)
        fold = np.array([hash_of(case) % 10 for case, _, _ in entries])
        p = np.empty(len(y))
        for k in range(10):
            if (fold == k).any():
                p[fold == k] = 1 / (1 + np.exp(-X[fold == k] @ fitted(X[fold != k], y[fold != k])))
        print(f"{what}: {tuple(fitted(X, y).round(2).tolist())} from {len(y)}, {int(y.sum())} of them right")
        for low, high in ((0, 0.2), (0.2, 0.5), (0.5, 0.8), (0.8, 0.95), (0.95, 1.01)):
            some = (p >= low) & (p < high)
            if some.any():
                print(f"  said {p[some].mean():.2f}, was right {y[some].mean():.2f} ({int(some.sum())})")


def hash_of(name: str) -> int:
    """The same in every process."""
    return sum(map(ord, name)) * 7919 % 101


if __name__ == "__main__":
    main()

"""Fit the few constants of the decision rules to diagnoses of cases whose answers are known.

python scripts/calibrate.py RESULTS ANSWERS [RESULTS ANSWERS ...] evaluates every case again for many values of the constants,
prints how the answers come out, and writes ``hsr_pin/inference/calibration.json`` with ``--write``. RESULTS is the folder of
verdicts of a check (``hsr-blind run``). ANSWERS is the file of its answers (``hsr-blind make``) or the folder of their drafts. A
check that is used here is not reported as a result.

The chosen constants are the coarsest within one standard error of the best: the fewest samples whose mean log score is no worse
than the best by more than the standard error of the difference over cases.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.kinds import FLEXIBLE, PLAIN_PARAMETERS, kinds_of
from hsr_pin.blind.outcome import RIGHT
from hsr_pin.inference import Calibration, Cause, Data, Decision, Model, Posterior, decide, posterior
from hsr_pin.inference.calibration import calibrated
from hsr_pin.trajectory import Array

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "hsr_pin" / "inference" / "calibration.json"
#: Values that are tried: number of samples, prior penalty of a cause, and additional penalty of a flexible law.
SAMPLES = (6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0, 25.0, 30.0)
CAUSES = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
FLEXIBLES = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
#: Lower bound of the probability of the truth, so that no single case dominates.
LEAST = 0.01


@dataclass(frozen=True, eq=False)
class Case:
    """One diagnosed case with its answer.

    Attributes:
        models: models of the diagnosis.
        special: pairs (k, n) such that model k is a special case of model n.
        data: scale of the data.
        answer: the truth.
        status: status of the verdict that was written.
    """

    models: tuple[Model, ...]
    special: frozenset[tuple[int, int]]
    data: Data
    answer: Answer
    status: str

    def judged(self, numbers: Calibration) -> Posterior:
        """Return the posterior with other constants."""
        place = {id(model): k for k, model in enumerate(self.models)}
        return posterior(self.models, self.data, numbers, lambda one, other: (place[id(one)], place[id(other)]) in self.special)

    def right(self, names: Sequence[str]) -> bool:
        """Return whether a set of causes is the truth; a flexible law is right if its kind is."""
        claims = [kinds_of(name)[:1] if name in FLEXIBLE or name not in self.known else (name,) for name in names]
        kinds = {kind for kinds in self.answer.kinds for kind in kinds}
        if self.answer.kind in RIGHT:
            return all(name in kinds for each in claims for name in each) if self.answer.kind == "outside" else not names
        own = {name for each in claims for name in each}
        found = all(own & {*names, *kinds} for names, kinds in zip(self.answer.names, self.answer.kinds, strict=True))
        return found and own <= {name for each in self.answer.names for name in each} | set(self.answer.background) | kinds

    @property
    def known(self) -> set[str]:
        """Names of causes that are not flexible laws."""
        return {cause.name for model in self.models for cause in model.causes if not cause.flexible}


def cases(results: Path, answers: Path) -> Iterator[Case]:
    """Yield every case of a check with a posterior."""
    drafts = sorted(answers.glob("case_*.json")) if answers.is_dir() else []
    entries = [json.loads(file.read_text(encoding="utf-8")) for file in drafts]
    entries = entries or json.loads(answers.read_text(encoding="utf-8"))["cases"]
    known = {entry["name"]: Answer.of(entry) for entry in entries}
    for file in sorted(results.glob("case_*.json")):
        document = json.loads(file.read_text(encoding="utf-8"))
        if file.stem in known and document.get("posterior"):
            yield case_of(document, known[file.stem])


def case_of(document: dict[str, Any], answer: Answer) -> Case:
    """Return the case from the JSON document of a diagnosis."""
    fitted, rest = document["candidates"], document["posterior"].get("unfitted", [])
    models = tuple(
        Model(
            tuple(Cause(**cause) for cause in each["causes"]),
            np.array(each.get("misfits", [each["misfit"]]), dtype=float),
            _information(each),
            np.array(each.get("departures", []), dtype=float),
            np.array(each.get("errors", []), dtype=float),
        )
        for each in (*fitted, *rest)
    )
    special = frozenset((k, n) for n, each in enumerate(fitted) for k in each["special_cases"])
    return Case(models, special, _data(document["posterior"]["data"]), answer, document["verdict"]["status"])


def _information(model: dict[str, Any]) -> Array:
    """Return the information (G, P, P) of a model; older documents have only the eigenvalues of a single group."""
    found = np.array(model.get("information", []), dtype=float)
    return found if found.ndim == 3 else np.diag(found)[None]


def _data(document: dict[str, Any]) -> Data:
    """Return the summary of the recordings; in older documents all channels are one group."""
    if "groups" not in document:
        return Data.of_one_group(**document)
    groups = tuple(tuple(own) for own in document["groups"])
    return Data(groups, *(np.array(document[name]) for name in ("noise", "count", "discrepancy")))


def scores(found: Sequence[Case], numbers: Calibration) -> Array:
    """Return the log probability that each case gives to the truth, (n,) [nats]."""
    return np.log(np.maximum([_of_truth(case, case.judged(numbers)) for case in found], LEAST))


def _of_truth(case: Case, judged: Posterior) -> float:
    return sum(probability for names, probability in judged.sets.items() if case.right(names))


def outcome(case: Case, report: Decision) -> str:
    """Return the grade of a decision as in the blind check, except for statuses that do not depend on the constants here."""
    named = {name for names in report.sets for name in names} or set(report.names)
    if not report.sets and not report.kinds:
        return "right" if case.answer.kind in RIGHT else "silent"
    if report.sets and any(case.right(names) for names in report.sets):
        return "exact" if len(report.sets) == 1 else "alternatives"
    kinds = {kind for each in case.answer.kinds for kind in each}
    if not named - set(PLAIN_PARAMETERS):
        return "kind" if kinds and set(report.kinds) <= kinds else "wrong kind"
    true = {name for each in case.answer.names for name in each} | set(case.answer.background)
    sets = report.sets or (report.names,)
    return "part" if any(set(names) <= true for names in sets) else "wrong"


def main() -> None:
    """Print the outcomes with the constants in use, the best ones and the chosen ones."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pairs", nargs="+", type=Path, metavar="RESULTS ANSWERS")
    parser.add_argument("--write", action="store_true", help="write the chosen numbers")
    arguments = parser.parse_args()
    found = [
        each
        for results, answers in zip(arguments.pairs[::2], arguments.pairs[1::2], strict=True)
        for each in cases(results, answers)
    ]
    found = [case for case in found if case.status != "no_gap"]
    report("in use", found, calibrated())
    tried = {}
    for samples, cause, flexible in itertools.product(SAMPLES, CAUSES, FLEXIBLES):
        numbers = replace(calibrated(), samples=samples, cause=cause, flexible=flexible)
        tried[numbers] = scores(found, numbers)
    best = max(tried, key=lambda numbers: float(tried[numbers].mean()))
    near = [numbers for numbers, own in tried.items() if _near(own, tried[best])]
    fewest = min(numbers.samples for numbers in near)
    chosen = max((numbers for numbers in near if numbers.samples == fewest), key=lambda numbers: float(tried[numbers].mean()))
    report("best", found, best)
    report("coarsest within one standard error", found, chosen)
    if arguments.write:
        TARGET.write_text(json.dumps(document(chosen, near, len(found)), indent=1) + "\n", encoding="utf-8")


def _near(own: Array, best: Array) -> bool:
    """Return whether a mean score is worse than the best by at most the standard error of the difference."""
    difference = best - own
    return float(difference.mean()) <= float(difference.std(ddof=1)) / len(own) ** 0.5 + 1e-12


def document(chosen: Calibration, near: Sequence[Calibration], count: int) -> dict[str, Any]:
    """Return the document to write: each constant, and the range of values that the cases do not distinguish."""
    fitted = ("samples", "cause", "flexible")
    numbers: dict[str, Any] = {name: {"value": value} for name, value in vars(chosen).items()}
    for name in fitted:
        own = [getattr(each, name) for each in near]
        numbers[name]["within_one_standard_error"] = [min(own), max(own)]
    return {"cases": count, "numbers": numbers}


def report(title: str, found: Sequence[Case], numbers: Calibration) -> None:
    """Print the mean score, the grades of all cases, and the reliability of stated names for given constants."""
    log_scores = scores(found, numbers)
    print(f"{title}: {numbers}: log score {log_scores.mean():.3f}")
    rows: dict[tuple[str, str], Counter[str]] = {}
    for case in found:
        row = rows.setdefault((case.answer.tier, case.answer.kind), Counter())
        row[outcome(case, decide(case.judged(numbers)))] += 1
    for row_of, counts in sorted(rows.items()):
        print(f"  {' '.join(row_of):<18}", ", ".join(f"{grade} {count}" for grade, count in sorted(counts.items())))
    claims = [
        (p, name in {n for each in case.answer.names for n in each} | set(case.answer.background))
        for case in found
        for name, p in _names(case.judged(numbers)).items()
    ]
    for low, high in ((0.0, 0.2), (0.2, 0.5), (0.5, 0.85), (0.85, 0.95), (0.95, 1.01)):
        own = [(p, so) for p, so in claims if low <= p < high]
        if own:
            print(f"  names stated with {np.mean([p for p, _ in own]):.2f}: {sum(so for _, so in own)} of {len(own)} are right")


def _names(judged: Posterior) -> dict[str, float]:
    own = {cause.name for model in judged.models for cause in model.causes if not cause.flexible} - set(PLAIN_PARAMETERS)
    return {name: p for name in own if (p := judged.of_name(name)) >= 0.01}


if __name__ == "__main__":
    main()

"""The blind check of robots: recordings made in MuJoCo by authors who have not seen the model.

    python scripts/blind_robots.py make PLANT SEED COUNT FOLDER   record cases, with their answers in FOLDER/answers.json
    python scripts/blind_robots.py run FOLDER [--jobs N]          diagnose the cases without a verdict
    python scripts/blind_robots.py show FOLDER ... [-o FILE]      score the verdicts; write them into one file, which it reads too

Two plants are in ``hsr_pin/blind/plants/others``. ``robot``: five robots of the package example-robot-data, driven by torques,
with faults in MuJoCo's own form. ``servo``: three arms of servos, driven by commanded angles. Slight nuisances, such as friction
or masses that are a little off, are not faults, and naming them is not a mistake.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from hsr_pin.blind.plants.others import mujoco_robot, mujoco_servo
from hsr_pin.output import write_text
from hsr_pin.parallel import for_each
from hsr_pin.robots import explain_robot
from hsr_pin.robots.causes import CAUSES

PLANTS = {"robot": mujoco_robot, "servo": mujoco_servo}
KINDS = {cause.name: cause.kind for cause in CAUSES}
#: Names by which the plants call a cause of the catalogue.
SAME = {"quadratic_drag": "quadratic_damping"}
#: Grades, the best first.
GRADES = ("exact", "alternatives", "part", "kind", "silent", "wrong")


def make(plant: str, seed: int, count: int, folder: Path) -> None:
    """Record cases of a plant."""
    answers = {}
    for number in range(1, count + 1):
        case = folder / f"case_{number:03d}"
        case.mkdir(parents=True)
        answers[case.name] = PLANTS[plant].record(case, 1000 * seed + number)
    write_text(folder / "answers.json", json.dumps(answers, indent=1))


def diagnose(case: Path) -> None:
    """Write the verdict on one case next to its folder."""
    found = explain_robot(case)
    document = found.to_json()
    kept = {key: document[key] for key in ("verdict", "posterior", "ladder", "notes")}
    write_text(case.with_suffix(".json"), json.dumps(kept, indent=1))


def background(answer: dict[str, Any]) -> set[str]:
    """Return the names of slight nuisances, which may be named without a mistake."""
    slight = answer["nuisance"]
    names = {name for name in KINDS if slight.get(name)}
    return names | ({"link_mass", "link_inertia", "centre_of_mass"} if slight.get("nominal_numbers") else set())


def grade(answer: dict[str, Any], verdict: dict[str, Any]) -> str:
    """Return the grade of a verdict; what entered the catalogue after the diagnosis counts as outside of it."""
    causes = {SAME.get(name, name) for name in answer["causes"]}
    known = set(KINDS) - set(verdict.get("unknown", ()))
    true = causes if answer["kind"] in ("single", "pair") or causes <= known else set()
    there, kinds = true | background(answer), {KINDS[name] for name in true if name in KINDS}
    sets = [set(names) for names in verdict["alternatives"]] or [set(verdict["effects"])]
    if verdict["status"] in ("no_gap", "parameters", "unexplained", "insufficient") or not any(sets):
        return "exact" if not true else "silent"
    if any(true <= names <= there for names in sets):
        return "exact" if len(sets) == 1 else "alternatives"
    if any(names and names <= there for names in sets):
        return "part" if any(names & true for names in sets) else ("exact" if not true else "silent")
    said = {KINDS[name] for names in sets for name in names - there}
    return "kind" if said <= kinds else "wrong"


def show(answers: dict[str, Any], verdicts: dict[str, Any]) -> None:
    """Print the table of grades, and every case whose verdict is not right."""
    rows: dict[str, Counter[str]] = {}
    for name, answer in answers.items():
        if name in verdicts:
            rows.setdefault(answer["kind"], Counter())[grade(answer, verdicts[name]["verdict"])] += 1
    print(f"{'':<10}" + "".join(f"{each:>14}" for each in (*GRADES, "of")))
    for kind in ("single", "pair", "none", "outside"):
        counts = rows.get(kind, Counter())
        print(f"{kind:<10}" + "".join(f"{counts[each]:>14}" for each in GRADES) + f"{counts.total():>14}")
    wrong = sum(counts["wrong"] for counts in rows.values())
    print(f"wrong names: {wrong} of {sum(counts.total() for counts in rows.values())}")
    for name, answer in answers.items():
        if name in verdicts and (given := grade(answer, verdicts[name]["verdict"])) not in GRADES[:2]:
            verdict = verdicts[name]["verdict"]
            said = " or ".join(" + ".join(names) for names in verdict["alternatives"]) or " + ".join(verdict["effects"])
            print(f"  {name} {given}: {' + '.join(answer['causes'])}, told as {said or verdict['status']}")


def load(place: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return answers and verdicts from the folder of a check, or from a file that ``show -o`` wrote."""
    if place.is_file():
        whole = json.loads(place.read_text(encoding="utf-8"))
        return whole["answers"], whole["verdicts"]
    answers = json.loads((place / "answers.json").read_text(encoding="utf-8"))
    files = [place / f"{name}.json" for name in answers]
    return answers, {file.stem: json.loads(file.read_text(encoding="utf-8")) for file in files if file.is_file()}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("make", "run", "show"))
    parser.add_argument("places", nargs="+")
    parser.add_argument("--jobs", type=int, default=None)
    parser.add_argument("-o", dest="out", type=Path)
    chosen = parser.parse_args(arguments)
    if chosen.what == "make":
        plant, seed, count, folder = chosen.places
        make(plant, int(seed), int(count), Path(folder))
    elif chosen.what == "run":
        folder = Path(chosen.places[0])
        todo = [case for case in sorted(folder.glob("case_*")) if case.is_dir() and not case.with_suffix(".json").exists()]
        for_each(diagnose, todo, jobs=chosen.jobs)
    else:
        answers, verdicts = {}, {}
        for number, place in enumerate(chosen.places, 1):
            prefix = f"{number}/" if len(chosen.places) > 1 else ""
            for whole, part in zip((answers, verdicts), load(Path(place)), strict=True):
                whole |= {f"{prefix}{name}": each for name, each in part.items()}
        show(answers, verdicts)
        if chosen.out:
            write_text(chosen.out, json.dumps({"answers": answers, "verdicts": verdicts}, indent=1))


if __name__ == "__main__":
    main()

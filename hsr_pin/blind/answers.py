"""Answers of a blind check: one file, sealed by its hash and kept apart from the recordings."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hsr_pin.blind.kinds import kinds_of, names_of
from hsr_pin.errors import InputError, RecordingError
from hsr_pin.output import write_text
from hsr_pin.recordings.files import LARGEST_RESULT, read_bytes
from hsr_pin.recordings.text import read_text

FORMAT = 1
SEAL = "SEALED.txt"
_HASH = "SHA-256 of the answers: "


@dataclass(frozen=True)
class Answer:
    """True content of one case.

    Attributes:
        name, kind, tier: as in :class:`~hsr_pin.blind.cases.Case`.
        effects: names of the effects, as in the catalogue if it contains them.
        size: named size of the marker gap of a single effect or of a law outside the catalogue; else empty.
        names: for each effect, the names that are right answers.
        kinds: for each effect, the kinds of physics that describe it.
        background: names of small additional effects that may be named without a mistake.
        facts: all other facts, for people: laws with parameters, gaps, plant, program, nuisances, seed.
    """

    name: str
    kind: str
    effects: tuple[str, ...]
    size: str
    facts: dict[str, Any]
    tier: str = "clean"
    names: tuple[tuple[str, ...], ...] = ()
    kinds: tuple[tuple[str, ...], ...] = ()
    background: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.names:
            object.__setattr__(self, "names", tuple(map(names_of, self.effects)))
        if not self.kinds:
            object.__setattr__(self, "kinds", tuple(map(kinds_of, self.effects)))

    def document(self) -> dict[str, Any]:
        """Return the answer as a JSON document."""
        fields = {"name": self.name, "tier": self.tier, "kind": self.kind, "effects": list(self.effects), "size": self.size}
        truth = {"names": [*map(list, self.names)], "kinds": [*map(list, self.kinds)], "background": list(self.background)}
        return {**fields, **truth, **self.facts}

    @classmethod
    def of(cls, document: dict[str, Any]) -> Answer:
        """Return the answer from a document that :meth:`document` returned."""
        facts = dict(document)
        name, kind, effects, size = (facts.pop(key) for key in ("name", "kind", "effects", "size"))
        tier = facts.pop("tier", "clean")
        names, kinds = (tuple(map(tuple, facts.pop(key, ()))) for key in ("names", "kinds"))
        return cls(name, kind, tuple(effects), size, facts, tier, names, kinds, tuple(facts.pop("background", ())))


def seal(folder: Path, file: Path, seed: int, answers: list[Answer]) -> None:
    """Write the answers to ``file``, and their hash into ``folder``."""
    document = {"format": FORMAT, "seed": seed, "cases": [answer.document() for answer in answers]}
    text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    write_text(file, text)
    write_text(folder / SEAL, f"{len(answers)} cases\n{_HASH}{_digest(text.encode())}\n")


def unseal(folder: Path, file: Path) -> list[Answer]:
    """Return the answers, after comparing them with the hash in the folder.

    Raises:
        InputError: the answers are missing, or they differ from the sealed ones.
    """
    try:
        sealed = read_text(folder / SEAL, LARGEST_RESULT)
        content = read_bytes(file, LARGEST_RESULT)
    except RecordingError as error:
        expected, received = f"{SEAL} in the folder, and the file", error.received or error.subject
        raise InputError("answers", expected=expected, received=received, file=error.file) from error
    if f"{_HASH}{_digest(content)}\n" not in sealed:
        raise InputError("answers", expected=f"the hash in {SEAL}", received=_digest(content), file=file)
    try:
        return [Answer.of(case) for case in json.loads(content)["cases"]]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError("answers", expected="answers written by hsr-blind make", received=repr(error), file=file) from error


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()

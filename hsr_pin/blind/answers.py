"""The answers of a blind check: one file, sealed by its hash, kept apart from the recordings."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hsr_pin.errors import InputError
from hsr_pin.output import write_text

FORMAT = 1
SEAL = "SEALED.txt"
_HASH = "SHA-256 of the answers: "


@dataclass(frozen=True)
class Answer:
    """What is in one case.

    Attributes:
        name, kind, effects: as in :class:`~hsr_pin.blind.cases.Case`.
        size: the named size that was reached, of a single effect or a law outside the catalogue; else empty.
        facts: everything else, for people: laws with parameters, gaps, plant, program, nuisances, seed.
    """

    name: str
    kind: str
    effects: tuple[str, ...]
    size: str
    facts: dict[str, Any]

    def document(self) -> dict[str, Any]:
        """As it stands in the file."""
        return {"name": self.name, "kind": self.kind, "effects": list(self.effects), "size": self.size, **self.facts}

    @classmethod
    def of(cls, document: dict[str, Any]) -> Answer:
        """From what `document` gave."""
        facts = dict(document)
        name, kind, effects, size = (facts.pop(key) for key in ("name", "kind", "effects", "size"))
        return cls(name, kind, tuple(effects), size, facts)


def seal(folder: Path, file: Path, seed: int, answers: list[Answer]) -> None:
    """Write the answers to ``file`` and their hash into ``folder``."""
    document = {"format": FORMAT, "seed": seed, "cases": [answer.document() for answer in answers]}
    text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    write_text(file, text)
    write_text(folder / SEAL, f"{len(answers)} cases\n{_HASH}{_digest(text.encode())}\n")


def unseal(folder: Path, file: Path) -> list[Answer]:
    """The answers, if they are those that were sealed.

    Raises:
        InputError: they are not, or there are none.
    """
    try:
        sealed = (folder / SEAL).read_text(encoding="utf-8")
        content = file.read_bytes()
    except OSError as error:
        raise InputError(
            "answers", expected=f"{SEAL} in the folder, and the file", received=error.strerror, file=error.filename
        ) from error
    if f"{_HASH}{_digest(content)}\n" not in sealed:
        raise InputError("answers", expected=f"the hash that {SEAL} gives", received=_digest(content), file=file)
    return [Answer.of(case) for case in json.loads(content)["cases"]]


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()

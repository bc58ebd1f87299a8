"""Several recordings of one arm in order, each compared with the first one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from hsr_pin.diagnosis.change.diagnose import ChangeDiagnosis, diagnose_change
from hsr_pin.diagnosis.change.size import Size
from hsr_pin.errors import IdentificationError
from hsr_pin.trajectory import Dataset

#: Quantities that are reported for every session.
_ALWAYS = ("keq_scale", "damping_scale")


@dataclass(frozen=True)
class Point:
    """Value of one quantity in one session.

    Attributes:
        value: the value.
        interval: 95 % interval, or the range of undetectable changes if no change was detected; None if it is unknown.
        changed: "certain", "perhaps" (among the alternatives) or "".
    """

    value: float
    interval: tuple[float, float] | None
    changed: str


@dataclass(frozen=True)
class Quantity:
    """One quantity over the sessions.

    Attributes:
        name: "keq_scale", "effect.parameter".
        unit: unit of the values; "1" for a ratio.
        points: one for each session; the first one is the reference.
        first: index of the first session with a certain change; None without any.
    """

    name: str
    unit: str
    points: tuple[Point, ...]
    first: int | None


@dataclass(frozen=True, eq=False)
class History:
    """Comparison of all sessions with the first one.

    Attributes:
        names: names of the datasets in order.
        diagnoses: diagnosis of each dataset but the first, compared with the first.
        quantities: stiffness, damping, and all quantities that changed in any session.
    """

    names: tuple[str, ...]
    diagnoses: tuple[ChangeDiagnosis, ...]
    quantities: tuple[Quantity, ...]


def history(sessions: Sequence[Dataset], **options: Any) -> History:
    """Compare each of several recordings of an arm with the first one.

    Args:
        sessions: two or more recordings in order.
        options: further arguments of :func:`hsr_pin.diagnosis.change.diagnose.diagnose_change`.

    Raises:
        IdentificationError: there are fewer than two recordings, or a comparison is not possible.
    """
    if len(sessions) < 2:
        raise IdentificationError("sessions", expected="two or more", received=len(sessions))
    tell: Callable[[str], None] = options.pop("tell", lambda line: None)
    found: list[ChangeDiagnosis] = []
    for session in sessions[1:]:
        known = found[0].reference if found else None
        found.append(
            diagnose_change(
                session,
                sessions[0],
                reference=known,
                tell=lambda line, name=session.name: tell(f"{name}: {line}"),  # type: ignore[misc]
                **options,
            )
        )
    return history_of(found)


def history_of(diagnoses: Sequence[ChangeDiagnosis]) -> History:
    """Return the history of one or more comparisons with the same reference recording."""
    pairs = [each.pair for each in diagnoses]
    names = (pairs[0].old.dataset.name, *(pair.new.dataset.name for pair in pairs))
    return History(names, tuple(diagnoses), _quantities(diagnoses))


def _quantities(diagnoses: Sequence[ChangeDiagnosis]) -> tuple[Quantity, ...]:
    units: dict[str, str] = dict.fromkeys(_ALWAYS, "1")
    for each in diagnoses:
        if each.verdict.status != "unexplained":
            units |= {size.parameter: size.unit for size in each.verdict.changes if size.before is not None}
    found = []
    for name, unit in units.items():
        start = next((size for each in diagnoses for size in each.verdict.changes if size.parameter == name), None)
        base = _base(diagnoses, name, start)
        if base is None:
            continue
        points = [base, *(_point(each, name, base) for each in diagnoses)]
        certain = [k for k, point in enumerate(points) if point.changed == "certain"]
        found.append(Quantity(name, unit, tuple(points), certain[0] if certain else None))
    return tuple(found)


def _base(diagnoses: Sequence[ChangeDiagnosis], name: str, start: Size | None) -> Point | None:
    """Return the value of a quantity in the first session."""
    if start is not None and start.before is not None:
        return Point(start.before, start.was, "")
    known = next((each.found for each in diagnoses if each.found is not None), None)
    if known is None or name not in known.frame.hypothesis.free:
        return None
    value = float(known.frame.values[known.frame.hypothesis.free.index(name)])
    return Point(value, known.was.get(name), "")


def _point(diagnosis: ChangeDiagnosis, name: str, base: Point) -> Point:
    verdict = diagnosis.verdict
    size = next((each for each in verdict.changes if each.parameter == name), None)
    owner = name.partition(".")[0]
    if size is not None and verdict.status != "unexplained":
        return Point(size.after, size.becomes, "certain" if owner in verdict.effects else "perhaps")
    limit = verdict.limits.get(owner)
    if limit is None:
        return Point(base.value, None, "")
    reach = limit * base.value if name in _ALWAYS else limit
    return Point(base.value, (base.value - reach, base.value + reach), "")

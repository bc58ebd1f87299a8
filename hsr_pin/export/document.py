"""A fit or a diagnosis, read from the JSON that hsr-fit and hsr-diagnose write; fields that are not asked for may be anything."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from hsr_pin.effects.catalogue import effect_named
from hsr_pin.effects.effect import Effect
from hsr_pin.errors import EffectError, InputError, RecordingError, quoted
from hsr_pin.export.model import CorrectedModel
from hsr_pin.export.schema import ARM_SECTION, DIAGNOSIS, FIT
from hsr_pin.identification.arm_document import levels
from hsr_pin.identification.hypothesis import LINKS
from hsr_pin.identification.part import ARM, SESSION
from hsr_pin.recordings.files import LARGEST_RESULT
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.text import read_text
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Marker, Section

#: Schemas of results that are read: of a fit and of an older diagnosis, and of a diagnosis.
_SCHEMAS = (1, 2)
#: Fitted factors on numbers of the arm.
_SCALES = {"keq_scale": "keq", "damping_scale": "damping", "mass_scale": "mass"}
#: What tells of a section, and of the place of a marker.
_SECTION, _PLACE = ("length", "mass", "keq", "damping"), ("arc_length", "radius", "angle")
#: Verdicts that say which effects act; with any other the best of all models is taken.
_CERTAIN = ("identified", "parameters", "no_gap")


def read_result(
    path: str | Path, *, keq: float | None = None, dataset: str | Path | None = None, changes: Mapping[str, Any] | None = None
) -> CorrectedModel:
    """The model that a fit or a diagnosis found.

    Args:
        path: of the JSON.
        keq: the declared stiffness [Nm/rad] that is meant; None: the only one.
        dataset: folder of the recordings, for a document that does not tell what they declare.
        changes: of the arm, by field ("links", "tip_mass" ...), made last.

    Raises:
        InputError: not such a document, not the arm's numbers in it, several stiffnesses and none chosen.
        EffectError: it tells of an effect that this hsr_pin does not know.
        SpecificationError: the arm is none that can be.
        RecordingError: the dataset cannot be read.
    """
    document = _read(path)
    with _in(path):
        return _model(document, _declared(document, dataset), keq, changes or {})


@contextmanager
def _in(path: str | Path) -> Iterator[None]:
    """Errors in here name the file, where they do not name one yet."""
    try:
        yield
    except InputError as error:
        if error.file is not None:
            raise
        raise type(error)(error.subject, expected=error.expected, received=error.received, hint=error.hint, file=path) from error


def _model(document: dict[str, Any], declared: dict[str, Any], keq: float | None, changes: Mapping[str, Any]) -> CorrectedModel:
    level = _level(declared["levels"], keq)
    found = _diagnosis if "candidates" in document else _fit
    values, effects, origin = found(document, declared, level["keq"])
    sections = tuple(Section(**_floats(row, *_SECTION)) for row in declared.get("sections", ()))
    torsion = declared.get("torsion")
    arm = ArmSpecification(
        links=declared.get("links", LINKS),
        placement=declared.get("placement", "mid"),
        mount=declared["mount"],
        bending=declared.get("bending", "plane"),
        torsion=math.inf if torsion is None else float(torsion),
        sections=sections,
        **_floats(declared, "length", "mass", "diameter"),
        **_floats({"tip_mass": 0.0, **level}, "keq", "damping", "tip_mass"),
    )
    scaled = {field: getattr(arm, field) * _factor(values, name, arm.keq) for name, field in _SCALES.items()}
    if "keq_drift" in values:
        scaled["keq"] *= 1 + values["keq_drift"]
        origin = (*origin, "the stiffness is that of the last trial: it changed over the session (keq_drift)")
    if "gain_drift" in values:
        origin = (*origin, "the gain of the torque is that of the last trial: it changed over the session (gain_drift)")
    told: tuple[str, ...] = (
        f"commands are torques as recorded: Keq {arm.keq:g} Nm/rad times the bending of Eq. (4), whatever stiffness was fitted",
    )
    if arm.bending == "space":
        told = _inputs(declared, max(1, len(sections)))
    return CorrectedModel(
        replace(arm, **{**scaled, **changes}),
        effects,
        _factor(values, "torque_gain", arm.keq) * (1 + values.get("gain_drift", 0.0)),
        tuple(Marker(row["name"], **_floats({"radius": 0.0, "angle": 0.0, **row}, *_PLACE)) for row in declared["markers"]),
        origin=(*origin, *told),
    )


def _read(path: str | Path) -> dict[str, Any]:
    expected = "the JSON of hsr-fit --json or hsr-diagnose --json"
    try:
        document = json.loads(read_text(Path(path), LARGEST_RESULT))
    except RecordingError:
        raise
    except json.JSONDecodeError as error:
        raise InputError(
            "not JSON", expected=expected, received=error.msg, file=path, line=error.lineno, column=error.colno
        ) from error
    except (ValueError, RecursionError) as error:  # a number of too many digits, brackets within brackets
        raise InputError("not JSON", expected=expected, received=error, file=path) from error
    if not isinstance(document, dict) or not ("candidates" in document or "parameters" in document):
        raise InputError("not a result", expected=expected, received=type(document).__name__, file=path)
    if document.get("schema") not in _SCHEMAS:
        hint = "read it with the hsr_pin that wrote it"
        raise InputError("schema", expected="1 or 2", received=document.get("schema"), hint=hint, file=path)
    with _in(path):
        (DIAGNOSIS if "candidates" in document else FIT)(document, "")
    return document


def _declared(document: dict[str, Any], dataset: str | Path | None) -> dict[str, Any]:
    """The section ``arm``, or what the recordings declare."""
    if dataset is not None:
        read = read_dataset(dataset)
        rows = levels([(trial.keq, trial.damping, trial.tip_mass) for trial in read.trials])
        markers = [asdict(marker) for marker in read.markers]
        chain: dict[str, Any] = {name: document[name] for name in ("links", "placement") if name in document}
        found = {name: getattr(read, name) for name in ("length", "mass", "diameter", "mount", "bending", "torsion")}
        found["sections"] = [asdict(section) for section in read.sections]
        found["inputs"] = [asdict(channel) for channel in read.channels if channel.torque]
        return {**found, "levels": rows, "markers": markers, **chain}
    if "arm" not in document:
        hint = "give the recordings too: --dataset DIR"
        raise InputError("arm", expected="a section that tells what the recordings declare", received="none", hint=hint)
    ARM_SECTION(document["arm"], "arm")
    return dict(document["arm"])


def _inputs(declared: dict[str, Any], parts: int) -> tuple[str, ...]:
    """A sentence for each channel from which the recorded torques were made."""
    told = []
    for place, row in enumerate(declared.get("inputs", ())):
        if len(row["torque"]) != 2 * parts:
            expected = f"{2 * parts} numbers, two for each section"
            raise InputError(f"arm.inputs[{place}].torque", expected=expected, received=len(row["torque"]))
        gives = ", ".join(f"{value:.6g}" for value in row["torque"])
        told.append(f"{row['name']}: each {row['unit']} of it is a command of ({gives}) N m")
    return tuple(told)


def _level(rows: list[dict[str, float]], keq: float | None) -> dict[str, float]:
    known = " or ".join(f"{row['keq']:g}" for row in rows)
    if keq is None and len(rows) > 1:
        raise InputError("--keq", expected=f"one of the declared stiffnesses, {known} Nm/rad", received="none")
    chosen = [row for row in rows if keq is None or math.isclose(row["keq"], keq, rel_tol=1e-6)]
    if not chosen:
        raise InputError("--keq", expected=f"a declared stiffness, {known} Nm/rad", received=keq)
    return chosen[0]


def _diagnosis(
    document: dict[str, Any], declared: dict[str, Any], keq: float
) -> tuple[dict[str, float], tuple[Effect, ...], tuple[str, ...]]:
    """Values of the parameters, effects, and where they come from."""
    verdict, tried = document.get("verdict", {}), document["candidates"]
    chosen = max(tried, key=lambda each: each.get("probability", 0.0))
    if verdict.get("status") in _CERTAIN:
        wanted = sorted(verdict.get("effects", []))
        chosen = next((each for each in tried if sorted(each["effects"]) == wanted), chosen)
    values = _values(chosen["parameters"])
    names = [name for name in chosen["effects"] if name not in ARM | SESSION]  # an open number of the arm may stand among them
    acting = [row["name"] for row in declared.get("effects", ())]
    names = acting if sorted(acting) == sorted(names) else names  # in the order in which they act, where it is told
    options: dict[str, dict[str, str]] = {name: {} for name in names}
    for name, choice in chosen.get("options", {}).items():
        effect, _, option = name.partition(".")
        options.setdefault(effect, {})[option] = choice
    resized, level = chosen.get("resized", ()), keq / declared["levels"][0]["keq"]
    here = _at(values, keq)
    effects = tuple(_effect(name, here, options[name], level if name in resized else 1.0) for name in names)
    origin = [f"a diagnosis of {document.get('dataset')}: {verdict.get('sentence', '')}".strip()]
    if verdict.get("status") not in _CERTAIN:
        told = " + ".join(chosen["effects"]) or "no effect"
        origin.append(f"the verdict leaves open what acts; this is the most probable model, with {told}")
    return values, effects, tuple(origin)


def _fit(
    document: dict[str, Any], declared: dict[str, Any], keq: float
) -> tuple[dict[str, float], tuple[Effect, ...], tuple[str, ...]]:
    values = _values(document["parameters"])
    here = _at(values, keq)
    rows = declared.get("effects") or [{"name": name} for name in document.get("effects", [])]
    effects = []
    for row in rows:
        known = {f"{row['name']}.{name}": value for name, value in row.get("parameters", {}).items()}
        effects.append(_effect(row["name"], {**known, **here}, row.get("options", {})))
    return values, tuple(effects), (f"a fit to {document.get('dataset')}",)


def _effect(name: str, values: dict[str, float], options: dict[str, str], level: float = 1.0) -> Effect:
    """The effect at its values; one whose amplitude goes with the stiffness level against its law, at that level."""
    kind = effect_named(name)
    for option in options.keys() - kind.choices():
        known = " or ".join(kind.choices()) or "no option"
        raise EffectError(f"an option of {name}", expected=known, received=quoted(option))
    facts = {}
    for fact in kind.parameters():
        if f"{name}.{fact.name}" in values:
            value = values[f"{name}.{fact.name}"]
            scaled = value * level**fact.resizes if fact.amplitude else value
            facts[fact.name] = value if level == 1.0 else min(max(scaled, fact.lower), fact.upper)
    return kind(**facts, **options)


def _factor(values: dict[str, float], base: str, keq: float) -> float:
    """A fitted factor at a declared stiffness; 1 if it was not fitted."""
    fitted = {name: value for name, value in values.items() if name.partition("@")[0] == base}
    if not fitted:
        return 1.0
    if base in (here := _at(values, keq)):
        return here[base]
    raise InputError(base, expected=f"a value at Keq {keq:g} Nm/rad", received=", ".join(fitted))


def _at(values: dict[str, float], keq: float) -> dict[str, float]:
    """The values that hold at a declared stiffness, without it in their names."""
    parts = [(*name.partition("@"), value) for name, value in values.items()]
    return {base: value for base, at, level, value in parts if not at or _is_near(level, keq)}


def _is_near(level: str, keq: float) -> bool:
    try:
        return math.isclose(float(level), keq, rel_tol=1e-5)  # names have six digits
    except ValueError:
        return False


def _values(parameters: dict[str, Any]) -> dict[str, float]:
    return {name: float(told["value"] if isinstance(told, dict) else told) for name, told in parameters.items()}


def _floats(row: Mapping[str, Any], *names: str) -> dict[str, float]:
    return {name: float(row[name]) for name in names}

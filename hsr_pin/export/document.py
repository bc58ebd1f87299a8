"""Reading of a fit or a diagnosis from the JSON of hsr-fit and hsr-diagnose; fields that are not used are not checked."""

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
from hsr_pin.obstacles import from_dict, to_dict
from hsr_pin.recordings.files import LARGEST_RESULT
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.text import read_text
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.trajectory import Marker, Section

#: Supported schemas: 1 of fits and older diagnoses, 2 of diagnoses.
_SCHEMAS = (1, 2)
#: Fitted factors, and the numbers of the arm to which they apply.
_SCALES = {"keq_scale": "keq", "damping_scale": "damping", "mass_scale": "mass"}
#: Fields of a section, and of the position of a marker.
_SECTION, _PLACE = ("length", "mass", "keq", "damping"), ("arc_length", "radius", "angle")
#: Verdicts that determine the effects; otherwise the most probable model is used.
_DETERMINED = ("identified", "parameters", "no_gap")


def read_result(
    path: str | Path, *, keq: float | None = None, dataset: str | Path | None = None, changes: Mapping[str, Any] | None = None
) -> CorrectedModel:
    """Return the model found by a fit or a diagnosis.

    Args:
        path: path of the JSON.
        keq: declared stiffness [Nm/rad] whose model is returned; None: the only one.
        dataset: folder of the recordings, for a document without their declaration.
        changes: final changes of the arm, by field ("links", "tip_mass", ...).

    Raises:
        InputError: the file is not a result, the arm is not described, or one of several stiffnesses must be chosen.
        EffectError: the result contains an effect that this version of hsr_pin does not know.
        SpecificationError: the arm is invalid.
        RecordingError: the dataset cannot be read.
    """
    document = _read(path)
    with _in(path):
        return _model(document, _declared(document, dataset), keq, changes or {})


@contextmanager
def _in(path: str | Path) -> Iterator[None]:
    """Add the name of the file to errors within the context that do not name one."""
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
        obstacles=tuple(map(from_dict, declared.get("obstacles", ()))),
        **_floats(declared, "length", "mass", "diameter"),
        **_floats({"tip_mass": 0.0, **level}, "keq", "damping", "tip_mass"),
    )
    scaled = {field: getattr(arm, field) * _factor(values, name, arm.keq) for name, field in _SCALES.items()}
    if "keq_drift" in values:
        scaled["keq"] *= 1 + values["keq_drift"]
        origin = (*origin, "the stiffness is that of the last trial, as it drifted over the session (keq_drift)")
    if "gain_drift" in values:
        origin = (*origin, "the gain of the torque is that of the last trial, as it drifted over the session (gain_drift)")
    commands: tuple[str, ...] = (
        f"commands are recorded torques: Keq {arm.keq:g} Nm/rad times the bending of Eq. (4), not the fitted stiffness",
    )
    if arm.bending == "space":
        commands = _inputs(declared, max(1, len(sections)))
    return CorrectedModel(
        replace(arm, **{**scaled, **changes}),
        effects,
        _factor(values, "torque_gain", arm.keq) * (1 + values.get("gain_drift", 0.0)),
        tuple(Marker(row["name"], **_floats({"radius": 0.0, "angle": 0.0, **row}, *_PLACE)) for row in declared["markers"]),
        origin=(*origin, *commands),
    )


def _read(path: str | Path) -> dict[str, Any]:
    expected = "the JSON of hsr-fit --json or hsr-diagnose --json"
    try:
        document = json.loads(read_text(Path(path), LARGEST_RESULT))
    except RecordingError:
        raise
    except json.JSONDecodeError as error:
        raise InputError(
            "invalid JSON", expected=expected, received=error.msg, file=path, line=error.lineno, column=error.colno
        ) from error
    except (ValueError, RecursionError) as error:  # a number with too many digits, or too many nested brackets
        raise InputError("invalid JSON", expected=expected, received=error, file=path) from error
    if not isinstance(document, dict) or not ("candidates" in document or "parameters" in document):
        raise InputError("the file is not a result", expected=expected, received=type(document).__name__, file=path)
    if document.get("schema") not in _SCHEMAS:
        hint = "read it with the version of hsr_pin that wrote it"
        raise InputError("schema", expected="1 or 2", received=document.get("schema"), hint=hint, file=path)
    with _in(path):
        (DIAGNOSIS if "candidates" in document else FIT)(document, "")
    return document


def _declared(document: dict[str, Any], dataset: str | Path | None) -> dict[str, Any]:
    """Return the declaration of the arm from the section ``arm`` of a result, or from the recordings."""
    if dataset is not None:
        read = read_dataset(dataset)
        rows = levels([(trial.keq, trial.damping, trial.tip_mass) for trial in read.trials])
        markers = [asdict(marker) for marker in read.markers]
        chain: dict[str, Any] = {name: document[name] for name in ("links", "placement") if name in document}
        found = {name: getattr(read, name) for name in ("length", "mass", "diameter", "mount", "bending", "torsion")}
        found["sections"] = [asdict(section) for section in read.sections]
        found["obstacles"] = [to_dict(obstacle) for obstacle in read.obstacles]
        found["inputs"] = [asdict(channel) for channel in read.channels if channel.torque]
        return {**found, "levels": rows, "markers": markers, **chain}
    if "arm" not in document:
        hint = "give the recordings with --dataset DIR"
        raise InputError("arm", expected="a section with the declaration of the recordings", received="none", hint=hint)
    ARM_SECTION(document["arm"], "arm")
    return dict(document["arm"])


def _inputs(declared: dict[str, Any], parts: int) -> tuple[str, ...]:
    """Return a sentence for each channel from which the recorded torques were computed."""
    sentences = []
    for place, row in enumerate(declared.get("inputs", ())):
        if len(row["torque"]) != 2 * parts:
            expected = f"{2 * parts} numbers, two for each section"
            raise InputError(f"arm.inputs[{place}].torque", expected=expected, received=len(row["torque"]))
        gives = ", ".join(f"{value:.6g}" for value in row["torque"])
        sentences.append(f"{row['name']}: each {row['unit']} corresponds to a command of ({gives}) N m")
    return tuple(sentences)


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
    """Return the values of the parameters, the effects, and their origin."""
    verdict, tried = document.get("verdict", {}), document["candidates"]
    chosen = max(tried, key=lambda each: each.get("probability", 0.0))
    if verdict.get("status") in _DETERMINED:
        wanted = sorted(verdict.get("effects", []))
        chosen = next((each for each in tried if sorted(each["effects"]) == wanted), chosen)
    values = _values(chosen["parameters"])
    names = [name for name in chosen["effects"] if name not in ARM | SESSION]  # the names may include numbers of the arm
    acting = [row["name"] for row in declared.get("effects", ())]
    names = acting if sorted(acting) == sorted(names) else names  # in the order in which they act, if it is known
    options: dict[str, dict[str, str]] = {name: {} for name in names}
    for name, choice in chosen.get("options", {}).items():
        effect, _, option = name.partition(".")
        options.setdefault(effect, {})[option] = choice
    resized, level = chosen.get("resized", ()), keq / declared["levels"][0]["keq"]
    here = _at(values, keq)
    effects = tuple(_effect(name, here, options[name], level if name in resized else 1.0) for name in names)
    origin = [f"a diagnosis of {document.get('dataset')}: {verdict.get('sentence', '')}".strip()]
    if verdict.get("status") not in _DETERMINED:
        listed = " + ".join(chosen["effects"]) or "no effect"
        origin.append(f"the verdict does not determine the effects; this is the most probable model, with {listed}")
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
    """Return an effect with its values, with amplitudes scaled to the stiffness level if they deviate from their law."""
    kind = effect_named(name)
    for option in options.keys() - kind.choices():
        known = " or ".join(kind.choices()) or "no option"
        raise EffectError(f"an option of {name}", expected=known, received=quoted(option))
    facts = {}
    for fact in kind.parameters():
        if f"{name}.{fact.name}" in values:
            value = values[f"{name}.{fact.name}"]
            scaled = value * level**fact.level_exponent if fact.amplitude else value
            facts[fact.name] = value if level == 1.0 else min(max(scaled, fact.lower), fact.upper)
    return kind(**facts, **options)


def _factor(values: dict[str, float], base: str, keq: float) -> float:
    """Return a fitted factor at a declared stiffness; 1 if it was not fitted."""
    fitted = {name: value for name, value in values.items() if name.partition("@")[0] == base}
    if not fitted:
        return 1.0
    if base in (here := _at(values, keq)):
        return here[base]
    raise InputError(base, expected=f"a value at Keq {keq:g} Nm/rad", received=", ".join(fitted))


def _at(values: dict[str, float], keq: float) -> dict[str, float]:
    """Return the values that apply at a declared stiffness, without the stiffness in their names."""
    parts = [(*name.partition("@"), value) for name, value in values.items()]
    return {base: value for base, at, level, value in parts if not at or _is_near(level, keq)}


def _is_near(level: str, keq: float) -> bool:
    try:
        return math.isclose(float(level), keq, rel_tol=1e-5)  # names have six digits
    except ValueError:
        return False


def _values(parameters: dict[str, Any]) -> dict[str, float]:
    return {name: float(fitted["value"] if isinstance(fitted, dict) else fitted) for name, fitted in parameters.items()}


def _floats(row: Mapping[str, Any], *names: str) -> dict[str, float]:
    return {name: float(row[name]) for name in names}

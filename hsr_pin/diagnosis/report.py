"""A diagnosis as one self-contained HTML file for screen and print, without network access or scripts."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from hsr_pin.diagnosis import figures
from hsr_pin.diagnosis.indicators.indicator import counted
from hsr_pin.diagnosis.words import (
    EXPERIMENTS,
    advice,
    effect_options,
    model_name,
    readable,
    scales,
    sentence,
    supply_sentence,
    where_sentence,
)
from hsr_pin.effects import EFFECTS, Effect
from hsr_pin.effects.spatial import SPATIAL
from hsr_pin.identification.arm_document import levels
from hsr_pin.identification.prepared import Run
from hsr_pin.inference.candidate import Candidate
from hsr_pin.inference.estimates import Estimate, estimates
from hsr_pin.inference.fit import Fit
from hsr_pin.inference.uncertainty import uncertainty
from hsr_pin.inference.verdict import headline
from hsr_pin.output import write_text
from hsr_pin.report.inline_svg import inline
from hsr_pin.report.page import environment
from hsr_pin.trajectory import Array

if TYPE_CHECKING:
    from hsr_pin.diagnosis.result import Diagnosis

#: Largest number of rows in the table of probabilities, and least probability that is listed.
_ROWS, _LISTED = 8, 0.01
_COUNTED = re.compile(r"(\d+) of (\d+) samples")


def write_report(diagnosis: Diagnosis, path: str | Path) -> None:
    """Write the HTML report of a diagnosis to a file.

    Raises:
        OutputError: the file cannot be written.
    """
    write_text(path, report(diagnosis))


def report(diagnosis: Diagnosis) -> str:
    """Return the HTML report of a diagnosis as text."""
    templates = environment(Path(__file__).parent)
    templates.filters |= {"readable": readable, "in_words": where_sentence}
    return templates.get_template("report.html.jinja").render(
        diagnosis=diagnosis,
        verdict=diagnosis.verdict,
        dataset=diagnosis.experiment.dataset,
        sentence=sentence(diagnosis.verdict.sentence),
        counted=counted,
        headline=headline(diagnosis.verdict),
        advice=advice(diagnosis),
        supply=sentence(supply_sentence(diagnosis)),
        rungs=_rungs(diagnosis),
        models=_models(diagnosis),
        effects=_named(diagnosis),
        experiments=EXPERIMENTS,
        recordings=[_recording(run, diagnosis) for run in diagnosis.experiment.runs],
        notes=_notes(diagnosis),
        tried=0 if diagnosis.search is None else len(diagnosis.search.candidates),
        sets=_sets(diagnosis),
        gains=", ".join(f"{name.replace('_', ' ')} {value:g}" for name, value in asdict(diagnosis.loss).items()),
        **_figures(diagnosis),
    )


@dataclass(frozen=True)
class Model:
    """A fitted model that is shown with its parameters.

    Attributes:
        name: its effects, as text.
        rms: RMS distance on held-out trials [m].
        estimates: its parameters.
        scales: factors on the declared parameters, as text.
        options: options of ``hsr-sim`` that simulate it, for each declared Keq.
        doubts: one sentence for each parameter combination that the data hardly determine.
    """

    name: str
    rms: float
    estimates: tuple[Estimate, ...]
    scales: str
    options: dict[str, str]
    doubts: tuple[str, ...]


def shown_runs(diagnosis: Diagnosis) -> list[tuple[int, str]]:
    """Return the runs that are shown, each with the reason: the largest improvement, and the largest remaining gap."""
    declared = np.array([_square(missed) for missed in diagnosis.nominal])
    if diagnosis.search is None:
        return [(int(np.argmax(declared)), "the trial with the largest error of the declared model")]
    left = np.array([_square(missed) for missed in diagnosis.search.best.heldout])
    shrinks, remains = int(np.argmax(declared - left)), int(np.argmax(left))
    if shrinks == remains:
        return [(shrinks, "the trial with the largest improvement and the largest remaining gap")]
    return [(shrinks, "the trial with the largest improvement"), (remains, "the trial with the largest remaining gap")]


def _figures(diagnosis: Diagnosis) -> dict[str, Any]:
    runs = diagnosis.experiment.runs
    search, where = diagnosis.search, diagnosis.where
    motions = []
    for index, why in shown_runs(diagnosis):
        marker = diagnosis.experiment.markers[figures.farthest_seen(runs[index], diagnosis)].name
        caption = f"{runs[index].trial.name}, {why}: marker {marker}"
        svg = inline(figures.motion_figure(diagnosis, index), f"motion{index}", caption)
        motions.append((caption, Markup(svg)))
    drawn = {
        "ladder_svg": (figures.ladder_figure(diagnosis), "ladder", "Error of each model in the ladder"),
        "candidates_svg": (search and figures.candidates_figure(diagnosis), "candidates", "Error of each candidate"),
        "where_svg": (where and figures.where_figure(where), "where", "Maps of the gap"),
    }
    drawn_indicators = [
        (each, Markup(inline(figures.indicator_figure(each), f"indicator{k}", each.sentence)))
        for k, each in enumerate(diagnosis.indicators.items if diagnosis.indicators else ())
    ]
    svgs = {key: figure and Markup(inline(figure, *words)) for key, (figure, *words) in drawn.items()}
    return svgs | {"motions": motions, "indicators": drawn_indicators}


def _rungs(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    rows, before = [], set[str]()
    for rung in diagnosis.ladder:
        name, _, remark = rung.name.partition(" (")
        dropped = sorted(before - set(rung.effects)) if rung.effects else []
        if dropped:
            remark = f"in place of {readable(dropped)}"
        rows.append({"rung": rung, "name": readable([name]), "remark": remark.rstrip(")")})
        before = set(rung.effects)
    return rows


def _sets(diagnosis: Diagnosis) -> list[tuple[tuple[str, ...], float]]:
    """Return the most probable sets of causes with their probabilities."""
    if diagnosis.search is None:
        return []
    return [(names, p) for names, p in diagnosis.search.posterior.sets.items() if p >= _LISTED][:_ROWS]


def _models(diagnosis: Diagnosis) -> list[Model]:
    """Return the best model and the alternatives that the recordings cannot distinguish from it."""
    if diagnosis.search is None:
        return []
    best = diagnosis.search.best
    shown = [best, *(each for each in diagnosis.search.leaders(diagnosis.verdict.alternatives) if each.names != best.names)]
    declared = levels([(run.trial.keq, run.trial.damping, run.trial.tip_mass) for run in diagnosis.experiment.runs])
    return [_model(candidate, {level["keq"]: level["damping"] for level in declared}) for candidate in shown]


def _model(candidate: Candidate, damping: Mapping[float, float]) -> Model:
    fit = candidate.fit
    doubts = tuple(f"{words}." for words in uncertainty(fit).weak)
    effects = effect_options(fit, tuple(damping))
    options = {}
    for keq, c in damping.items():
        arm = f"--keq {keq * _factor(fit, 'keq_scale', keq):.4g} --damping {c * _factor(fit, 'damping_scale', keq):.4g}"
        level = f"{keq:g} Nm/rad"
        options[level] = f"{arm} {effects.get(level, effects.get('', ''))}".strip()
    return Model(model_name(candidate), candidate.heldout_square**0.5, estimates(fit), scales(fit), options, doubts)


def _factor(fit: Fit, name: str, keq: float) -> float:
    """Return a factor on a declared parameter for the trials that are declared with this Keq."""
    return fit.named.get(f"{name}@{keq:g}", fit.named.get(name, 1.0))


def _named(diagnosis: Diagnosis) -> list[type[Effect]]:
    """Return the effects that the verdict or the best model names, in the order of the catalogue."""
    names = {*diagnosis.verdict.effects, *(name for names in diagnosis.verdict.alternatives for name in names)}
    if diagnosis.search is not None:
        names |= {*diagnosis.search.best.names}
    return [effect for name, effect in (EFFECTS | SPATIAL).items() if name in names]


def _recording(run: Run, diagnosis: Diagnosis) -> dict[str, Any]:
    index = diagnosis.experiment.runs.index(run)
    trial = run.trial
    best = None if diagnosis.search is None else diagnosis.search.best.heldout[index]
    return {
        "name": trial.name,
        "seconds": float(run.time[-1] - run.time[0]),
        "rate": 1 / run.step,
        "keq": trial.keq,
        "payload": 1e3 * trial.tip_mass,
        "drive": _span(run.torque) if trial.trajectory.has_input else "released",
        "missing": float(np.isnan(run.measured).any(axis=2).mean()),
        "declared": _square(diagnosis.nominal[index]) ** 0.5,
        "best": None if best is None else _square(best) ** 0.5,
    }


def _notes(diagnosis: Diagnosis) -> list[str]:
    """Return what was left out or corrected; equal notes of several trials are merged, with their sample counts added."""
    experiment = diagnosis.experiment
    said: dict[str, list[tuple[str, int, int]]] = {}
    for run in experiment.runs:
        for note in run.trial.trajectory.notes:
            counted = _COUNTED.search(note)
            some, of = (int(counted[1]), int(counted[2])) if counted else (0, 0)
            said.setdefault(_COUNTED.sub("{} of {} samples", note, count=1), []).append((run.trial.name, some, of))
    own = []
    for note, places in said.items():
        some, of = sum(place[1] for place in places), sum(place[2] for place in places)
        text = note.replace("{} of {} samples", f"{some} of {of} samples", 1)
        own.append(f"{text} ({places[0][0] if len(places) == 1 else f'{len(places)} trials'})")
    return [*experiment.notes, *experiment.dataset.notes, *own]


def _square(missed: Array | Sequence[Array]) -> float:
    return float(np.nanmean((np.asarray(missed) ** 2).sum(axis=-1)))


def _span(torque: Array) -> str:
    """Return the range of a torque as text; of an arm in space its largest magnitude."""
    if np.iscomplexobj(torque):
        return f"up to {round(float(np.abs(torque).max()), 2):g}"
    low, high = (round(float(bound), 2) + 0.0 for bound in (torque.min(), torque.max()))
    return f"{low:g} to {high:g}"

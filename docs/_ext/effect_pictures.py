"""The page ``effects`` gets a section for every effect of the catalogue: its law, its numbers, and a picture with a slider.

What a slider shows is simulated when the site is built: the tip of one arm under one program, for some sizes of the effect.
"""

from __future__ import annotations

import inspect
import json
from dataclasses import replace

import numpy as np
from sphinx.application import Sphinx

from hsr_pin import ArmSpecification, Scenario, simulate_batch
from hsr_pin.effects import EFFECTS, Effect
from hsr_pin.effects.effect import KINDS
from hsr_pin.parameters import Parameter
from hsr_pin.trajectory import Array

ARM = ArmSpecification(links=12, keq=1.11, placement="mid")
#: [s] and [N m]: a step and back, a slow ramp up and down, a step to the other side; held between samples.
TIMES, TORQUES = (0.0, 0.2, 0.2, 1.2, 1.2, 2.0, 2.8, 3.6, 3.6, 4.4), (0.0, 0.0, 0.8, 0.8, 0.0, 0.0, 0.8, 0.0, -0.6, -0.6)
STEP = 0.02
#: Largest size that is shown, in the scales of its parameter: of a size that has one sign, and of one that has two.
ONE_WAY, BOTH_WAYS, SIZES = 6.0, 4.0, 9


def scenario() -> Scenario:
    """What the arm of the pictures goes through."""
    time = STEP * np.arange(round(TIMES[-1] / STEP) + 1)
    held = np.array([TORQUES[max(np.searchsorted(TIMES, t + STEP / 2) - 1, 0)] for t in time])
    ramp = (time >= 2.0) & (time < 3.6)
    return Scenario(ARM, time, np.where(ramp, np.interp(time, TIMES, TORQUES), held))


def sizes(fact: Parameter) -> Array:
    """The values of a slider: from nothing up, or from below nothing to above it."""
    low = max(fact.lower, fact.neutral - (BOTH_WAYS * fact.scale if fact.lower < fact.neutral else 0.0))
    high = min(fact.upper, fact.neutral + (BOTH_WAYS if fact.lower < fact.neutral else ONE_WAY) * fact.scale)
    return np.linspace(low, high, SIZES)


def family(kind: type[Effect]) -> tuple[Parameter, list[Effect]]:
    """The parameter that its slider moves, and the effect at each of its places."""
    moved, *others = [fact for fact in kind.parameters() if fact.amplitude]
    fixed = {fact.name: BOTH_WAYS * fact.scale for fact in others}
    return moved, [kind(**{moved.name: float(size)}, **fixed) for size in sizes(moved)]


def tips(effects: list[Effect]) -> Array:
    """(B, T, 2) [mm] x and z of the tip with each effect, and before them without any."""
    plain = scenario()
    results = simulate_batch([plain, *(replace(plain, effects=(effect,)) for effect in effects)])
    return np.array([1e3 * result.trajectory.marker("tip")[:, [0, 2]] for result in results])


class Frame:
    """One panel: from numbers to places in a drawing of WIDTH by HEIGHT."""

    WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 360, 250, 46, 36, 10, 8

    def __init__(self, across: Array, up: Array, labels: tuple[str, str], even: bool = False) -> None:
        self.labels = labels
        self.low = np.array([across.min(), up.min()], dtype=float)
        self.high = np.array([across.max(), up.max()], dtype=float)
        room = np.array([self.WIDTH - self.LEFT - self.RIGHT, self.HEIGHT - self.BOTTOM - self.TOP], dtype=float)
        self.high = np.maximum(self.high, self.low + 1.0)
        if even:  # a millimetre is as long upwards as sideways
            span = room * np.max((self.high - self.low) / room)
            middle = (self.low + self.high) / 2
            self.low, self.high = middle - span / 2, middle + span / 2
        margin = 0.04 * (self.high - self.low) * (1.0 if even else np.array([0.0, 1.0]))
        self.low, self.high = self.low - margin, self.high + margin
        self._factor = room / (self.high - self.low)

    def points(self, across: Array, up: Array) -> str:
        """As an SVG polyline takes them."""
        x = self.LEFT + self._factor[0] * (across - self.low[0])
        y = self.HEIGHT - self.BOTTOM - self._factor[1] * (up - self.low[1])
        return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))

    def drawing(self, about: str, nominal: str, shown: str) -> str:
        """The panel, with the arm as declared and the arm with the effect."""
        parts = [f'<svg viewBox="0 0 {self.WIDTH} {self.HEIGHT}" role="img" aria-label="{about}">']
        for axis in (0, 1):
            for tick in _ticks(self.low[axis], self.high[axis]):
                at = np.array([self.low, self.high])
                at[:, axis] = tick
                line = self.points(*at.T)
                x, y = map(float, line.split()[0].split(","))
                place = (x, y + 14, "middle") if axis == 0 else (x - 5, y + 4, "end")
                where = 'x="{:.1f}" y="{:.1f}" text-anchor="{}"'.format(*place)
                parts.append(f'<polyline class="grid" points="{line}"/><text {where}>{tick:g}</text>')
        parts.append(f'<text x="{self.WIDTH - self.RIGHT}" y="{self.HEIGHT - 4}" text-anchor="end">{self.labels[0]}</text>')
        parts.append(f'<text transform="translate(11 {self.TOP}) rotate(-90)" text-anchor="end">{self.labels[1]}</text>')
        parts.append(f'<polyline class="moved" points="{shown}"/><polyline class="declared" points="{nominal}"/></svg>')
        return "".join(parts)


def _ticks(low: float, high: float) -> Array:
    step = next(s for s in (0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500) if (high - low) / s <= 6)
    return step * np.arange(np.ceil(low / step), np.floor(high / step) + 1)


def picture(kind: type[Effect]) -> str:
    """Slider, path of the tip in the plane, and tip over time, with the effect at its largest until a script moves it."""
    moved, effects = family(kind)
    nominal, *with_effect = tips(effects)
    kept = [(effect, tip) for effect, tip in zip(effects, with_effect, strict=True) if np.isfinite(tip).all()]
    every, time = np.array([nominal, *(tip for _, tip in kept)]), scenario().time
    plane = Frame(every[..., 0], every[..., 1], ("x of the tip [mm]", "z [mm]"), even=True)
    course = Frame(time, every[..., 0], ("time [s]", "x [mm]"))
    values = [getattr(effect, moved.name) for effect, _ in kept]
    unit = "" if moved.unit == "1" else f" {moved.unit}"
    steps = [
        {
            "value": f"{value:.3g}{unit}",
            "apart": f"{np.sqrt(((tip - nominal) ** 2).sum(axis=1).mean()):.1f}",
            "points": [plane.points(*tip.T), course.points(time, tip[:, 0])],
        }
        for value, (_, tip) in zip(values, kept, strict=True)
    ]
    last, name = steps[-1], f"{kind.name}-{moved.name}"
    panels = plane.drawing(f"Path of the tip with {kind.name}", plane.points(*nominal.T), last["points"][0]) + course.drawing(
        f"Tip over time with {kind.name}", course.points(time, nominal[:, 0]), last["points"][1]
    )
    slider = (
        f'<label for="{name}">{moved.name}</label>'
        f'<input type="range" id="{name}" min="0" max="{len(steps) - 1}" value="{len(steps) - 1}">'
        f'<output for="{name}">{last["value"]}: tip {last["apart"]} mm RMS from the declared arm\'s</output>'
    )
    data = f'<script type="application/json">{json.dumps(steps, separators=(",", ":"))}</script>'
    return f'<div class="effect"><p>{slider}</p><div>{panels}</div>{data}</div>'


def section(kind: type[Effect]) -> str:
    """One effect, in Markdown."""
    moved, effects = family(kind)
    held = [fact for fact in kind.parameters() if fact.name != moved.name]
    beside = ", ".join(
        f"`{fact.name}` {getattr(effects[-1], fact.name):g} {fact.unit.removeprefix('1')}".rstrip() for fact in held
    )
    rows = [
        f"| `{fact.name}` | {fact.lower:g} to {fact.upper:g} | {fact.unit} | {fact.description} |" for fact in kind.parameters()
    ]
    options = [f"\nVariants: `{name}` is {' or '.join(choices)}." for name, choices in kind.choices().items()]
    return "\n".join(
        [
            f"## {kind.name}\n",
            f"{kind.lacks[0].upper()}{kind.lacks[1:]}; typically {kind.cause}. Kind: {kind.kind} ({KINDS[kind.kind]}).\n",
            f"```text\n{inspect.getdoc(kind)}\n```\n",
            f"```{{raw}} html\n{picture(kind)}\n```\n",
            *([f"Held at {beside}.\n"] if held else []),
            "| parameter | bounds | unit | |\n|---|---|---|---|",
            *rows,
            *options,
            f"\n`--effect {kind.name}:{moved.name}={getattr(effects[-1], moved.name):.3g}`. Source: {kind.citation}.\n",
        ]
    )


def _append(app: Sphinx, docname: str, source: list[str]) -> None:
    if docname == "effects":
        source[0] += "\n" + "\n".join(section(kind) for kind in EFFECTS.values())


def setup(app: Sphinx) -> dict[str, bool]:
    """Complete the page when it is read."""
    app.connect("source-read", _append)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Draw the animation of the README: a held-out trial, compared with the declared model and with the corrected model.

The recordings are diagnosed without that trial, and the trial is simulated with the most probable model. The output is an
animated SVG without a script, at a quarter of the speed; viewers without animation show the end.

    python scripts/moving_picture.py ../shared/recordings/sample-steps --trial trial_06 -o docs/moving.svg
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np

from hsr_pin import diagnose, read_dataset
from hsr_pin.identification.hypothesis import LINKS
from hsr_pin.output import write_text
from hsr_pin.trajectory import Array, Dataset
from hsr_pin.view.session import Answer, Session
from hsr_pin.view.settings import Settings

#: Start and end of the shown part [s], time between frames [s], slow-motion factor, and pause at the end [s].
START, END, EVERY, SLOWER, PAUSE = 0.2, 1.2, 0.02, 4.0, 1.5
#: Width and height of a panel, its margin, and the height of its error curve [pixels].
WIDTH, HEIGHT, MARGIN, ERRORS = 400, 350, 14, 90
#: Colours of simulated and measured motion: Okabe and Ito's blue and vermilion.
SIMULATED, MEASURED = "#0072B2", "#D55E00"


@dataclass(frozen=True, eq=False)
class Motion:
    """Content of one panel.

    Attributes:
        title, about: title and subtitle.
        arm: (T, P, 2) simulated points of the arm [mm].
        markers: (T, M, 2) measured marker points [mm].
        error: (T,) distance of the markers [mm].
    """

    title: str
    about: str
    arm: Array
    markers: Array
    error: Array


def motions(dataset: Dataset, trial: str, frames: int) -> list[Motion]:
    """Return the panels of a trial: with the declared model, and with the model that a diagnosis of the other trials found."""
    found = diagnose(dataset, test=[trial])
    if found.search is None:
        raise SystemExit(f"{dataset.name}: {found.verdict.sentence}")
    hypothesis, values = found.search.best.fit.hypothesis, found.search.best.fit.values
    options = {f"{effect.name}.{name}": value for effect in hypothesis.effects for name, value in effect.options}
    corrected = Settings(dict(zip(hypothesis.free, map(float, values), strict=True)), options)
    names = " and ".join(name.replace("_", " ") for name in found.search.best.names)
    drawn = []
    for title, about, session, settings in (
        ("as declared", "4 links, as in the paper", Session.of(dataset, 4, "base"), Settings()),
        ("after the diagnosis", f"with {names}", Session.of(dataset, LINKS, "mid"), corrected),
    ):
        run = session.run(trial)
        answer: Answer = session.answer(run, settings)
        shown = [int(np.argmin(abs(run.time - run.time[0] - t))) for t in np.linspace(START, END, frames)]
        arm, seen = 1e3 * answer.backbone[shown][..., [0, 2]], 1e3 * run.compared[shown]
        drawn.append(Motion(f"{title}: {1e3 * answer.rms:.2g} mm RMS", about, arm, seen, 1e3 * answer.error[shown]))
    return drawn


def picture(drawn: list[Motion]) -> str:
    """Return the SVG text of the panels."""
    every = np.concatenate([np.concatenate([m.arm.reshape(-1, 2), m.markers.reshape(-1, 2)]) for m in drawn])
    low, high = np.nanmin(every, axis=0), np.nanmax(every, axis=0)
    scale = min((WIDTH - 2 * MARGIN - 20) / (high[0] - low[0]), (HEIGHT - 90) / (high[1] - low[1]))
    most = max(np.nanmax(m.error) for m in drawn)
    panels = "".join(_panel(m, k * WIDTH, low, high, scale, most) for k, m in enumerate(drawn))
    legend = (
        f'<line x1="{MARGIN}" y1="18" x2="{MARGIN + 26}" y2="18" stroke="{SIMULATED}" stroke-width="5"/>'
        f'<text x="{MARGIN + 32}" y="22">simulated</text>'
        f'<circle cx="{MARGIN + 120}" cy="18" r="5" fill="none" stroke="{MEASURED}" stroke-width="2.5"/>'
        f'<text x="{MARGIN + 130}" y="22">measured</text>'
        f'<text x="{2 * WIDTH - MARGIN}" y="22" text-anchor="end">'
        f"a trial that nothing was fitted to, {SLOWER:g} times slower</text>"
    )
    height = HEIGHT + ERRORS + 40
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {2 * WIDTH} {height}" font-family="sans-serif" font-size="13">'
        "<title>Measured against simulated motion of an arm, before and after</title>"
        f'<rect width="100%" height="100%" fill="white"/>{legend}{panels}</svg>\n'
    )


def _panel(motion: Motion, left: float, low: Array, high: Array, scale: float, most: float) -> str:
    middle = left + WIDTH / 2 - scale * (low[0] + high[0]) / 2

    def placed(points: Array) -> Array:
        return np.stack([middle + scale * points[..., 0], 88 + scale * (high[1] - points[..., 1])], axis=-1)

    arms = [" ".join(f"{x:.1f},{y:.1f}" for x, y in placed(arm)) for arm in motion.arm]
    base, bottom = placed(np.zeros(2)), HEIGHT + ERRORS + 14
    parts = [
        f'<text x="{left + WIDTH / 2}" y="50" text-anchor="middle" font-size="16" font-weight="bold">{motion.title}</text>',
        f'<text x="{left + WIDTH / 2}" y="68" text-anchor="middle">{motion.about}</text>',
        f'<rect x="{base[0] - 14:.1f}" y="{base[1] - 8:.1f}" width="28" height="8" fill="#444444"/>',
        f'<polyline fill="none" stroke="{SIMULATED}" stroke-width="9" stroke-opacity="0.75" stroke-linejoin="round" '
        f'stroke-linecap="round" points="{arms[-1]}">{_moving("points", arms)}</polyline>',
    ]
    for m in range(motion.markers.shape[1]):
        x, y = placed(motion.markers[:, m]).T
        seen = np.isfinite(x)
        x, y = (np.interp(np.arange(len(x)), np.flatnonzero(seen), axis[seen]) for axis in (x, y))
        parts.append(
            f'<circle r="6" fill="none" stroke="{MEASURED}" stroke-width="2.5" cx="{x[-1]:.1f}" cy="{y[-1]:.1f}">'
            f"{_moving('cx', [f'{v:.1f}' for v in x])}{_moving('cy', [f'{v:.1f}' for v in y])}</circle>"
        )
    across = np.linspace(left + 40, left + WIDTH - MARGIN, len(motion.error))
    up = bottom - (ERRORS - 10) * motion.error / most
    curve = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, up, strict=True) if np.isfinite(y))
    places = [f"{x:.1f}" for x in across]
    parts += [
        f'<polyline fill="none" stroke="#888888" points="{across[0]:.1f},{bottom - ERRORS} {across[0]:.1f},{bottom} '
        f'{across[-1]:.1f},{bottom}"/>',
        f'<text x="{across[0] - 5:.1f}" y="{bottom}" text-anchor="end" font-size="11">0</text>',
        f'<text x="{across[0] - 5:.1f}" y="{bottom - ERRORS + 14}" text-anchor="end" font-size="11">{most:.0f}</text>',
        f'<text x="{across[-1]:.1f}" y="{bottom - ERRORS + 10}" text-anchor="end" font-size="11">'
        "distance of the markers [mm]</text>",
        f'<text x="{across[-1]:.1f}" y="{bottom + 15}" text-anchor="end" font-size="11">{END - START:g} s</text>',
        f'<polyline fill="none" stroke="black" stroke-width="1.8" points="{curve}"/>',
        f'<line y1="{bottom - ERRORS}" y2="{bottom}" stroke="#888888" x1="{places[-1]}" x2="{places[-1]}">'
        f"{_moving('x1', places)}{_moving('x2', places)}</line>",
    ]
    return "".join(parts)


def _moving(attribute: str, values: list[str]) -> str:
    """Return an SVG animation of an attribute through its values, with a pause at the last one."""
    move = SLOWER * (END - START)
    times = [*(f"{t:.4f}".rstrip("0") for t in np.linspace(0, move / (move + PAUSE), len(values))), "1"]
    return (
        f'<animate attributeName="{attribute}" dur="{move + PAUSE:g}s" repeatCount="indefinite" '
        f'keyTimes="{";".join(times)}" values="{";".join([*values, values[-1]])}"/>'
    )


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("dataset")
    parser.add_argument("--trial", required=True)
    parser.add_argument("-o", "--output", required=True, metavar="FILE.svg")
    chosen = parser.parse_args()
    frames = round((END - START) / EVERY) + 1
    write_text(chosen.output, picture(motions(read_dataset(chosen.dataset), chosen.trial, frames)))


if __name__ == "__main__":
    main()

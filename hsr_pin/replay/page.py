"""The animation as one HTML file that needs nothing else: no server, no network."""

from __future__ import annotations

import base64
import html
import json
import re
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import Any
from uuid import UUID

import umsgpack  # type: ignore[import-untyped]

from hsr_pin.output import PAGE_SIGNATURE, write_text
from hsr_pin.replay.animation import ASPECT, GRID, MEASURED, SIMULATED, draw, trail_colour
from hsr_pin.replay.drawn import Drawn
from hsr_pin.replay.viewer import VIEWER_ROOT, Visualizer

_UUID = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
_HINT = f"Squares of {100 * GRID:g} cm. Drag to turn, scroll to zoom, space to pause."


class _Recorder:
    """Stands in for meshcat's connection to a server: keeps what it is sent."""

    def __init__(self) -> None:
        self.commands: list[bytes] = []
        self._names: dict[str, str] = {}

    def send(self, command: Any) -> None:
        """Keep a command as meshcat would send it."""
        self.commands.append(umsgpack.packb(self._renamed(command.lower()), force_float_precision="single"))

    def _renamed(self, part: Any) -> Any:
        """A part of a command whose objects are numbered: meshcat names them after the machine's network card and the time."""
        if isinstance(part, dict):
            return {key: self._renamed(value) for key, value in part.items()}
        if isinstance(part, list):
            return [self._renamed(value) for value in part]
        if isinstance(part, str) and _UUID.fullmatch(part):
            return self._names.setdefault(part, str(UUID(int=len(self._names) + 1)))
        return part


def write_page(runs: Sequence[Drawn], path: str | Path, title: str = "Hybrid soft robot", text: Sequence[str] = ()) -> None:
    """Write runs as an animation that plays in any browser.

    Args:
        runs: drawn side by side.
        path: the HTML file.
        title: of the page.
        text: what is shown, a line each.

    Raises:
        OutputError: the file cannot be written.
    """
    write_text(path, page(runs, title, text))


def page(runs: Sequence[Drawn], title: str = "Hybrid soft robot", text: Sequence[str] = ()) -> str:
    """The text of that file."""
    recorder = _Recorder()
    clip = draw(Visualizer(window=recorder), runs)
    template = Template(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))
    return template.substitute(
        signature=PAGE_SIGNATURE,
        title=html.escape(title),
        text="".join(f"<p>{html.escape(line)}</p>" for line in (*text, _HINT)),
        legend="".join(
            f'<li><i style="background:#{colour:06x}"></i>{html.escape(words)}</li>' for colour, words in _legend(runs)
        ),
        viewer=(Path(VIEWER_ROOT) / "main.min.js").read_text(encoding="utf-8"),
        commands=json.dumps([base64.b64encode(command).decode("ascii") for command in recorder.commands]),
        start=json.dumps(float(clip.time[0])),
        duration=json.dumps(float(clip.time[-1] - clip.time[0])),
        aspect=json.dumps(ASPECT),
    )


def _legend(runs: Sequence[Drawn]) -> list[tuple[int, str]]:
    if any(run.measured is not None for run in runs):
        return [(SIMULATED, "simulated"), (MEASURED, "measured"), (0x333333, "the gap between them")]
    return [(trail_colour(run, number), run.label) for number, run in enumerate(runs)]

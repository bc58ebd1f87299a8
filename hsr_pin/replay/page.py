"""Animation as one self-contained HTML file that needs neither a server nor a network."""

from __future__ import annotations

import base64
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from uuid import UUID

import umsgpack  # type: ignore[import-untyped]
from jinja2 import Environment, StrictUndefined

from hsr_pin.output import PAGE_SIGNATURE, write_text
from hsr_pin.replay.animation import ASPECT, GRID, MEASURED, SIMULATED, draw, trail_colour
from hsr_pin.replay.drawn import Drawn
from hsr_pin.replay.viewer import VIEWER_ROOT, Visualizer

_UUID = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")
_HINT = f"Squares of {100 * GRID:g} cm. Drag to turn, scroll to zoom, space to pause."


class _Recorder:
    """Substitute for meshcat's connection to a server that records the commands sent to it."""

    def __init__(self) -> None:
        self.commands: list[bytes] = []
        self._names: dict[str, str] = {}

    def send(self, command: Any) -> None:
        """Record a command as meshcat would send it."""
        self.commands.append(umsgpack.packb(self._renamed(command.lower()), force_float_precision="single"))

    def _renamed(self, part: Any) -> Any:
        """Return a part of a command with numbered objects, as meshcat's names contain the time and the network address."""
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
        runs: runs to draw side by side.
        path: the HTML file.
        title: title of the page.
        text: lines of text shown on the page.

    Raises:
        OutputError: the file cannot be written.
    """
    write_text(path, page(runs, title, text))


def page(runs: Sequence[Drawn], title: str = "Hybrid soft robot", text: Sequence[str] = ()) -> str:
    """Return an HTML page with runs as an animation that plays in any browser."""
    recorder = _Recorder()
    clip = draw(Visualizer(window=recorder), runs)
    surroundings = Environment(autoescape=True, undefined=StrictUndefined)  # escapes text from data
    template = surroundings.from_string(Path(__file__).with_name("page.html.jinja").read_text(encoding="utf-8"))
    return template.render(
        signature=PAGE_SIGNATURE,
        title=title,
        lines=(*text, _HINT),
        legend=_legend(runs),
        viewer=(Path(VIEWER_ROOT) / "main.min.js").read_text(encoding="utf-8"),
        commands=[base64.b64encode(command).decode("ascii") for command in recorder.commands],
        start=float(clip.time[0]),
        duration=float(clip.time[-1] - clip.time[0]),
        aspect=ASPECT,
    )


def _legend(runs: Sequence[Drawn]) -> list[tuple[int, str]]:
    if any(run.measured is not None for run in runs):
        return [(SIMULATED, "simulated"), (MEASURED, "measured"), (0x333333, "gap between them")]
    return [(trail_colour(run, number), run.label) for number, run in enumerate(runs)]

"""The animation in a browser, served by meshcat on this machine."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Sequence

from hsr_pin.replay.animation import draw
from hsr_pin.replay.drawn import Drawn
from hsr_pin.replay.viewer import Visualizer


def show(runs: Sequence[Drawn]) -> None:
    """Open the animation in the browser and keep it there until Ctrl-C."""
    with contextlib.redirect_stdout(sys.stderr):  # meshcat prints its address; stdout is for results
        viewer = Visualizer()
        draw(viewer, runs)
        viewer.open()
    if any(run.measured is not None for run in runs):
        print("Blue is simulated, orange measured; rods are the gap between them.", file=sys.stderr)
    print("The animation's time slider is under Open Controls, Animations. Ctrl-C ends.", file=sys.stderr)
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            time.sleep(0.5)

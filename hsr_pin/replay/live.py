"""Animation in the browser, served by this process to this machine only."""

from __future__ import annotations

import contextlib
import sys
import webbrowser
from collections.abc import Sequence
from threading import Thread

from hsr_pin.loopback import PageServer
from hsr_pin.replay.drawn import Drawn
from hsr_pin.replay.page import page


def show(runs: Sequence[Drawn]) -> None:
    """Open the animation in the browser and keep it there until Ctrl-C."""
    text = page(runs, runs[0].label) if len(runs) == 1 else page(runs)
    with PageServer(text.encode("utf-8")) as server, contextlib.suppress(KeyboardInterrupt):
        print(f"The animation is at {server.address}, for this machine only. Ctrl-C ends.", file=sys.stderr)  # not stdout
        Thread(target=webbrowser.open, args=(server.address, 2), daemon=True).start()  # returns late in some browsers
        server.serve_forever()

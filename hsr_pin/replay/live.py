"""The animation in the browser: the page, served by this process to this machine alone, for as long as the process runs."""

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
        print(f"The animation is at {server.address}, for this machine alone. Ctrl-C ends.", file=sys.stderr)  # stdout: results
        Thread(target=webbrowser.open, args=(server.address, 2), daemon=True).start()  # some come back only when they are closed
        server.serve_forever()

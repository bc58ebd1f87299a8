"""The animation in the browser: the page, served by this process to this machine alone, for as long as the process runs."""

from __future__ import annotations

import contextlib
import secrets
import sys
import webbrowser
from collections.abc import Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

from hsr_pin.replay.drawn import Drawn
from hsr_pin.replay.page import page

#: Where other machines cannot reach.
HOST = "127.0.0.1"


class Server(ThreadingHTTPServer):
    """Gives one page to whoever knows its address, which cannot be guessed; a port is found."""

    daemon_threads = True

    def __init__(self, text: str) -> None:
        super().__init__((HOST, 0), _Handler)
        self.content = text.encode("utf-8")
        self.path = f"/{secrets.token_urlsafe(12)}/"

    @property
    def address(self) -> str:
        """What the browser is to open."""
        return f"http://{HOST}:{self.server_port}{self.path}"


class _Handler(BaseHTTPRequestHandler):
    server: Server

    def do_GET(self) -> None:
        if self.path != self.server.path:
            self.send_error(404)
            return
        self.send_response(200)
        self.send_header("Content-Type", "text/html; charset=utf-8")
        self.send_header("Content-Length", str(len(self.server.content)))
        self.end_headers()
        with contextlib.suppress(ConnectionError):  # the browser has gone away
            self.wfile.write(self.server.content)

    def log_message(self, format: str, *args: object) -> None:
        """Nobody asked for a log."""


def show(runs: Sequence[Drawn]) -> None:
    """Open the animation in the browser and keep it there until Ctrl-C."""
    text = page(runs, runs[0].label) if len(runs) == 1 else page(runs)
    with Server(text) as server, contextlib.suppress(KeyboardInterrupt):
        print(f"The animation is at {server.address}, for this machine alone. Ctrl-C ends.", file=sys.stderr)  # stdout: results
        Thread(target=webbrowser.open, args=(server.address, 2), daemon=True).start()  # some come back only when they are closed
        server.serve_forever()

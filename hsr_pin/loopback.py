"""Pages for a browser on this machine: which requests are answered, and a server of one page."""

from __future__ import annotations

import contextlib
import secrets
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

#: Where other machines cannot reach.
HOST = "127.0.0.1"


def is_own(headers: Any, port: int, *, needs_origin: bool = False) -> bool:
    """Whether a request comes from a page of this server, or from its address in the browser, and not from another site's page.

    A browser names the site of the page as ``Origin``, and the machine that the page believes to speak to as ``Host``: that is
    another one where a site's name was turned to this machine (DNS rebinding).

    Args:
        headers: of the request, with ``get_all``.
        port: on which it came in.
        needs_origin: whether a request without an ``Origin`` is refused too.
    """
    hosts = [f"{name}:{port}".removesuffix(":80") for name in (HOST, "localhost")]  # browsers leave out the usual port
    origins = headers.get_all("Origin") or []
    return (
        headers.get_all("Host") in ([host] for host in hosts)
        and all(origin in [f"http://{host}" for host in hosts] for origin in origins)
        and bool(origins or not needs_origin)
    )


class PageServer(ThreadingHTTPServer):
    """Gives one page to whoever knows its address, which cannot be guessed; a port is found.

    Args:
        content: of the page.
    """

    daemon_threads = True

    def __init__(self, content: bytes) -> None:
        super().__init__((HOST, 0), _Handler)
        self.content, self.path = content, f"/{secrets.token_urlsafe(12)}/"

    @property
    def address(self) -> str:
        """What the browser is to open."""
        return f"http://{HOST}:{self.server_port}{self.path}"

    def start(self) -> None:
        """Serve in a thread of its own, until ``shutdown``."""
        Thread(target=self.serve_forever, daemon=True).start()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A request that could not be answered is nobody's concern but its sender's."""


class _Handler(BaseHTTPRequestHandler):
    server: PageServer

    def do_GET(self) -> None:
        if not is_own(self.headers, self.server.server_port):
            self.send_error(403)
            return
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

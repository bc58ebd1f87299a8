"""Local web pages for a browser on this machine: a check of requests, and a server of one page."""

from __future__ import annotations

import contextlib
import secrets
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread
from typing import Any

#: Address that other machines cannot reach.
HOST = "127.0.0.1"


def is_own(headers: Any, port: int, *, needs_origin: bool = False) -> bool:
    """Return whether a request comes from a page of this server, or from the browser's address bar, not from another site's page.

    A browser sends the site of the page as ``Origin``, and the host that the page intends to contact as ``Host``, which differs
    if a site's name was redirected to this machine (DNS rebinding).

    Args:
        headers: headers of the request, with ``get_all``.
        port: port on which it arrived.
        needs_origin: whether a request without an ``Origin`` is rejected too.
    """
    hosts = [f"{name}:{port}".removesuffix(":80") for name in (HOST, "localhost")]  # browsers omit the default port
    origins = headers.get_all("Origin") or []
    return (
        headers.get_all("Host") in ([host] for host in hosts)
        and all(origin in [f"http://{host}" for host in hosts] for origin in origins)
        and bool(origins or not needs_origin)
    )


class PageServer(ThreadingHTTPServer):
    """Server of one page, at an address that cannot be guessed, on a free port.

    Args:
        content: content of the page.
    """

    daemon_threads = True

    def __init__(self, content: bytes) -> None:
        super().__init__((HOST, 0), _Handler)
        self.content, self.path = content, f"/{secrets.token_urlsafe(12)}/"

    @property
    def address(self) -> str:
        """URL of the page."""
        return f"http://{HOST}:{self.server_port}{self.path}"

    def start(self) -> None:
        """Serve the page in a separate thread, until ``shutdown``."""
        Thread(target=self.serve_forever, daemon=True).start()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore errors of single requests, which concern their sender only."""


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
        with contextlib.suppress(ConnectionError):  # the browser has closed the connection
            self.wfile.write(self.server.content)

    def log_message(self, format: str, *args: object) -> None:
        """Write no log."""

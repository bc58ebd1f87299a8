"""The report of a diagnosis, served to the page beside it, from this machine to this machine."""

from __future__ import annotations

import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

#: Where nobody but this machine can come from.
LOOPBACK = "127.0.0.1"


class ReportServer:
    """One page and nothing else, on a port of its own, until :meth:`stop`.

    Args:
        content: of the page.
    """

    def __init__(self, content: bytes) -> None:
        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                known = self.path == "/report.html"
                self.send_response(200 if known else 404)
                self.send_header("Content-Type", "text/html; charset=utf-8")
                self.send_header("Content-Length", str(len(content) if known else 0))
                self.end_headers()
                self.wfile.write(content if known else b"")

            def log_message(self, format: str, *arguments: object) -> None:
                """Nothing: what is printed is for people."""

        self._server = ThreadingHTTPServer((LOOPBACK, 0), Handler)
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    @property
    def address(self) -> str:
        """Where the report is."""
        return f"http://{LOOPBACK}:{self._server.server_address[1]}/report.html"

    def stop(self) -> None:
        """End it."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

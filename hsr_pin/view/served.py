"""Server of viser that refuses requests of other sites; by default viser accepts any Origin and Host header."""

from __future__ import annotations

import contextlib
import io
import logging
from http import HTTPStatus
from typing import Any

from hsr_pin.loopback import HOST, is_own

#: Logger of websockets, which would print tracebacks for invalid requests.
_SILENT = logging.getLogger(__name__)
_SILENT.disabled = True


def viser_server(port: int, label: str) -> Any:
    """Return a server of viser that answers only requests of its own page.

    Args:
        port: port on this machine; 0: any free port.
        label: title of the panel.
    """
    import viser
    from websockets.asyncio import server as websockets

    serve = websockets.serve

    def guarded(*arguments: Any, process_request: Any, **settings: Any) -> Any:
        def checked(connection: Any, request: Any) -> Any:
            opens_socket = request.headers.get_all("Upgrade") != []
            if is_own(request.headers, connection.local_address[1], needs_origin=opens_socket):
                return process_request(connection, request)
            return connection.respond(HTTPStatus.FORBIDDEN, "This page is available to browsers on its own machine only.\n")

        return serve(*arguments, process_request=checked, logger=_SILENT, **settings)

    websockets.serve = guarded  # type: ignore[assignment,misc,unused-ignore]
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # viser prints its address, but stdout is reserved for results
            return viser.ViserServer(host=HOST, port=port, label=label, verbose=False)
    finally:
        websockets.serve = serve  # type: ignore[misc,unused-ignore]

"""The live page answers its own page alone: other sites' pages can neither read nor drive it."""

import socket
import time

import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from ..replay.conftest import chromium, open_tab
from ..test_loopback import REQUESTS, asked

pytest.importorskip("viser", reason="needs viser (group view)")


@pytest.fixture(scope="module")
def page(session):
    from hsr_pin.view.page import Page

    shown = Page(session)
    yield shown
    shown.stop()


@pytest.fixture(scope="module")
def port(page):
    return int(page.address.rpartition(":")[2])


@pytest.mark.parametrize(("headers", "status"), REQUESTS, ids=lambda part: str(part))
def test_only_requests_of_its_own_page_are_answered(port, headers, status):
    found, body = asked(port, "/", headers)
    assert (found, b"<html" in body) == (status, status == 200)


@pytest.mark.parametrize("origin", ["http://127.0.0.1:PORT", "http://localhost:PORT"])
def test_its_own_page_may_open_a_websocket(port, origin):
    with connect(f"ws://127.0.0.1:{port}", origin=origin.replace("PORT", str(port)), proxy=None):
        pass


@pytest.mark.parametrize("origin", [None, "null", "http://attacker.example", "https://127.0.0.1:PORT", "http://127.0.0.1:1"])
def test_no_other_page_may_open_a_websocket(port, origin):
    told = origin and origin.replace("PORT", str(port))
    with pytest.raises(InvalidStatus, match="403"), connect(f"ws://127.0.0.1:{port}", origin=told, proxy=None):
        pass


def test_a_page_under_another_name_may_not_open_a_websocket(port):
    with socket.create_connection(("127.0.0.1", port)) as way, pytest.raises(InvalidStatus, match="403"):
        connect(f"ws://attacker.example:{port}", origin=f"http://attacker.example:{port}", sock=way, proxy=None)


def test_another_sites_page_in_a_browser_cannot_drive_it(port, tmp_path):
    if chromium() is None:
        pytest.skip("needs Chromium, which is not installed here (Debian: apt-get install chromium)")
    page = tmp_path / "attack.html"
    page.write_text(
        f'<script>const way = new WebSocket("ws://127.0.0.1:{port}"); way.onopen = () => document.title = "open";'
        'way.onerror = () => document.title = "refused";</script>'
    )
    with open_tab() as tab:
        tab.open(page.as_uri())
        tab.wait_for("document.title")
        assert tab.evaluate("document.title") == "refused"


def test_what_is_refused_or_broken_off_prints_nothing(port, capfd):
    for request in (b"GET / HTTP/1.1\r\nHost: attacker.example\r\n\r\n", b"\0" * 100, b"POST / HTTP/1.1\r\n\r\n", b""):
        with socket.create_connection(("127.0.0.1", port)) as client:
            client.sendall(request)
    with connect(f"ws://127.0.0.1:{port}", origin=f"http://127.0.0.1:{port}", subprotocols=[version()], proxy=None) as way:
        way.send(b"no message of viser's")
        time.sleep(0.5)
    assert asked(port, "/", {"Host": "127.0.0.1:PORT"})[0] == 200
    assert capfd.readouterr() == ("", "")


def version():
    import viser

    return f"viser-v{viser.__version__}"

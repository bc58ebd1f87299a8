"""Pages of this machine answer its own browser alone: no other site's page, under whatever name it speaks to them."""

import http.client
import socket
import threading

import pytest

from hsr_pin.loopback import PageServer

#: What a request names, and what becomes of it; PORT stands for the server's.
REQUESTS = [
    ({"Host": "127.0.0.1:PORT"}, 200),
    ({"Host": "localhost:PORT"}, 200),
    ({"Host": "127.0.0.1:PORT", "Origin": "http://127.0.0.1:PORT"}, 200),
    ({"Host": "attacker.example:PORT"}, 403),
    ({"Host": "127.0.0.1"}, 403),
    ({"Host": "127.0.0.1.attacker.example:PORT"}, 403),
    ({"Host": ""}, 403),
    ({"Host": "127.0.0.1:PORT", "Origin": "http://attacker.example"}, 403),
    ({"Host": "127.0.0.1:PORT", "Origin": "null"}, 403),
    ({"Host": "127.0.0.1:PORT", "Origin": "http://127.0.0.1:1"}, 403),
    ({"Host": "127.0.0.1:PORT", "Origin": "https://127.0.0.1:PORT"}, 403),
]


def asked(port, path, headers):
    """The status of an answer to a request with these headers and no others."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.putrequest("GET", path, skip_host=True, skip_accept_encoding=True)
    for name, value in headers.items():
        connection.putheader(name, value.replace("PORT", str(port)))
    connection.endheaders()
    answer = connection.getresponse()
    body = answer.read()
    connection.close()
    return answer.status, body


@pytest.fixture(scope="module")
def server():
    with PageServer(b"<html>found</html>") as running:
        running.start()
        yield running
        running.shutdown()


@pytest.mark.parametrize(("headers", "status"), REQUESTS, ids=lambda part: str(part))
def test_only_requests_of_its_own_page_are_answered(server, headers, status):
    found, body = asked(server.server_port, server.path, headers)
    assert (found, body == b"<html>found</html>") == (status, status == 200)


def test_a_request_that_names_two_hosts_is_refused(server):
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=10) as client:
        hosts = f"Host: 127.0.0.1:{server.server_port}\r\nHost: attacker.example\r\n"
        client.sendall(f"GET {server.path} HTTP/1.0\r\n{hosts}\r\n".encode())
        assert b" 403 " in client.recv(100)


def test_who_does_not_know_the_address_gets_nothing(server):
    assert asked(server.server_port, "/report.html", {"Host": "127.0.0.1:PORT"})[0] == 404


def test_a_request_that_is_broken_off_prints_nothing(server, capfd):
    threads = threading.active_count()
    with socket.create_connection(("127.0.0.1", server.server_port)) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")  # ends with a reset
        client.sendall(b"GET / HTTP/1.1\r\n")
    while threading.active_count() > threads:
        pass
    assert asked(server.server_port, server.path, {"Host": "127.0.0.1:PORT"})[0] == 200
    assert capfd.readouterr() == ("", "")

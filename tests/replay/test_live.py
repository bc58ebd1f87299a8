"""The live viewer shows what the page shows, to this machine alone, and is gone when its process is."""

import re
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest

from hsr_pin.loopback import PageServer
from hsr_pin.replay import live
from hsr_pin.replay.page import page

PROGRAM = """
import webbrowser
webbrowser.open = lambda *_: True
from hsr_pin.replay.drawn import Drawn
from hsr_pin.replay.live import show
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
show([Drawn("a run", ArmSpecification(), simulate(step_scenario(ArmSpecification(), 0.5, duration=0.3)).trajectory)])
"""


@pytest.fixture
def server(run_of):
    """A server at work."""
    with PageServer(page([run_of(measured=(0.01, 0.0, 0.0))]).encode()) as running:
        running.start()
        yield running
        running.shutdown()


def test_it_opens_the_browser_once_ends_with_ctrl_c_and_keeps_stdout_for_results(run_of, monkeypatch, capsys):
    opened = []
    monkeypatch.setattr(live.webbrowser, "open", lambda address, _: opened.append(address))

    def interrupt(self):
        while not opened:
            time.sleep(0.01)
        raise KeyboardInterrupt

    monkeypatch.setattr(PageServer, "serve_forever", interrupt)
    live.show([run_of(measured=(0.01, 0.0, 0.0))])
    out, err = capsys.readouterr()
    assert out == ""
    assert len(opened) == 1 and opened[0] in err


def test_a_browser_sees_the_arm_moving(server, tab):
    tab.open(server.address)
    tab.wait_for("viewer.animator.duration > 0.9")
    still, later = tab.at(0.0), tab.at(0.3)
    assert (abs(still - later).max(axis=-1) > 40).sum() > 5000
    assert [address for address in tab.requests if not address.startswith(("data:", server.address))] == []


def test_it_listens_to_this_machine_alone(server):
    assert server.socket.getsockname()[0] == "127.0.0.1"
    for _, _, _, _, (host, *_) in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET):
        if not host.startswith("127."):
            with pytest.raises(OSError):
                socket.create_connection((host, server.server_port), timeout=2).close()


@pytest.mark.parametrize("path", ["/", "/static/", "/favicon.ico"])
def test_who_does_not_know_the_address_gets_nothing(server, path):
    with pytest.raises(urllib.error.HTTPError, match="404"):
        urllib.request.urlopen(f"http://127.0.0.1:{server.server_port}{path}")


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGKILL])
def test_nothing_of_it_stays_when_its_process_is_ended(ending):
    process = subprocess.Popen([sys.executable, "-c", PROGRAM], stderr=subprocess.PIPE, text=True, start_new_session=True)
    address = re.search(r"http://127\.0\.0\.1:(\d+)\S*/", process.stderr.readline())
    assert b"MeshCat" in urllib.request.urlopen(address[0]).read()
    process.send_signal(ending)
    process.wait(10)
    process.stderr.close()
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", int(address[1])), timeout=2)

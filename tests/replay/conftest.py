"""Runs to draw, and a headless Chromium, driven by its DevTools protocol, to look at them with."""

import base64
import contextlib
import io
import json
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hsr_pin.replay.drawn import Drawn
from hsr_pin.robot.specification import ArmSpecification
from hsr_pin.simulation.scenario import step_scenario
from hsr_pin.simulation.simulate import simulate
from hsr_pin.trajectory import Trajectory

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--remote-debugging-port=0",
)
PATIENCE = 120.0

#: Where the browser says how slowly software draws.
SLOW_DRAWING = "GL Driver Message"


@pytest.fixture(scope="session")
def run_of():
    """``run_of(arm, torque, measured=shift)``: a simulated step; beside measured markers that are ``shift`` (3,) [m] away.

    The tip is out of sight from 0.5 to 0.6 s.
    """
    return _run_of


def _run_of(arm=None, torque=0.6, measured=None, label="a run", duration=1.0):
    arm = ArmSpecification() if arm is None else arm
    simulated = simulate(step_scenario(arm, torque, duration=duration)).trajectory
    if measured is None:
        return Drawn(label, arm, simulated)
    positions = simulated.positions + np.asarray(measured)
    positions[(simulated.time >= 0.5) & (simulated.time <= 0.6), -1] = np.nan
    return Drawn(label, arm, simulated, Trajectory(simulated.time, simulated.markers, positions))


@pytest.fixture(scope="module")
def tab():
    """A tab of a browser."""
    if chromium() is None:
        pytest.skip("needs Chromium, which is not installed here (Debian: apt-get install chromium)")
    with open_tab() as opened:
        yield opened


def chromium():
    """Path of a Chromium; None where there is none."""
    return next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


class Tab:
    """One page in a browser.

    Attributes:
        complaints: what the page or the browser put on the console as warnings or errors, and exceptions nobody caught.
        requests: addresses that were asked for.
    """

    def __init__(self, socket, session, size):
        self._socket, self._session, self._number = socket, session, 0
        self.complaints, self.requests = [], []
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        width, height = size
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)

    def call(self, method, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters, "sessionId": self._session}
        self._socket.send(json.dumps(message))
        deadline = time.monotonic() + PATIENCE
        while True:
            answer = json.loads(self._socket.recv(timeout=max(0.01, deadline - time.monotonic())))
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self._note(answer)

    def _note(self, event):
        facts = event.get("params", {})
        said = ""
        if event["method"] == "Runtime.exceptionThrown":
            said = facts["exceptionDetails"]["exception"].get("description", "exception")
        elif event["method"] == "Runtime.consoleAPICalled" and facts["type"] in ("error", "warning", "assert"):
            said = " ".join(str(part.get("value", part.get("description"))) for part in facts["args"])
        elif event["method"] == "Log.entryAdded" and facts["entry"]["level"] in ("error", "warning"):
            said = facts["entry"]["text"]
        if said and SLOW_DRAWING not in said:
            self.complaints.append(said)
        if event["method"] == "Network.requestWillBeSent":
            self.requests.append(facts["request"]["url"])

    def open(self, address):
        self.complaints.clear()
        self.requests.clear()
        self.call("Page.navigate", url=address)
        self.wait_for("document.readyState === 'complete'")

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"]["exception"].get("description"))
        return result["result"].get("value")

    def wait_for(self, condition):
        deadline = time.monotonic() + PATIENCE
        while not self.evaluate(condition):
            if time.monotonic() > deadline:
                raise TimeoutError(condition)
            time.sleep(0.05)

    def at(self, time):
        """(height, width, 3) the picture of the animation at a time [s], standing still."""
        self.evaluate(
            f"viewer.animator.pause(); viewer.animator.seek({time}); viewer.animator.display_progress({time});"
            "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 50))))"
        )
        return self.picture()

    def picture(self, file=None):
        """(height, width, 3) of what the tab shows, from 0 to 255; also into a file."""
        png = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        if file is not None:
            Path(file).write_bytes(png)
        return np.asarray(Image.open(io.BytesIO(png)).convert("RGB")).astype(int)


@contextlib.contextmanager
def open_tab(size=(1200, 800)):
    """A tab of a browser of its own, which ends with the context."""
    from websockets.sync.client import connect

    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        command = [chromium(), *FLAGS, f"--user-data-dir={folder}", "about:blank"]
        browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            port, path = _address(Path(folder) / "DevToolsActivePort", browser)
            with connect(f"ws://127.0.0.1:{port}{path}", proxy=None, max_size=None) as socket:
                socket.send(json.dumps({"id": 0, "method": "Target.createTarget", "params": {"url": "about:blank"}}))
                target = _answer(socket)["targetId"]
                attach = {"targetId": target, "flatten": True}
                socket.send(json.dumps({"id": 0, "method": "Target.attachToTarget", "params": attach}))
                yield Tab(socket, _answer(socket)["sessionId"], size)
        finally:
            browser.terminate()
            browser.wait(timeout=PATIENCE)


def _address(file, browser):
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline:
        if browser.poll() is not None:
            raise RuntimeError(f"the browser ended with exit code {browser.returncode}")
        lines = file.read_text().split() if file.exists() else []
        if len(lines) == 2:
            return lines
        time.sleep(0.05)
    raise TimeoutError("the browser did not open its debugging port")


def _answer(socket):
    while True:
        answer = json.loads(socket.recv(timeout=PATIENCE))
        if answer.get("id") == 0:
            return answer["result"]

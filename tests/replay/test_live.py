"""The live viewer shows what the page shows, and its address does not get into results."""

import pytest

from hsr_pin.replay import live
from hsr_pin.replay.animation import draw
from hsr_pin.replay.viewer import Visualizer


@pytest.fixture
def opened(monkeypatch):
    """Viewers that were opened; each is looked at, closed with Ctrl-C and shut down."""
    viewers = []

    def remember(viewer):
        viewers.append(viewer)
        return viewer

    def interrupt(_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Visualizer, "open", remember)
    monkeypatch.setattr(live.time, "sleep", interrupt)
    yield viewers
    for viewer in viewers:
        shut_down(viewer)


def shut_down(viewer):
    viewer.window.zmq_socket.close()
    process = viewer.window.server_proc
    process.kill()
    process.communicate()


def test_it_opens_once_ends_with_ctrl_c_and_keeps_stdout_for_results(run_of, opened, capsys):
    live.show([run_of(measured=(0.01, 0.0, 0.0))])
    out, err = capsys.readouterr()
    assert len(opened) == 1
    assert out == ""
    assert opened[0].url() in err
    assert "orange measured" in err


def test_a_browser_sees_the_arm_moving(run_of, tab):
    viewer = Visualizer()
    try:
        draw(viewer, [run_of()])
        tab.open(viewer.url())
        tab.wait_for("viewer.animator.duration > 0.9")
        still, later = tab.at(0.0), tab.at(0.3)
        assert (abs(still - later).max(axis=-1) > 40).sum() > 5000
    finally:
        shut_down(viewer)

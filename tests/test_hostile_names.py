"""Names that are HTML, Markdown or a path are shown as they stand on every page, in a real browser, and nothing in them runs."""

import json
from dataclasses import replace

import pytest

from hsr_pin.cli.command import run
from hsr_pin.recordings.write import write_dataset
from hsr_pin.replay.page import write_page
from hsr_pin.trajectory import Dataset, Marker, Trial

from .replay.conftest import _run_of, chromium, open_tab

#: Each would mark the page if it ran: as HTML, out of an attribute, out of a script, as Markdown.
RUN = "parent.document.title=`run`"
NAMES = (
    f"<iframe srcdoc='<script>{RUN}<&#47;script>'>",
    f'"><img src=x onerror="{RUN}">',
    f"<&#47;script><svg onload={RUN}>",
    f"[a](javascript:{RUN}) **b** `c` &lt;i&gt;",
)


@pytest.fixture(scope="module")
def tab():
    if chromium() is None:
        pytest.skip("needs Chromium, which is not installed here (Debian: apt-get install chromium)")
    with open_tab((1400, 900)) as opened:
        yield opened


@pytest.fixture(scope="module")
def hostile(heavy_tip):
    """Recordings of which dataset, trials and markers have such names."""
    trials = [
        Trial(name, renamed(trial.trajectory), trial.keq, trial.damping)
        for trial, name in zip(heavy_tip.trials, NAMES, strict=True)
    ]
    return Dataset(NAMES[0], 0.24, 0.15, 0.04, "hanging", tuple(trials), description=NAMES[1])


def renamed(motion):
    """The motion of markers with such names."""
    names = zip(motion.markers, NAMES, strict=False)
    return replace(motion, markers=tuple(Marker(f"{marker.name} {name}", marker.arc_length) for marker, name in names))


#: Wherever something of a name would show if it were not text.
STRANGE = "document.querySelectorAll('iframe, img:not([src^=data]), svg[onload], a[href^=javascript]').length"


def judge(tab, *names):
    """That the names stand on the page as text, and that nothing of them ran or became part of it."""
    text = tab.evaluate("document.body.textContent")
    assert [name for name in names if name not in text] == []
    assert tab.evaluate(STRANGE) == 0
    assert "run" not in tab.evaluate("document.title").split()


def test_in_the_live_view(tab, hostile):
    pytest.importorskip("viser", reason="needs viser (group view)")
    from hsr_pin.view.page import Page
    from hsr_pin.view.session import Session

    page = Page(Session.of(hostile, 4, "mid"))
    try:
        for name in NAMES:
            with page._lock:
                page.trial = name
            page._wanted.set()
            tab.open(page.address)
            tab.wait_for(
                "[...document.querySelectorAll('strong')].some(one => one.textContent.startsWith(" + json.dumps(name) + "))"
            )
            judge(tab, *NAMES)
    finally:
        page.stop()


def test_in_the_replay(tab, tmp_path):
    drawn = _run_of(measured=(0.01, 0.0, 0.0))
    drawn = replace(drawn, simulated=renamed(drawn.simulated), measured=renamed(drawn.measured))
    for title in NAMES:
        write_page([drawn], tmp_path / "run.html", title, NAMES)
        tab.open((tmp_path / "run.html").as_uri())
        tab.wait_for("viewer.animator.time > 0.05")
        judge(tab, title, *NAMES)
        assert tab.evaluate("document.title") == title
    write_page([replace(drawn, label=name, measured=None) for name in NAMES], tmp_path / "runs.html")
    tab.open((tmp_path / "runs.html").as_uri())
    judge(tab, *NAMES)


def test_in_the_report(tab, hostile, tmp_path, capsys):
    from hsr_pin.cli.diagnose import command

    write_dataset(hostile, tmp_path / "data")
    few = ["--links", "2", "--jobs", "1", "--effects", "tip_mass", "--max-effects", "1"]
    assert run(command, [str(tmp_path / "data"), *few, "--html", str(tmp_path / "report.html")]) == 0, capsys.readouterr().err
    tab.open((tmp_path / "report.html").as_uri())
    judge(tab, NAMES[0])
    (tmp_path / "bad.html").write_text(f"<title>x</title>{NAMES[1]}{NAMES[3]}")
    tab.open((tmp_path / "bad.html").as_uri())
    with pytest.raises(AssertionError):  # what is not escaped would be seen
        judge(tab, NAMES[1])

"""The documentation builds without a warning, leads nowhere that is not there, and looks right on a desk and on a telephone."""

import json
import os
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from hsr_pin.effects import EFFECTS

from ..replay.conftest import chromium, open_tab

pytest.importorskip("sphinx", reason="needs the group docs")
pytest.importorskip("furo", reason="needs the group docs")
pytest.importorskip("myst_nb", reason="needs the group docs")

ROOT = Path(__file__).resolve().parents[2]
SIZES = {"desktop": (1280, 900), "telephone": (390, 844)}
TUTORIALS = sorted(path.stem for path in (ROOT / "docs" / "tutorials").glob("*.md") if path.stem != "index")


class Page(HTMLParser):
    """What a page leads to, and what may be led to in it."""

    def __init__(self, path):
        super().__init__()
        self.targets, self.anchors = [], set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        facts = dict(attrs)
        self.anchors |= {facts[key] for key in ("id", "name") if facts.get(key)}
        self.targets += [facts[key] for key in ("href", "src") if facts.get(key)]


@pytest.fixture(scope="module", params=["text", pytest.param("with tutorials run", marks=pytest.mark.long)])
def site(request, tmp_path_factory):
    """The folder of the site, built once, with every warning an error; and once more, with its tutorials run."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-j", "2", "-d", str(folder / "trees")]
    if request.param == "text":  # a cell that is not run is taken for Python
        command += ["-D", "nb_execution_mode=off", "-D", "suppress_warnings=ref.python,misc.highlighting_failure"]
    done = subprocess.run([*command, ROOT / "docs", folder / "pages"], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / "pages"


@pytest.fixture(scope="module")
def pages(site):
    return {path.relative_to(site).as_posix(): Page(path) for path in sorted(site.rglob("*.html"))}


@pytest.fixture(scope="module", params=SIZES)
def tab(request):
    if chromium() is None:
        pytest.skip("needs Chromium, which is not installed here (Debian: apt-get install chromium)")
    with open_tab(SIZES[request.param]) as opened:
        yield opened


def dead_links(site, pages):
    for name, page in pages.items():
        for target in page.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            place = os.path.normpath(os.path.join(os.path.dirname(name), unquote(parts.path))) if parts.path else name
            if not (site / place).is_file():
                yield f"{name}: {target}"
            elif parts.fragment and place in pages and unquote(parts.fragment) not in pages[place].anchors:
                yield f"{name}: nothing is called {target}"


def test_no_link_is_dead(site, pages):
    assert len(pages) > 30
    assert list(dead_links(site, pages)) == []


def test_a_dead_link_is_found(tmp_path):
    (tmp_path / "a.html").write_text('<p id="here"><a href="#here"></a><a href="#gone"></a><img src="none.png"></p>')
    assert len(list(dead_links(tmp_path, {"a.html": Page(tmp_path / "a.html")}))) == 2


def test_pages_are_silent_whole_and_no_wider_than_the_screen(site, pages, tab):
    wrong = {}
    for name in pages:
        tab.open((site / name).as_uri())
        lacking = tab.evaluate(
            "[...document.images].filter(image => !(image.complete && image.naturalWidth)).map(image => image.src)"
        )
        wide = tab.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
        elsewhere = [url for url in tab.requests if not url.startswith(("file:", "data:"))]
        if lacking or wide > 0 or tab.complaints or elsewhere:
            wrong[name] = lacking, wide, list(tab.complaints), elsewhere
    assert wrong == {}


def test_every_room_is_in_the_api(pages):
    rooms = {".".join(door.parent.relative_to(ROOT).parts) for door in (ROOT / "hsr_pin").rglob("__init__.py")}
    told_elsewhere = {
        room for room in rooms if room.startswith(("hsr_pin.cli", "hsr_pin.blind.real", "hsr_pin.blind.plants.laws"))
    }
    assert {f"api/generated/{room}.html" for room in rooms - told_elsewhere} <= pages.keys()


def test_a_slider_of_the_catalogue_moves_the_tip(site, tab):
    tab.open((site / "effects.html").as_uri())
    shown = "JSON.stringify([...document.querySelectorAll('div.effect')].map(one => [...one.querySelectorAll('.moved')].map("
    shown += "line => line.getAttribute('points')).concat(one.querySelector('output').textContent)))"
    before = json.loads(tab.evaluate(shown))
    tab.evaluate(
        "document.querySelectorAll('div.effect input').forEach(slider => { slider.value = Number(slider.max) - 3;"
        "slider.dispatchEvent(new Event('input')); })"
    )
    after = json.loads(tab.evaluate(shown))
    assert len(before) == len(EFFECTS)
    for old, new in zip(before, after, strict=True):
        assert old[1] != new[1] and old[2] != new[2]


@pytest.mark.parametrize("name", TUTORIALS)
def test_a_tutorial_is_a_notebook_with_its_outputs(request, site, pages, name):
    import nbformat

    (link,) = {target for target in pages[f"tutorials/{name}.html"].targets if target.endswith(f"/{name}.ipynb")}
    notebook = nbformat.read(site / "tutorials" / link, as_version=4)
    nbformat.validate(notebook)
    assert not any("{nb-" in cell.source for cell in notebook.cells)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    if "run" not in request.node.name:
        return  # not in the quick build
    assert all(cell.execution_count for cell in cells)
    shown = [output.get("data", {}) for cell in cells for output in cell.outputs]
    assert shown and not any("<Figure" in data.get("text/plain", "") and "image/svg+xml" not in data for data in shown)


def test_the_search_finds_an_effect(site, tab):
    tab.open((site / "search.html").as_uri() + "?q=dry_friction")
    tab.wait_for("document.querySelectorAll('#search-results li a').length > 0")

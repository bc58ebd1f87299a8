"""The report is one self-contained page that starts with the verdict and is readable on screen and on paper."""

import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from hsr_pin.diagnosis.report import _model, _notes, report, shown_runs, write_report
from hsr_pin.inference.ladder import Rung
from hsr_pin.inference.verdict import HEADLINES, STATUSES

from .fabricated import SLOW

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
VOID = {"meta", "link", "br", "hr", "img", "input"}

#: Put at the end of a page, these leave what a browser makes of it in the page's first tag.
MEASURE = """<script>
const root = document.documentElement, out = [];
for (const svg of document.querySelectorAll("svg")) {
  const frame = svg.getBoundingClientRect();
  for (const text of svg.querySelectorAll("text")) {
    const box = text.getBoundingClientRect();
    if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
      out.push(text.textContent);
  }
}
root.dataset.width = root.scrollWidth;
root.dataset.cut = out.join("|");
root.dataset.sentence = getComputedStyle(document.querySelector(".sentence")).fontSize;
root.dataset.ink = getComputedStyle(document.querySelector("svg text")).fill;
</script></body>"""


class Page(HTMLParser):
    """The tags, the text without styles, and the nesting errors of a page, as a browser reads them."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.words, self.open = [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, text):
        if self.open and self.open[-1] != "style":
            self.words.append(text)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


@pytest.fixture(scope="module")
def html(diagnosis):
    return report(diagnosis)


@pytest.fixture(scope="module")
def page(html):
    return Page(html)


def test_the_verdict_comes_first_and_then_all_that_supports_it(page, diagnosis):
    order = [
        "Missing physics identified",
        "Tip mass is missing",
        "Next steps",
        "Error of each model",
        "Candidate causes",
        "Where the gap",
        "Simulation against",
    ]
    places = [page.text.index(words) for words in (*order, "Recordings used", "Criteria")]
    assert places == sorted(places)
    pictures = [attributes["aria-label"] for tag, attributes in page.tags if tag == "svg"]
    assert pictures[:3] == ["Error of each model in the ladder", "Error of each candidate", "Maps of the gap"]
    indicators = [each.sentence for each in diagnosis.indicators.items if each.sentence in pictures]
    assert pictures[3 : 3 + len(indicators)] == indicators != []
    assert all("marker tip" in words for words in pictures[3 + len(indicators) :]) and len(pictures) > 3 + len(indicators)


def test_it_shows_numbers_with_intervals_limits_and_what_to_simulate(page, diagnosis):
    assert re.search(r"tip mass: mass additional mass at the tip 0\.0\d+ 0\.0\d+ to 0\.0\d+ kg", page.text)
    assert "--effect tip_mass:mass=0.0" in page.text
    assert f"less than {1e3 * diagnosis.limits.closed:#.3g} mm beyond noise is not reported" in page.text
    assert re.search(r"tip mass [01]\.\d\d", page.text)  # its probability
    assert "No data were left out." in page.text


def test_what_does_not_repeat_is_not_shown_as_what_the_best_model_leaves(diagnosis):
    best, noise = diagnosis.ladder[-2:]
    floor = Rung("not repeatable (trial-to-trial scatter)", (), 0.123e-3, 0.0, (0.123e-3, 0.123e-3), floor=True)
    shown = Page(report(replace(diagnosis, ladder=(*diagnosis.ladder[:-1], floor, noise)))).text
    assert "0.123 mm" in shown and "0.123 mm most probable model" not in shown
    assert re.search(r"mm most probable model, on held-out trials", shown)
    value = re.search(r"([0-9.]+) mm most probable model", shown).group(1)
    assert float(value) == pytest.approx(1e3 * best.rms, rel=0.01)


def test_text_from_outside_is_text(page):
    assert "four <short> steps & a weight" in page.text


def test_it_needs_no_network_and_no_scripts(page, html):
    assert "script" not in {tag for tag, _ in page.tags}
    for tag, attributes in page.tags:
        for name in ("src", "href", "xlink:href", "srcset", "data", "action"):
            assert attributes.get(name, "#").startswith(("#", "data:")), (tag, attributes)
        assert not any(name.startswith("on") for name in attributes)
    assert "@import" not in html
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)\)", html))


def test_ids_are_unique_and_what_is_referred_to_is_there(page, html):
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) > 50
    assert len(ids) == len({*ids})
    assert {*re.findall(r"(?:url\(|href=\")#([^)\"]+)", html)} <= {*ids}


def test_every_colour_is_defined_for_light_and_dark_with_any_verdict(html):
    light, dark = re.findall(r":root \{([^}]*)\}", html)
    used = {*re.findall(r"var\(--(\w+)\)", html)}
    assert {"identified", "ink", "measured"} <= used
    for theme in (light, dark):
        assert used | {*STATUSES} <= {*re.findall(r"--(\w+):", theme)}
    assert "#0102" not in html


def test_every_verdict_has_a_headline():
    assert HEADLINES.keys() == {*STATUSES}


def test_rivals_are_shown_each_with_its_parameters_and_the_experiment_that_tells_them_apart(ambiguous):
    text = Page(report(ambiguous)).text
    assert "These recordings cannot tell apart: <a>, or b & c." in text
    assert "Alternative model: actuator lag" in text
    assert "actuator lag: time constant" in text
    assert text.index("Record next: the same steps with 50 g at the tip") < text.index("payload the same steps")


def test_too_little_to_go_on_still_gives_a_page(insufficient):
    text = Page(report(insufficient)).text
    assert "Not enough data" in text
    assert "the trial with the largest error of the declared model" in text
    assert "Candidate causes" not in text


def test_gaps_in_the_measurement_and_a_marker_that_was_never_seen_can_be_drawn(diagnosis):
    runs = [replace(run, measured=run.measured.copy()) for run in diagnosis.experiment.runs]
    blind = [index for index, _ in shown_runs(diagnosis)]
    for index in blind:
        runs[index].measured[5:20] = np.nan
        runs[index].measured[:, -1] = np.nan
    text = report(replace(diagnosis, experiment=replace(diagnosis.experiment, runs=tuple(runs), notes=("trial_09 is left out",))))
    assert ": marker mid" in text
    assert "trial_09 is left out" in text
    assert "NaN" not in text and ">nan" not in text


def test_what_was_mended_in_several_trials_is_said_once(diagnosis):
    runs = list(diagnosis.experiment.runs)
    for index, notes in enumerate([("tip: 3 of 50 samples removed", "clock mended"), ("tip: 2 of 51 samples removed",)]):
        trial = runs[index].trial
        runs[index] = replace(runs[index], trial=replace(trial, trajectory=replace(trial.trajectory, notes=notes)))
    noted = replace(diagnosis, experiment=replace(diagnosis.experiment, runs=tuple(runs), notes=("trial_09 is left out",)))
    assert _notes(noted) == ["trial_09 is left out", "tip: 5 of 101 samples removed (2 trials)", "clock mended (trial_01)"]


def test_the_same_diagnosis_gives_the_same_file(diagnosis, html, tmp_path):
    write_report(diagnosis, tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == html


def in_browser(folder, html, *arguments):
    """Return what headless Chromium prints for a page."""
    (folder / "page.html").write_text(html, encoding="utf-8")
    flags = ["--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'profile'}"]
    command = [CHROMIUM, *flags, *arguments, (folder / "page.html").as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout


@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium, which is not installed")
class TestInBrowser:
    @pytest.mark.parametrize(("scheme", "ink"), [("light", "rgb(28, 33, 38)"), ("dark", "rgb(230, 233, 236)")])
    def test_nothing_is_cut_off_and_the_verdict_is_large(self, html, tmp_path, scheme, ink):
        preferred = f"--blink-settings=preferredColorScheme={['dark', 'light'].index(scheme)}"
        dom = in_browser(tmp_path, html.replace("</body>", MEASURE), preferred, "--window-size=1000,900", "--dump-dom")
        facts = dict(re.findall(r'data-(\w+)="([^"]*)"', dom[: dom.index(">", dom.index("<html"))]))
        assert facts["cut"] == ""
        assert int(facts["width"]) <= 1000
        assert float(facts["sentence"].removesuffix("px")) >= 20
        assert facts["ink"] == ink

    def test_it_prints_on_a_few_pages_of_a4(self, html, tmp_path):
        in_browser(tmp_path, html, "--no-pdf-header-footer", f"--print-to-pdf={tmp_path / 'report.pdf'}")
        pdf = (tmp_path / "report.pdf").read_bytes()
        assert 2 <= len(re.findall(rb"/Type\s*/Page\b", pdf)) <= 5
        width, height = map(float, re.search(rb"/MediaBox\s*\[0 0 ([\d.]+) ([\d.]+)\]", pdf).groups())
        assert (width, height) == pytest.approx((595, 842), abs=1.5)


def test_options_of_hsr_sim_hold_the_fitted_stiffness_and_damping(diagnosis):
    best = diagnosis.search.best
    fit = replace(best.fit, values=1.2 * best.fit.values)  # factors that differ from 1
    (options,) = _model(replace(best, fit=fit), {1.11: 0.05}).options.values()
    words = dict(zip(options.split()[::2], options.split()[1::2], strict=True))
    assert float(words["--keq"]) == pytest.approx(1.11 * fit.named["keq_scale"], rel=1e-3)
    assert float(words["--damping"]) == pytest.approx(0.05 * fit.named["damping_scale"], rel=1e-3)
    assert fit.named["keq_scale"] > 1.1


def test_a_supply_has_a_section_with_its_numbers(diagnosis):
    text = Page(report(replace(diagnosis, supply=(SLOW,)))).text
    assert "Supply: from the command to what was measured" in text and "The supply is late" in text
    assert SLOW.fall.rounded[0] in text
    assert "Supply: from" not in Page(report(diagnosis)).text

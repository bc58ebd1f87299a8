"""What a program finds at the top of the package: paths and names accepted, short texts, tables and pictures."""

import sys

import pytest

import hsr_pin


@pytest.fixture(scope="module")
def diagnosis():
    return hsr_pin.diagnose("beam", effects=["viscoelastic"], max_effects=1, links=4, jobs=1)


def test_every_name_is_there():
    assert all(callable(getattr(hsr_pin, name)) for name in hsr_pin.__all__)
    assert {"fit", "diagnose", "diagnose_change", "simulate", "sample"} <= {*hsr_pin.__all__}


def test_a_dataset_is_a_mapping_of_its_trials():
    dataset = hsr_pin.sample()
    assert list(dataset) == [trial.name for trial in dataset.trials] and len(dataset) == 4
    assert dataset["trial_02"] is dataset.trials[1] and "trial_09" not in dataset
    assert hash(dataset) != hash(hsr_pin.sample()) and dataset != hsr_pin.sample()


def test_a_diagnosis_shows_its_verdict_first(diagnosis, tmp_path):
    assert len(repr(diagnosis)) < 1000 and diagnosis.verdict.sentence in repr(diagnosis)
    shown = diagnosis._repr_html_()
    assert shown.startswith("<h4>beam: ") and shown.count("<tr>") == len(diagnosis.ladder) + 1
    diagnosis.to_html(tmp_path / "report.html")
    assert "<!DOCTYPE html>" in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert diagnosis.to_json()["verdict"]["status"] == diagnosis.verdict.status


def test_its_picture_has_a_bar_for_each_model_and_each_set_of_causes(diagnosis):
    errors, causes = diagnosis.plot().axes
    assert [label.get_text() for label in errors.get_yticklabels()] == [rung.name for rung in diagnosis.ladder]
    assert sum(bar.get_width() for bar in causes.patches) == pytest.approx(1.0, abs=0.02)


def test_its_table_needs_pandas(diagnosis, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(hsr_pin.errors.MissingDependencyError, match="pip install pandas"):
        diagnosis.to_dataframe()


def test_its_table_has_a_row_for_each_fitted_model(diagnosis):
    pytest.importorskip("pandas")
    found = diagnosis.to_dataframe()
    assert len(found) == len(diagnosis.search.candidates)
    assert found["probability"].is_monotonic_decreasing


def test_a_fit_takes_a_name_and_tells_its_values():
    found = hsr_pin.fit("beam", links=4)
    assert repr(found).startswith("<Identification of beam: keq_scale ")
    assert found.plot().axes

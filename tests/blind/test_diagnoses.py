"""Written verdicts are kept; failed cases are diagnosed again."""

import json

from hsr_pin.blind.diagnoses import diagnose_case


def test_a_verdict_that_another_run_has_written_meanwhile_is_left_alone(tmp_path):
    file = tmp_path / "case_001.json"
    file.write_text('{"verdict": "of another run"}', encoding="utf-8")
    diagnose_case(tmp_path / "case_001", tmp_path, 0)  # the recording does not exist, so its diagnosis would fail
    assert file.read_text(encoding="utf-8") == '{"verdict": "of another run"}'


def test_a_case_that_failed_is_tried_again(tmp_path):
    file = tmp_path / "case_001.json"
    file.write_text('{"error": "of yesterday"}', encoding="utf-8")
    diagnose_case(tmp_path / "case_001", tmp_path, 0)
    assert "dataset.toml" in json.loads(file.read_text(encoding="utf-8"))["error"]

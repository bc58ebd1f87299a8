"""The oracle fits the true law like any other law."""

from __future__ import annotations

import pytest

from hsr_pin.blind.answers import Answer
from hsr_pin.blind.oracle import consult, read_oracle
from hsr_pin.recordings.write import write_dataset


def test_the_true_law_leaves_nothing_but_noise_and_is_asked_for_where_there_is_one(tmp_path, heavy_tip):
    write_dataset(heavy_tip, tmp_path / "case_001")
    answers = [
        Answer("case_001", "single", ("tip_mass",), "large", {}),
        Answer("case_002", "outside", ("wall",), "large", {}),
        Answer("case_003", "none", (), "", {}),
    ]
    calls: list[None] = []
    consult(tmp_path, tmp_path / "oracle", answers, advance=lambda: calls.append(None))
    found = read_oracle(tmp_path / "oracle")
    assert list(found) == ["case_001"] and len(calls) == 1
    assert found["case_001"] == pytest.approx(0.1 * 2**0.5, rel=0.1)  # [mm], on two axes

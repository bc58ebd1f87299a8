"""A plain table says much of its own mapping: what is guessed reads back, and brings the motion in."""

import numpy as np
import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.detect import read_capture, read_commands_of
from hsr_pin.recordings.importers.guess import guessed_mapping
from hsr_pin.recordings.importers.mapping import read_mapping


def table(path, header, separator=",", above=(), factor=1.0, clock=1.0):
    rows = []
    for n in range(40):
        bent = 0.3 * np.sin(n / 6) + 1e-9
        tip = factor * 0.24 * np.array([(1 - np.cos(bent)) / bent, 0.0, -np.sin(bent) / bent])
        rows.append(separator.join(f"{value:.6f}" for value in (clock * n / 50, 0, 0, 0, *tip, 100 + n, 180 - n, 21.5)))
    path.write_text("\n".join([*above, separator.join(header), *rows]) + "\n", encoding="utf-8")
    return path


FORMS = {
    "bars and brackets": (
        ["Time [ms]", "base x", "base y", "base z", "tip x (mm)", "tip y (mm)", "tip z (mm)", "p1", "p2", "T"],
        "|",
    ),
    "prefixes": (["t_ms", "x_base", "y_base", "z_base", "x_tip", "y_tip", "z_tip", "pressure 1", "pressure 2", "temp"], ";"),
    "letters": (["time", "basex", "basey", "basez", "tipx", "tipy", "tipz", "P1", "P2", "é"], ","),
}


@pytest.mark.parametrize("header, separator", FORMS.values(), ids=FORMS)
def test_a_guessed_mapping_brings_a_table_in(tmp_path, header, separator):
    path = table(
        tmp_path / "log.csv", header, separator, above=("# run 7", "") if separator == "," else (), factor=1e3, clock=1e3
    )
    (tmp_path / "map.toml").write_text(text := guessed_mapping(path), encoding="utf-8")
    mapping = read_mapping(tmp_path / "map.toml")
    capture = read_capture(path, None, mapping)
    assert capture.names == ("base", "tip")
    assert capture.rate == pytest.approx(50)
    assert np.abs(capture.positions[0, 1] - [0, 0, -0.24]).max() < 1e-6
    assert np.all(capture.positions[:, 0] == 0)  # a base that never leaves (0, 0, 0) was seen
    commands = read_commands_of(capture, None, mapping)
    assert np.abs(commands.values[0] - [1.0, 1.8]).max() < 1e-9  # kPa
    assert "# not used: " in text


def test_two_coordinates_are_a_plane(tmp_path):
    rows = [f"{n / 50},{n / 1000},{-0.24 + n / 1e4}" for n in range(20)]
    (tmp_path / "log.csv").write_text("t,tip_x,tip_y\n" + "\n".join(rows), encoding="utf-8")
    assert 'tip = ["tip_x", "", "tip_y"]' in guessed_mapping(tmp_path / "log.csv").replace('"tip" =', "tip =")


@pytest.mark.parametrize(
    "text, said", [("a,b\n1,2\n3,4\n", "no points found"), ("1,2\n3,4\n", "no column names"), ("a\nb\n", "no rows")]
)
def test_a_table_that_tells_nothing_is_refused(tmp_path, text, said):
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError, match=said):
        guessed_mapping(tmp_path / "log.csv")

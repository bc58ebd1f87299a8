"""Odd but sound recordings come in, and nothing that nobody said is written as if somebody had."""

import numpy as np
import pytest

from hsr_pin.errors import RecordingError
from hsr_pin.recordings.importers.assemble import import_recordings
from hsr_pin.recordings.importers.declared import declared_settings
from hsr_pin.recordings.importers.mapping import read_mapping
from hsr_pin.recordings.read import read_dataset
from hsr_pin.recordings.write import write_dataset

MAP = """
[time]
column = "t"
[space]
up = "+z"
[points]
base = ["bx", "by", "bz"]
tip = ["tx", "ty", "tz"]
[input]
tau = "tau"
[robot]
mass = 0.1
diameter = 0.02
keq = 1.0
"""
SECTIONS = """
[time]
column = "t"
[space]
up = "+z"
x = "+x"
origin = [0.0, 0.0, 0.0]
[points]
tip = ["tx", "ty", "tz"]
[robot]
mass = 0.1
diameter = 0.02
mount = "hanging"
bending = "space"
[[section]]
length = 0.1
keq = 1.0
[[section]]
length = 0.1
keq = 1.0
[[input]]
columns = ["tau"]
torque = [[0.1, 0.0, 0.0, 0.0]]
[[marker]]
name = "tip"
arc_length = 0.2
"""


@pytest.fixture
def bring(tmp_path):
    """Import a swinging arm from a plain table: of a step [s], with a column changed, and given settings."""

    def bring(text=MAP, step=0.02, separator=",", y="0.001", **given):
        rows = [separator.join(["t", "bx", "by", "bz", "tx", "ty", "tz", "tau"])]
        for n in range(60):
            bent = 0.5 * np.sin(n / 6) + 1e-9
            tip = (0.2 * (1 - np.cos(bent)) / bent, y, -0.2 * np.sin(bent) / bent)
            rows.append(separator.join(map(str, (n * step, 0, 0, 0, *tip, bent))))
        (tmp_path / "log.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
        (tmp_path / "map.toml").write_text(text, encoding="utf-8")
        settings = declared_settings(read_mapping(tmp_path / "map.toml"), **given)
        write_dataset(import_recordings([tmp_path / "log.csv"], settings).dataset, tmp_path / "arm")
        return read_dataset(tmp_path / "arm"), (tmp_path / "arm" / "dataset.toml").read_text(encoding="utf-8")

    return bring


def test_a_section_without_damping_stays_without(bring):
    dataset, text = bring(SECTIONS)
    assert "damping" not in text and dataset.trials[0].damping is None


def test_what_is_said_of_the_whole_arm_is_spread_over_its_sections(bring):
    dataset, text = bring(SECTIONS.replace("keq = 1.0\n", ""), keq=[0.7], damping=[0.05])
    assert (dataset.trials[0].keq, dataset.trials[0].damping) == (0.7, 0.05)
    assert text.count("keq = 1.4  # Nm/rad") == 2 and text.count("damping = 0.1  # Nm s/rad\n") == 2


def test_a_base_that_never_leaves_zero_was_seen_and_bars_separate(bring):
    dataset, _ = bring(separator="|")
    assert [marker.name for marker in dataset.markers] == ["base", "tip"]
    assert np.all(dataset.trials[0].trajectory.marker("base") == 0)


def test_a_coordinate_that_no_frame_has_is_that_of_a_plane(bring):
    dataset, text = bring(y="")
    assert np.all(dataset.trials[0].trajectory.marker("tip")[:, 1] == 0)
    assert "tip: y is missing in all frames and was set to 0" in text


def test_slow_motion_is_no_recording_in_milliseconds(bring):
    assert bring(step=0.56)[0].trials[0].trajectory.step == pytest.approx(0.56)
    with pytest.raises(RecordingError, match="if these are milliseconds"):
        bring(step=10.0)


@pytest.mark.parametrize(
    "empty, said", [("y", ""), ("z", "marker 'tip' has no z in any trial: expected x, y and z in the world")]
)
def test_a_dataset_without_y_is_in_the_plane_and_one_without_z_says_what_is_missing(folder_of_two, empty, said):
    folder = folder_of_two(empty)
    if said:
        with pytest.raises(RecordingError, match=said):
            read_dataset(folder)
    else:
        trajectory = read_dataset(folder).trials[0].trajectory
        assert (
            np.all(trajectory.marker("tip")[:, 1] == 0)
            and "tip: y is missing in all samples and was set to 0" in trajectory.notes
        )


@pytest.fixture
def folder_of_two(bring, tmp_path):
    """A dataset whose tip has two coordinates only."""

    def spoil(empty):
        bring()
        file = tmp_path / "arm" / "trial_01.csv"
        header, *rows = file.read_text(encoding="utf-8").splitlines()
        at = header.split(",").index(f"tip_{empty}")
        kept = [",".join("" if place == at else field for place, field in enumerate(row.split(","))) for row in rows]
        file.write_text("\n".join([header, *kept]) + "\n", encoding="utf-8")
        return tmp_path / "arm"

    return spoil

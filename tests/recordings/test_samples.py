"""The recordings that come with the package."""

import pytest

import hsr_pin
from hsr_pin.cli.command import run
from hsr_pin.cli.fit import command
from hsr_pin.errors import RecordingError
from hsr_pin.recordings.read import sample
from hsr_pin.recordings.samples import FIRST, ROBOTS, SAMPLES, sample_folder
from hsr_pin.recordings.write import write_dataset


@pytest.mark.parametrize("name", SAMPLES)
def test_every_sample_is_found_by_its_name_with_its_source(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    dataset = hsr_pin.read_dataset(name)
    assert dataset.name == name and dataset.description
    assert hsr_pin.sample(name).trials[0].name == dataset.trials[0].name
    assert (sample_folder(name) / "SOURCE.txt").is_file()
    assert (sample_folder(name) / "LICENSE").is_file() == SAMPLES[name].startswith("real")


def test_all_samples_together_are_small():
    folder = sample_folder("beam").parent
    assert sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) < 1e6
    assert {path.name for path in folder.iterdir()} == {*SAMPLES, *ROBOTS}


def test_the_first_sample_has_a_short_name_and_a_folder_of_ones_own_comes_first(tmp_path, monkeypatch):
    assert sample().name == sample(FIRST).name == next(iter(SAMPLES))
    monkeypatch.chdir(tmp_path)
    write_dataset(sample("valve-arm"), tmp_path / "beam")
    assert hsr_pin.read_dataset("beam").name == "valve-arm"


def test_an_unknown_name_lists_the_samples(capsys):
    with pytest.raises(RecordingError, match="beam, beam-empty"):
        sample("trunk")
    assert run(command, ["no-such-arm"]) == 2
    assert "samples can be given by name: beam, " in capsys.readouterr().err


def test_the_samples_are_listed(capsys):
    assert run(command, ["--list-samples"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == [*SAMPLES]
